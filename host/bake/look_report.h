// Summary of a finished bake's look: the worst frame, and a warning for each cause over its limit.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/look.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

struct LookSummary {
  double worst = 0.0;  // the largest score of any frame; 1 is the limit
  std::uint64_t frame = 0;
  std::string joint;                  // where; empty if no frame scores above 0
  std::string cause;                  // a LookMeasure's name; empty likewise
  std::uint64_t frames_over = 0;      // with a score above 1
  std::vector<std::string> warnings;  // worst first, one per cause
};

// For a bake whose metrics.csv is complete. `frame_at` returns a frame with positions and skinned; it is
// called for the worst frame of each cause over its limit and the two frames before. Empty if there is no
// look to measure.
std::optional<LookSummary> look_summary(const std::filesystem::path& folder, const model::Model& model,
                                        const rig::Character* rig, double fps,
                                        const std::function<model::Frame(std::uint64_t)>& frame_at);

// One line for the log: what was seen, where, over which limit, and a remedy. `driven`, m: how deep the clip
// drives flesh into other flesh at or shortly before that frame, if that is too deep for contact; else 0.
std::string look_warning(LookMeasure measure, const LookScore& score, const std::string& joint,
                         std::uint64_t frame, std::uint64_t frames_over, double driven = 0.0);

// Contact pushes flesh out of other flesh. Where skinning alone lays it deeper than this share of the body's
// extent, as when an arm passes through a belly, no shape of the flesh looks right, and stiffer flesh looks
// worse: the limbs' bones stay where they are.
inline constexpr double deepest_for_contact = 0.04;

}  // namespace fascicle::bake
