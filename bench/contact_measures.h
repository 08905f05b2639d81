// Measurements of a baked scene, independent of the solver.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::bench {

// With positions, velocities and, for a character, skinned positions.
using Frames = std::vector<model::Frame>;
// Values by name, with the unit.
using Measures = std::vector<std::pair<std::string, double>>;

inline constexpr const char* force_name = "force on the upper plane, N";

// `force`: force_on_top.
Measures measure_squeeze(const scene::Scene& scene, const model::Model& model, drive::DriveSource& drives,
                         const Frames& frames, double force);
Measures measure_drop(const scene::Scene& scene, const model::Model& model, drive::DriveSource& drives,
                      const Frames& frames);
Measures measure_crouch(const scene::Scene& scene, const model::Model& model, const Frames& frames);
// `places`: for each frame, Frame::positions or Frame::skinned.
Measures measure_overlap(const model::Model& model, const Frames& frames,
                         std::vector<float> model::Frame::*places);

// For an implicit solver of fascicle's, N: mass x stiffness x (goal - position) of each vertex, in one more
// frame.
std::vector<double> flesh_forces(const model::Model& model, model::Solver& solver, const model::Drive& drive);
// The force of a bar on its upper plane, N.
double force_on_top(const model::Model& model, const std::vector<double>& forces);
// The same from rod theory: E x area x strain.
double rod_force(const scene::Scene& scene);

// m; the largest distance from the skeleton of a vertex that follows it, in any frame.
double furthest_from_skeleton(const model::Model& model, const Frames& frames);

}  // namespace fascicle::bench
