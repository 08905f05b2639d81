// Stages in lanes: the stages of stages.h over slices of vertices, many vertices per instruction, with the
// same bits. They instantiate the arithmetic of shaders/kernel for vector types (lanes.inc); the stages are
// written once (lane_stages.inc) and compiled for each instruction set.
#pragma once

#include <cstdint>

#include "cpu_reference/solver/contact_lanes.h"
#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/simd.h"
#include "cpu_reference/solver/slices.h"
#include "cpu_reference/solver/stages.h"
#include "host/model/model_arrays.h"

namespace fascicle::cpu_reference {

// Only plain pointers and numbers: code for one instruction set must share no inline library function with
// code for another, or the linker may give one's instance to the other.
struct LaneInput {
  std::uint32_t vertex_count;
  const std::uint32_t* first_row;
  const std::uint32_t* full_rows;
  const std::uint32_t* degree;
  const std::int32_t* taken_degree;
  const std::uint8_t* is_held;
  const std::uint32_t* layer;
  const std::uint32_t* reach;
  const std::int16_t* near_ring;  // null: far_ring and shares as floats
  const std::uint16_t *taken_parts, *given_parts;
  const std::int32_t* far_ring;
  const float *taken, *given;

  // The model's arrays, by their rows in model_arrays; null if empty. array_of restores their types.
  const void* arrays[model::model_member_count];
  std::uint32_t muscle_count, force_count;
  bool has_skeleton;

  // For stage limit: the numbers of the limits that a range of slices covers; null: all.
  std::uint32_t limit_count;
  const std::uint32_t* listed_limit;

  shader::Substep step;
  shader::ImplicitStep implicit;
  const shader::Response* responses;
  const shader::Bone* bones;
  const shader::Muscle* muscles;
  const shader::Force* forces;
  const float* decay;

  // As in Fields.
  float *vertices, *regions, *velocities, *predicted, *goals, *skinned, *skinned_velocities, *gravity;
  const float* tied;  // null without ties
  float *iterate_before, *positions_before, *velocities_before;
  const float* skinned_before;
  float* lack;
  std::uint8_t* some_lack;
};

LaneInput lane_input(const model::Model& model, const Slices& slices, const SubstepInput& in, Fields& fields);

// Each stage takes a range of slices.
struct LaneStages {
  LaneStage skin, region, update, iterate;
  LaneStage predict, integrate;  // for an implicit substep; an explicit one's are in update
  LaneStage lack;                // over slices of limits
  ContactLanes contact;
};

// Null for scalar, and if this build has none for the level.
const LaneStages* lane_stages(Simd level);

// One per instruction set; null if the compiler was not told to use it.
const LaneStages* baseline_lane_stages();
const LaneStages* sse4_lane_stages();
const LaneStages* avx2_lane_stages();
const LaneStages* avx512_lane_stages();

}  // namespace fascicle::cpu_reference
