// A bake's look before it is baked: an estimate of how far the clip will swing the flesh of each joint and,
// where that comes near the limit, a few frames that are tried. `bake` warns where those look wrong, and
// `--dry-run` prints both.
//
// Flesh on a bone is a column, as deep as the skin lies from what follows the skeleton, and its own weight
// shears it. Under an acceleration a its skin moves by a c, c = integral of rho (D - s)/G over the depth s, G
// a third of Young's modulus. With the damping of the layers this makes an oscillator of each joint's flesh,
// which is stepped through the clip. Its largest swing over the thickness there estimates what motion adds to
// LookMeasure::distance, which also sees where flesh and skinning differ at rest in a pose, as at a raised
// upper arm. docs/design/crushed-flesh.md compares estimates with what was then measured.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/look.h"
#include "host/bake/look_body.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

struct ExpectedLook {
  double score = 0.0;       // as LookScore's: 1 is the limit
  std::uint32_t joint = 0;  // whose flesh swings furthest
  std::uint64_t frame = 0;  // in which it will
  std::uint32_t layer = 0;  // that yields most there
  double stiffer = 1.0;     // layers stiffer by this factor score at most 1; 1 if they do already
};

// Nothing where there is no free flesh. `body`: look_body_of. Goes through all substeps of one cycle.
std::optional<ExpectedLook> expected_look(const scene::Scene& scene, const model::Model& model,
                                          const LookBody& body, drive::DriveSource& drives);

// One line that names the layer, the joint and what helps.
std::string expected_look_warning(const scene::Scene& scene, const model::Model& model,
                                  const ExpectedLook& expected);

// The estimate knows of swinging alone. Where it comes near the limit, a few frames around the largest swing
// are baked for a look at all that there is to see: skin that stretches, crosses itself or turns inside out.
inline constexpr double least_tried_score = 0.25;
inline constexpr double tried_before = 0.2, tried_after = 0.1;  // s, before and after that frame
// Frames that lie further apart than that show none of it, and each takes long.
inline bool can_try_look(const scene::Scene& scene) {
  return scene.fps * tried_before >= 1.0;
}

struct TriedLook {
  std::uint64_t first = 0, last = 0;  // frames (first, last] were baked
  LookScore worst;
  LookMeasure cause = LookMeasure::stretch;
  std::uint64_t frame = 0;  // of the worst score
  std::uint64_t frames_over = 0;
};

// Of a look over the limit, one line: what was seen, where, and what helps.
std::string tried_look_warning(const scene::Scene& scene, const TriedLook& tried);

// Leaves the solver in the initial state. What it throws is the solver's. `goes_on`, if any, is asked before
// each frame, and false ends it there.
TriedLook try_look(const scene::Scene& scene, const model::Model& model, const LookBody& body,
                   drive::DriveSource& drives, model::Solver& solver, std::uint64_t frame,
                   const std::function<bool(const TriedLook&)>& goes_on = {});

}  // namespace fascicle::bake
