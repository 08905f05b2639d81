// Finds the frames of a bake that look worst, from its metrics.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fascicle::cli {

// One row of metrics.csv.
struct FrameScore {
  std::uint64_t frame = 0;
  // The column `look`: 1 is the limit. nullopt if the bake has none.
  std::optional<double> look;
  // NAME of the largest column `look_NAME`; empty if there is none or all are 0.
  std::string cause;
  std::string joint;  // where: the column `worst_joint`
  // Larger is worse: the look score, or without one the number of inverted tetrahedra beyond those that
  // skinning inverts, then the largest lag of a layer.
  std::pair<double, double> badness;
};

struct FrameScores {
  std::vector<FrameScore> frames;  // in the file's order
  bool has_look = false;
};

// Whether the bake in `folder` has a metrics.csv.
bool has_metrics(const std::filesystem::path& folder);

// For the bake in `folder`. Throws bake::BakeError if there is no valid metrics.csv.
FrameScores read_frame_scores(const std::filesystem::path& folder);

// The `count` worst of the first `frame_count` frames, worst first, and the earlier first if equal. No two
// are within `distance` frames of each other, so there may be fewer.
std::vector<std::uint64_t> worst_frames(const FrameScores& scores, std::uint64_t frame_count,
                                        std::uint64_t count, std::uint64_t distance);

// A distance that spreads `count` frames over a clip, yet allows several within one bad stretch.
std::uint64_t frames_apart(std::uint64_t frame_count, std::uint64_t count);

}  // namespace fascicle::cli
