// The stages of a substep on the CPU, over a range of vertices (regions, render vertices). Only indexing: the
// arithmetic is in shaders/kernel. Call a stage for ranges that cover the body, on any threads, and wait for
// all of them before the next stage. What a stage reads of other vertices, an earlier stage wrote; what it
// overwrites (rotations, velocities, positions), only the vertex itself reads in that stage.
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

// A solid with what collide_reach.h needs to reject vertices: a plane's normal and height, or the middle of
// another solid; squared, how far beyond that it reaches and what it turns by.
struct ColliderReach {
  float x = 0.0f, y = 0.0f, z = 0.0f;
  float height = 0.0f, reach = 0.0f, turning = 0.0f;
  std::uint32_t bit = 1;  // of it in Model::spared
  bool is_plane = false;
};

// One substep's uniform values and this substep's bones, muscles, forces and colliders.
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
  std::span<const shader::Response> responses;  // those of the step: n, or none
};

// A kernel over a range of its items, and in lanes over one of slices: lane_stages.h.
using ModelStage = void (*)(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
struct LaneInput;
struct LaneStages;
using LaneStage = void (*)(const LaneInput& in, Range slices);

// A kernel one item after the other, and in lanes where it is written so.
struct KernelCode {
  ModelStage one_by_one = nullptr;
  LaneStage LaneStages::*in_lanes = nullptr;
};
// Of the kernels of a plan that are run one by one. Throws std::logic_error for others: CpuSolver carries out
// the stages limit and contact as a whole.
KernelCode code_of(model::Kernel kernel, const model::Model& model, model::Rotation rotation);

// Each follows the integrator of the model. Only implicit models have relax.
void rebase(const SubstepInput& in, Fields& fields, Range range);
void skin(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void tie(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void predict(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void region(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void goal(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void relax(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
// A pass of stage limit: over the model's limits, over the vertices, over the limits that lack volume, over
// the vertices.
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
