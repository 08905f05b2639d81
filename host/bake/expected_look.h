// A bake's look before it is baked: an estimate of how far the clip will swing the flesh of each joint and,
// if that comes near the limit, a trial bake of a few frames. `bake` warns if those look wrong, and
// `--dry-run` prints both.
//
// Flesh on a bone is modelled as a column, as deep as the distance from the skin to what follows the
// skeleton, sheared by its own weight. Under an acceleration a its skin moves by a c, c = integral of rho (D
// - s)/G over the depth s, G a third of Young's modulus. With the layers' damping, each joint's flesh becomes
// an oscillator, which is stepped through the clip. Its largest swing divided by the thickness there
// estimates what motion adds to LookMeasure::distance, which also includes static differences between flesh
// and skinning in a pose, as at a raised upper arm. docs/design/crushed-flesh.md compares estimates with
// measurements.
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
  double score = 0.0;       // like LookScore's: 1 is the limit
  std::uint32_t joint = 0;  // whose flesh will swing furthest
  std::uint64_t frame = 0;  // in which it will do so
  std::uint32_t layer = 0;  // the most compliant one there
  double stiffer = 1.0;     // stiffening all layers by this factor brings the score to 1 or below
};

// Empty without free flesh. `body`: from look_body_of. Runs through all substeps of one cycle, and
// asks `goes_on` in each frame and while it seeks the remedy: empty once it is false.
std::optional<ExpectedLook> expected_look(const scene::Scene& scene, const model::Model& model,
                                          const LookBody& body, drive::DriveSource& drives,
                                          const drive::DriveSource::GoesOn& goes_on = {});

// One line that names the layer, the joint and a remedy.
std::string expected_look_warning(const scene::Scene& scene, const model::Model& model,
                                  const ExpectedLook& expected);

// The estimate covers only swinging. If it comes near the limit, a few frames around the largest swing are
// baked and checked for everything visible: skin that stretches, crosses itself or turns inside out.
inline constexpr double least_tried_score = 0.25;
inline constexpr double tried_before = 0.2, tried_after = 0.1;  // s, before and after the expected frame
// Frames further apart than that show none of it, and each takes long.
inline bool can_try_look(const scene::Scene& scene) {
  return scene.fps * tried_before >= 1.0;
}

struct TriedFrames {
  std::uint64_t first = 0, last = 0;  // frames (first, last]
  std::uint64_t settling = 0;  // the first so many of them are not judged, unless the clip begins there
  bool has_lead_in = false;    // if the clip begins there, what the bake simulates before it comes first, but
                               // for the cycles of a seamless loop
};
// Those around frame `frame`.
TriedFrames frames_to_try(const scene::Scene& scene, std::uint64_t frame);

struct TriedLook {
  std::uint64_t first = 0, last = 0;  // frames (first, last] were baked
  LookScore worst;
  LookMeasure cause = LookMeasure::stretch;
  std::uint64_t frame = 0;  // with the worst score
  std::uint64_t frames_over = 0;
  double driven = 0.0;    // for look_warning
  bool is_finite = true;  // false: it ended with positions that are not finite, which the bake will report
};

// One line on a look over the limit: what was seen, where, and a remedy.
std::string tried_look_warning(const scene::Scene& scene, const TriedLook& tried);

// Leaves the solver in the initial state. Passes on the solver's exceptions. `goes_on`, if given, is called
// before each frame, when `last` is still the last of `frames`; the trial ends when it returns false.
TriedLook try_look(const scene::Scene& scene, const model::Model& model, const LookBody& body,
                   drive::DriveSource& drives, model::Solver& solver, const TriedFrames& frames,
                   const std::function<bool(const TriedLook&)>& goes_on = {});

}  // namespace fascicle::bake
