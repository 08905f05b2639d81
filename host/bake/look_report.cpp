#include "host/bake/look_report.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "host/bake/outputs.h"
#include "host/base/csv.h"
#include "host/base/file.h"
#include "host/base/text.h"
#include "host/formats/formats.h"

namespace fascicle::bake {

namespace {

std::optional<std::vector<std::string>> next_row(std::istream& in) {
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  return base::csv_fields(line);
}

template <class Number>
Number number_in(const std::string& text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

struct Peak {
  double score = 0.0;
  std::uint64_t frame = 0, frames_over = 0;
};

// Flesh that contact has pushed aside takes about this long to come back, s.
constexpr double after_contact = 0.5;

}  // namespace

std::string look_warning(LookMeasure measure, const LookScore& score, const std::string& joint,
                         std::uint64_t frame, std::uint64_t frames_over, double driven) {
  const std::string at = "joint \"" + joint + "\"", value = base::short_text(score.value);
  std::string seen, help;
  switch (measure) {
    case LookMeasure::stretch:
      seen = "the skin at " + at + " is stretched to " + value + " times what skinning does";
      help =
          "skin that should separate there may be joined, or the flesh is too soft: try a larger "
          "--cage-detail if the skin is in a cage, or make its layer stiffer (a lower --softness)";
      break;
    case LookMeasure::crossing:
      seen = value + " triangles, most at " + at + ", cross others that skinning keeps apart";
      help =
          "the flesh is too soft for this motion: make its layer stiffer (a lower --softness), or raise its "
          "damping";
      break;
    case LookMeasure::distance:
      seen = "the skin at " + at + " is " + value + " of the body's thickness away from skinning";
      help =
          "its flesh is too soft, or no bone holds it: make its layer stiffer (a lower --softness), or name "
          "the joint, or the free ones below it (`fascicle inspect` lists them), in [skeleton] bones or "
          "kinematic";
      break;
    case LookMeasure::rigid:
      seen = "a part that only " + at + " moves is strained by " + value;
      help = "the bake treats it as flesh: name the joint in [skeleton] kinematic";
      break;
    case LookMeasure::jump:
      seen = "the skin at " + at + " jumps by " + value + " of the body's thickness within one frame";
      help =
          "the clip jumps there, or the flesh is too soft for it: look at the clip's keys, or "
          "lower inertia_scale of its layer";
      break;
    case LookMeasure::inverted:
      seen = value + " tetrahedra, most at " + at + ", are inside out";
      help =
          "the flesh is too soft for this motion: make its layer stiffer (a lower --softness), or raise its "
          "volume";
      break;
  }
  // Rigid parts feel no contact.
  if (driven > 0.0 && measure != LookMeasure::rigid)
    help = "the clip drives flesh " + base::short_text(driven) +
           " m into other flesh, and contact pushes it out: keep these parts apart in the clip, or leave "
           "their contact out ([contact] ignore, or --set contact.self=false for all)";
  // A share of the triangles or tetrahedra is the limit of a count.
  const bool is_count = measure == LookMeasure::crossing || measure == LookMeasure::inverted;
  const std::string limit = is_count
                                ? base::number_text(static_cast<std::uint64_t>(std::max(0.0, score.limit)))
                                : base::short_text(score.limit);
  return "look: frame " + base::number_text(frame) + ": " + seen + " (limit " + limit + "; " +
         base::number_text(frames_over) + (frames_over == 1 ? " frame is" : " frames are") + " over); " +
         help;
}

std::optional<LookSummary> look_summary(const std::filesystem::path& folder, const model::Model& model,
                                        const rig::Character* rig, double fps,
                                        const std::function<model::Frame(std::uint64_t)>& frame_at) {
  if (!has_look(model)) return std::nullopt;
  std::istringstream file(
      base::read_input_if_there(folder / metrics_name, base::most_metrics_bytes).value_or(""));
  const auto header = next_row(file);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(header->begin(), header->end(), name) - header->begin());
  };
  if (!header) return std::nullopt;
  const std::size_t worst = column(look_column), joint = column(look_joint_column);
  if (worst == header->size() || joint == header->size()) return std::nullopt;
  std::array<std::size_t, look_measures> columns{};
  for (std::size_t m = 0; m < look_measures; ++m)
    columns[m] = column(std::string(look_column) + '_' + name_of(static_cast<LookMeasure>(m)));
  if (std::find(columns.begin(), columns.end(), header->size()) != columns.end()) return std::nullopt;
  const std::size_t overlap = column(deepest_skinned_column);
  std::vector<double> driven;  // m, per frame

  LookSummary summary;
  std::array<Peak, look_measures> peaks;
  while (const auto row = next_row(file)) {
    if (row->size() != header->size()) break;
    const auto frame = number_in<std::uint64_t>((*row)[0]);
    const auto score = number_in<double>((*row)[worst]);
    if (score > 1.0) ++summary.frames_over;
    driven.push_back(overlap < row->size() ? number_in<double>((*row)[overlap]) : 0.0);
    for (std::size_t m = 0; m < look_measures; ++m) {
      const auto of_measure = number_in<double>((*row)[columns[m]]);
      if (of_measure > 1.0) ++peaks[m].frames_over;
      if (of_measure > peaks[m].score) peaks[m] = {of_measure, frame, peaks[m].frames_over};
      if (of_measure == score && score > summary.worst) {
        summary.worst = score;
        summary.frame = frame;
        summary.joint = base::csv_text((*row)[joint]);
        summary.cause = name_of(static_cast<LookMeasure>(m));
      }
    }
  }
  if (summary.frames_over == 0) return summary;

  std::vector<std::size_t> over;
  for (std::size_t m = 0; m < look_measures; ++m)
    if (peaks[m].score > 1.0) over.push_back(m);
  std::stable_sort(over.begin(), over.end(),
                   [&](std::size_t a, std::size_t b) { return peaks[a].score > peaks[b].score; });
  const LookBody body = look_body(model, rig);
  const double deepest = deepest_for_contact * model::extent(model);
  const auto driven_before = [&](std::uint64_t frame) {
    if (frame >= driven.size()) return 0.0;
    const auto last = driven.begin() + static_cast<std::ptrdiff_t>(frame);
    const auto frames = static_cast<std::ptrdiff_t>(std::ceil(after_contact * fps));
    const double most = *std::max_element(last - std::min(frames, last - driven.begin()), last + 1);
    return most > deepest ? most : 0.0;
  };
  for (const std::size_t m : over) {
    Look look(model, body, fps);
    const std::uint64_t frame = peaks[m].frame;
    for (std::uint64_t k = frame - std::min<std::uint64_t>(frame, 2); k < frame; ++k)
      look.remember(frame_at(k));
    const LookScore score = look.of(frame_at(frame)).of[m];
    summary.warnings.push_back(look_warning(static_cast<LookMeasure>(m), score, body.joint_names[score.joint],
                                            frame, peaks[m].frames_over, driven_before(frame)));
  }
  return summary;
}

}  // namespace fascicle::bake
