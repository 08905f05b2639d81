// How motion is computed: chosen by scenes, implemented by solvers.
#pragma once

#include "host/base/names.h"

namespace fascicle::base {

// explicit_step: the paper's (4)(5), with stiffness given as alpha per substep. implicit_step: the fixed
// point q = y + a (g(q) - y), with stiffness given as Young's modulus (docs/design/integrators.md).
enum class Integrator { explicit_step, implicit_step };
constexpr auto names_of(Integrator) {
  return std::array{"explicit", "implicit"};
}

// How the rotation of equation (9) is computed.
enum class Rotation { qcp, mueller2016 };
constexpr auto names_of(Rotation) {
  return std::array{"qcp", "mueller2016"};
}

// Equation (12): symmetric in the sign of the fibre, or as printed, which also leaves momentum unscaled.
enum class WeightForm { symmetric, kaneda2017 };
constexpr auto names_of(WeightForm) {
  return std::array{"symmetric", "kaneda2017"};
}

}  // namespace fascicle::base
