// The stages of a substep on the CPU, over a range of vertices (regions, render vertices). Only indexing: the
// arithmetic is in shaders/kernel. Ranges may run on any threads: what a stage reads of other vertices, an
// earlier stage wrote (region reads positions of its one-ring, goal and update read transforms), and what it
// writes over (rotations, velocities, positions) only the vertex itself reads in that stage.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "shaders/shared.h"

namespace fascicle::cpu_reference {

// What changes from substep to substep. Sizes as in State and stage_width; working units.
struct Fields {
  std::vector<float> positions;           // 3n
  std::vector<float> velocities;          // 3n
  std::vector<float> predicted;           // 3n: velocities with the external forces in; implicit: y
  std::vector<float> rotations;           // 4n
  std::vector<float> transforms;          // 12n: linear (9), translation (3) of each region
  std::vector<float> goals;               // 3n
  std::vector<float> skinned;             // 3n, empty without a skeleton
  std::vector<float> skinned_before;      // 3n, the same of the substep before
  std::vector<float> skinned_velocities;  // 3n: u of the substep before, empty where no stage needs it
  std::vector<float> gravity;             // 3n: the bones' change of gravity, empty without a skeleton
  std::vector<float> surface;             // 3m
  // Of an implicit model, else empty.
  std::vector<float> positions_before;   // 3n, a substep before
  std::vector<float> velocities_before;  // 3n
  std::vector<float> begun;              // 3n: positions where the substep began
  std::vector<float> iterate_before;     // 3n: the last iteration but one
};

struct Range {
  std::uint32_t first, last;
};

// One substep's uniform values and this substep's bones, muscles and forces.
struct SubstepInput {
  shader::Substep step{};
  std::span<const shader::Bone> bones;
  std::span<const shader::Muscle> muscles;
  std::span<const shader::Force> forces;
  std::span<const float> decay;
  bool mueller = false;
  shader::ImplicitStep implicit{};
  std::span<const shader::Response> responses;  // those of the step: n, or none
};

// Each takes the implicit integrator's way where the model is an implicit one; it alone has relax.
void rebase(const SubstepInput& in, Fields& fields, Range range);
void skin(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void predict(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void region(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void goal(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void relax(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void integrate(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// predict, goal and integrate in one pass over the vertices; the same bits.
void update(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// goal and relax in one pass over the vertices; the same bits.
void iterate(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void embed(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

}  // namespace fascicle::cpu_reference
