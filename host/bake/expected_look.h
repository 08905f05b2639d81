// What the look of a bake will come to, before it is baked: how far the clip will swing the flesh of each
// joint.
//
// Flesh on a bone is a column that its own weight shears, as deep as the skin lies from what follows the
// skeleton: under an acceleration a its skin moves by a c, c = integral of rho (D - s)/G over the depth s, G
// a third of Young's modulus. So much, and the damping of its layers, makes of each joint's flesh an
// oscillator, which is stepped through the clip. Its largest swing over the thickness there is what
// LookMeasure::distance will see of motion. Where flesh and skinning differ at rest in a pose, as at a raised
// upper arm, it sees more. docs/architecture.md has estimates beside what was then measured.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/drive_source.h"
#include "host/bake/look_body.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

struct ExpectedLook {
  double score = 0.0;       // as LookScore's: 1 is the limit
  std::uint32_t joint = 0;  // whose flesh swings furthest
  std::uint64_t frame = 0;  // in which it will
  std::uint32_t layer = 0;  // that yields most there
  double stiffer = 1.0;     // by so much stiffer layers score 1 at most; 1 where they do already
};

// Nothing where there is no look to take, or no free flesh. Goes through all substeps of one cycle.
std::optional<ExpectedLook> expected_look(const scene::Scene& scene, const model::Model& model,
                                          DriveSource& drives);

// One line that names the layer, the joint and what helps.
std::string expected_look_warning(const scene::Scene& scene, const model::Model& model,
                                  const ExpectedLook& expected);

}  // namespace fascicle::bake
