#include "host/cli/worst_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "host/bake/bake.h"
#include "host/bake/outputs.h"
#include "host/base/csv.h"
#include "host/base/file.h"
#include "host/cli/metrics_table.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

// NaN counts as the worst possible value.
double badness_of(double value) {
  return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
}

}  // namespace

bool has_metrics(const fs::path& folder) {
  return fs::exists(folder / bake::metrics_name);
}

FrameScores read_frame_scores(const fs::path& folder) {
  const fs::path path = folder / bake::metrics_name;
  std::istringstream file(base::read_input_if_there(path, base::most_metrics_bytes).value_or(""));
  std::string line;
  if (!std::getline(file, line))
    throw bake::BakeError(
        path.string() +
        ": missing or empty, so the worst frames are unknown; give --frame or --sheet, or bake again");
  const std::vector<std::string> columns = base::csv_columns(line, path);
  if (columns.front() != "frame")
    throw bake::BakeError(path.string() + ": its first column is not `frame`; bake again");
  FrameScores scores;
  scores.has_look = std::count(columns.begin(), columns.end(), "look") > 0;
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = base::csv_fields(line);
    const std::optional<double> number = csv_number(fields.front());
    // The last line of a running bake may be incomplete.
    if (fields.size() < columns.size() || !number || !(*number >= 0.0 && *number < 1e15)) continue;
    FrameScore score;
    score.frame = static_cast<std::uint64_t>(*number);
    double inverted = 0.0, lag = 0.0, cause = 0.0;
    for (std::size_t c = 1; c < columns.size(); ++c) {
      const std::string& name = columns[c];
      if (name == bake::look_joint_column) score.joint = base::csv_text(fields[c]);
      const std::optional<double> read = csv_number(fields[c]);
      if (!read || name == bake::look_joint_column) continue;
      const double value = badness_of(*read);
      if (name == "look") score.look = value;
      if (name == "inverted") inverted += value;
      if (name == "inverted_skinned") inverted -= value;
      if (name.starts_with("lag_")) lag = std::max(lag, value);
      if (name.starts_with("look_") && value > cause) {
        cause = value;
        score.cause = name.substr(5);
      }
    }
    // Infinity less infinity is no number.
    score.badness = scores.has_look ? std::pair(score.look.value_or(0.0), 0.0)
                                    : std::pair(std::max(badness_of(inverted), 0.0), lag);
    scores.frames.push_back(std::move(score));
  }
  return scores;
}

std::uint64_t frames_apart(std::uint64_t frame_count, std::uint64_t count) {
  return std::max<std::uint64_t>(3, frame_count / (4 * std::max<std::uint64_t>(count, 1)));
}

std::vector<std::uint64_t> worst_frames(const FrameScores& scores, std::uint64_t frame_count,
                                        std::uint64_t count, std::uint64_t distance) {
  std::vector<const FrameScore*> order;
  for (const FrameScore& score : scores.frames)
    if (score.frame < frame_count) order.push_back(&score);
  std::sort(order.begin(), order.end(), [](const FrameScore* a, const FrameScore* b) {
    return a->badness != b->badness ? a->badness > b->badness : a->frame < b->frame;
  });
  std::vector<std::uint64_t> chosen;
  for (const FrameScore* score : order) {
    if (chosen.size() == count) break;
    const bool is_near = std::any_of(chosen.begin(), chosen.end(), [&](std::uint64_t k) {
      return (k > score->frame ? k - score->frame : score->frame - k) <= distance;
    });
    if (!is_near) chosen.push_back(score->frame);
  }
  return chosen;
}

}  // namespace fascicle::cli
