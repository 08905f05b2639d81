// The stages of a substep on the CPU, over a range of vertices (regions, render vertices). Indexing only: the
// arithmetic is in shaders/kernel. Call a stage for ranges that cover the body, on any threads, and wait for
// all of them before the next stage. A stage reads from other vertices only what earlier stages wrote; what
// it overwrites (rotations, velocities, positions) is read in that stage only by the vertex itself.
#pragma once

#include <cstdint>
#include <span>

#include "cpu_reference/solver/fields.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/model/stages.h"
#include "shaders/shared.h"

namespace fascicle::cpu_reference {

struct Range {
  std::uint32_t first, last;
};

// A solid with the data that collide_reach.h needs to reject vertices: a plane's normal and height, or the
// centre of another solid; and, squared, its extent beyond that and its turning.
struct ColliderReach {
  float x = 0.0f, y = 0.0f, z = 0.0f;
  float height = 0.0f, reach = 0.0f, turning = 0.0f;
  std::uint32_t bit = 1;  // its bit in Model::spared
  bool is_plane = false;
};

// One substep's uniform values, bones, muscles, forces and colliders.
struct SubstepInput {
  shader::Substep step{};
  std::span<const shader::Bone> bones;
  std::span<const shader::Muscle> muscles;
  std::span<const shader::Force> forces;
  std::span<const shader::Collider> colliders;
  std::span<const ColliderReach> reaches;  // of the colliders
  std::span<const float> decay;
  bool mueller = false;
  shader::ImplicitStep implicit{};
  std::span<const shader::Response> responses;  // for the step: n, or none
};

// A kernel over a range of its items; in lanes, over a range of slices: lane_stages.h.
using ModelStage = void (*)(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
struct LaneInput;
struct LaneStages;
using LaneStage = void (*)(const LaneInput& in, Range slices);

// A kernel's code for single items, and in lanes if it has such code.
struct KernelCode {
  ModelStage one_by_one = nullptr;
  LaneStage LaneStages::*in_lanes = nullptr;
};
// For kernels of a plan that run one by one. Throws std::logic_error for others: CpuSolver runs the stages
// limit and contact as a whole.
KernelCode code_of(model::Kernel kernel, const model::Model& model, model::Rotation rotation);

// Each follows the model's integrator. Only implicit models have relax.
void rebase(const SubstepInput& in, Fields& fields, Range range);
void skin(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void tie(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void predict(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void region(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void goal(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void relax(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// One pass of stage limit: over the model's limits, the vertices, the limits that lack volume, the vertices.
void lack(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void crowd(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void push(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void limit(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void integrate(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// predict, goal and integrate in one pass over the vertices; the same bits.
void update(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// goal and relax in one pass over the vertices; the same bits.
void iterate(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void embed(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

}  // namespace fascicle::cpu_reference
