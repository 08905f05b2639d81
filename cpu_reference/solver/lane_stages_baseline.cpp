// Stages in lanes with the architecture's baseline instructions: four lanes of SSE2 or NEON.
#include <cstddef>
#include <utility>

#include "cpu_reference/solver/lane_stages.h"
#define KERNEL_FUNCTION \
  template <class Real> \
  [[gnu::always_inline]] inline
#include "shaders/kernel/contact.inc"
#include "shaders/kernel/goal.inc"
#include "shaders/kernel/integrate.inc"
#include "shaders/kernel/limit.inc"
#include "shaders/kernel/predict.inc"
#include "shaders/kernel/region.inc"
#include "shaders/kernel/relax.inc"
#include "shaders/kernel/skin.inc"
#include "shaders/kernel/tie.inc"
#include "shaders/kernel/volume.inc"

#define FASCICLE_LANES 4
#include "cpu_reference/solver/lane_stages.inc"

namespace fascicle::cpu_reference {

const LaneStages* baseline_lane_stages() {
  return &stages_in_lanes;
}

}  // namespace fascicle::cpu_reference
