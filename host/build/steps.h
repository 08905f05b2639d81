// How many substeps a frame takes, and how many iterations a substep: chosen from the stiffness and from how
// accurate the motion shall be.
#pragma once

#include <cstdint>
#include <string>

#include "host/build/build.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// What stepping makes of the fastest of the layers' lowest modes, by BDF2's own errors with p = 2 pi f h; 0
// where none is known. And what the iterations leave of the stiffest layer's smoothest motion, by its mean K
// H^2/m.
struct StepError {
  double slower = 0.0;    // p^2/3, share of the frequency
  double lost = 0.0;      // 1 - exp(-2 pi p^3/4), share of the swing, a period
  double residual = 0.0;  // share of a substep's change
};

// How a frame is stepped, and why.
struct Steps {
  std::uint32_t substeps = 1;     // a frame
  std::uint32_t iterations = 20;  // an implicit substep
  std::string reason;             // "the scene says so", or what asks for so many substeps
  StepError error = {};           // of an implicit model
};

// The scene's substeps and iterations, or where it says "auto":
//
// Explicit: so many substeps that an alpha means the same stiffness at every frame rate and spacing, at least
// 4, at most most_explicit_auto_substeps, which is a warning.
//
// Implicit: the least substeps with which a second has as many as the scene's quality asks for, and in a body
// that no skeleton moves 2 pi f h <= longest_phase(quality) for the lowest mode f of every layer. (A
// skeleton's motion is slow beside the modes of flesh that hangs on it: those of a man's layers are at 32
// Hz.) Then the least iterations that resolve K H^2/m (model::resolved_stiffness) and leave a twentieth: of a
// character its mean over each layer, of another body that of the stiffest vertex, at most
// most_auto_iterations. Where those do not resolve the mean, more substeps, at most most_auto_substeps, which
// is a warning; quality alone may ask for 1000. The model knows the frequencies.
//
// A scene that states fewer is warned, with the error to expect where it is known: a character with less than
// 240 substeps a second, another body whose lowest mode is known and not stepped, and iterations that leave
// more than a twentieth.
Steps choose_steps(const scene::Scene& scene, const model::Model& model, Report& report);

// Whether choose_steps needs the layers' lowest modes.
bool steps_need_lowest_modes(const scene::SolverSettings& solver, const model::Model& model);

double steps_per_second(scene::Quality quality);
double longest_phase(scene::Quality quality);

inline constexpr std::uint32_t most_auto_substeps = 128, most_explicit_auto_substeps = 256;
inline constexpr std::uint32_t most_auto_iterations = 20;

}  // namespace fascicle::build
