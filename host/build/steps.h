// How many substeps a frame takes, and how many iterations a substep takes, from the stiffness and the
// requested accuracy of the motion.
#pragma once

#include <cstdint>
#include <string>

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// The stepping error of the highest of the layers' lowest modes, from BDF2's own errors with p = 2 pi f h; 0
// if no mode is known. And the iterations' residual for the smoothest motion of the stiffest layer, from its
// mean K H^2/m.
struct StepError {
  double slower = 0.0;    // p^2/3, share of the frequency
  double lost = 0.0;      // 1 - exp(-2 pi p^3/4), share of the amplitude, per period
  double residual = 0.0;  // share of a substep's change
};

// How a frame is stepped, and the reason.
struct Steps {
  std::uint32_t substeps = 1;     // per frame
  std::uint32_t iterations = 20;  // per implicit substep
  std::string reason;             // "the value of solver.substeps", or what requires so many substeps
  StepError error = {};           // of an implicit model
};

// The scene's substeps and iterations. For those that are "auto":
//
// Explicit: enough substeps that an alpha means the same stiffness at every frame rate and spacing, at least
// 4 and at most most_explicit_auto_substeps; needing more is a warning.
//
// Implicit: the fewest substeps that give the rate per second required by the scene's quality. In a body that
// no skeleton moves, they must also keep 2 pi f h <= longest_phase(quality) for the lowest mode f of every
// layer. (A skeleton's motion is slow compared with the modes of the flesh on it: those of a man's layers are
// at 32 Hz.) Then the fewest iterations that resolve K H^2/m (model::resolved_stiffness) and leave a
// twentieth, for a character of a step without viscosity: for a character its mean over each layer, for
// another body that of the stiffest vertex, at most most_auto_iterations. If those do not resolve the mean,
// there are more substeps. The flesh gets at most most_auto_substeps; needing more is a warning. Quality
// alone may require up to 1000. The model must have the frequencies.
//
// Warns of a scene that states too few, with the expected error if it is known: fewer than 240 substeps per
// second for a character, a lowest mode that is known but not resolved for another body, and iterations that
// leave more than a twentieth.
Steps choose_steps(const scene::Scene& scene, const model::Model& model, Report& report);

// Whether choose_steps needs the layers' lowest modes.
bool steps_need_lowest_modes(const scene::SolverSettings& solver, const model::Model& model);

double steps_per_second(scene::Quality quality);
double longest_phase(scene::Quality quality);

inline constexpr std::uint32_t most_auto_substeps = 128, most_explicit_auto_substeps = 256;
inline constexpr std::uint32_t most_auto_iterations = 20;

}  // namespace fascicle::build
