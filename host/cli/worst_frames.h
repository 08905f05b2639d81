// Which frames of a bake look worst, by its metrics.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fascicle::cli {

// One frame's row of metrics.csv.
struct FrameScore {
  std::uint64_t frame = 0;
  // The column `look`: 1 is the limit. Nothing where the bake has none.
  std::optional<double> look;
  // The largest of the columns `look_NAME`, as "NAME"; empty without any or where all are 0.
  std::string cause;
  std::string joint;  // the column `worst_joint`: where
  // Larger is worse: the look score; without one how many tetrahedra are inside out that skinning does not
  // turn, and among equals the largest lag of a layer.
  std::pair<double, double> badness;
};

struct FrameScores {
  std::vector<FrameScore> frames;  // in the file's order
  bool has_look = false;
};

// Whether the bake in `folder` has a metrics.csv.
bool has_metrics(const std::filesystem::path& folder);

// Of the bake in `folder`. Throws bake::BakeError where there is no metrics.csv or it is not one.
FrameScores read_frame_scores(const std::filesystem::path& folder);

// The `count` worst of the first `frame_count` frames, worst first and of equals the earlier; none within
// `distance` frames of another, so there may be fewer.
std::vector<std::uint64_t> worst_frames(const FrameScores& scores, std::uint64_t frame_count,
                                        std::uint64_t count, std::uint64_t distance);

// A distance that spreads `count` frames over a clip and yet lets several fall into one bad stretch.
std::uint64_t frames_apart(std::uint64_t frame_count, std::uint64_t count);

}  // namespace fascicle::cli
