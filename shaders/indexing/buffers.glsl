// The buffers as GLSL declarations, and their items as the kernels' types. An invocation writes only its own items.
#ifndef FASCICLE_INDEXING_BUFFERS_GLSL
#define FASCICLE_INDEXING_BUFFERS_GLSL
#include "shaders/buffers.h"
#include "shaders/kernel/algebra.inc"

layout(local_size_x = slice_width, local_size_x_id = constant_group_size) in;

layout(push_constant, std430) uniform PushBlock { Push push; };

layout(constant_id = constant_rotation) const uint rotation_method = rotation_qcp;
layout(constant_id = constant_muscles) const bool with_muscles = false;
layout(constant_id = constant_forces) const bool with_forces = false;
layout(constant_id = constant_carried) const bool with_carried = false;
layout(constant_id = constant_volume) const bool with_volume = false;
layout(constant_id = constant_implicit) const bool with_implicit = false;
layout(constant_id = constant_ties) const bool with_ties = false;
layout(constant_id = constant_near) const bool with_near = false;
layout(constant_id = constant_ahead) const uint ahead = 1u;

layout(std430, binding = buffer_position) buffer PositionBuffer { vec4 position[]; };
layout(std430, binding = buffer_velocity) buffer VelocityBuffer { vec4 velocity[]; };
layout(std430, binding = buffer_rotation) buffer RotationBuffer { vec4 rotation[]; };
layout(std430, binding = buffer_transform) buffer TransformBuffer { vec4 transform[]; };
layout(std430, binding = buffer_goal) buffer GoalBuffer { vec4 goal[]; };
layout(std430, binding = buffer_skinned) buffer SkinnedBuffer { vec4 skinned[]; };
layout(std430, binding = buffer_skinned_before) buffer SkinnedBeforeBuffer { vec4 skinned_before[]; };
layout(std430, binding = buffer_skinned_velocity) buffer SkinnedVelocityBuffer { vec4 skinned_velocity_before[]; };
layout(std430, binding = buffer_gravity) buffer GravityBuffer { vec4 gravity[]; };
layout(std430, binding = buffer_surface) buffer SurfaceBuffer { float surface[]; };

layout(std430, binding = buffer_rest) readonly buffer RestBuffer { vec4 rest[]; };
layout(std430, binding = buffer_tag) readonly buffer TagBuffer { uint tag_and_degree[]; };
layout(std430, binding = buffer_slice) readonly buffer SliceBuffer { uint slice[]; };
layout(std430, binding = buffer_ring) readonly buffer RingBuffer { uint ring[]; };
layout(std430, binding = buffer_share_taken) readonly buffer ShareTakenBuffer { uint share_taken[]; };
layout(std430, binding = buffer_share_given) readonly buffer ShareGivenBuffer { uint share_given[]; };
layout(std430, binding = buffer_alpha) readonly buffer AlphaBuffer { float alpha[]; };
layout(std430, binding = buffer_carried) readonly buffer CarriedBuffer { float carried[]; };
layout(std430, binding = buffer_region_rest) readonly buffer RegionRestBuffer { vec4 region_rest[]; };
layout(std430, binding = buffer_muscle_offset) readonly buffer MuscleOffsetBuffer { uint muscle_offset[]; };
layout(std430, binding = buffer_region_muscle) readonly buffer RegionMuscleBuffer { RegionMuscle region_muscle[]; };
layout(std430, binding = buffer_region_frame) readonly buffer RegionFrameBuffer { RegionFrame region_frame[]; };
layout(std430, binding = buffer_region_volume) readonly buffer RegionVolumeBuffer { vec4 region_volume[]; };
layout(std430, binding = buffer_skin_offset) readonly buffer SkinOffsetBuffer { uint skin_offset[]; };
layout(std430, binding = buffer_skin_joint) readonly buffer SkinJointBuffer { uint skin_joint[]; };
layout(std430, binding = buffer_skin_weight) readonly buffer SkinWeightBuffer { float skin_weight[]; };
layout(std430, binding = buffer_force_offset) readonly buffer ForceOffsetBuffer { uint force_offset[]; };
layout(std430, binding = buffer_force_index) readonly buffer ForceIndexBuffer { uint force_index[]; };
layout(std430, binding = buffer_force_coefficient) readonly buffer ForceCoefficientBuffer {
  float force_coefficient[];
};
layout(std430, binding = buffer_surface_vertex) readonly buffer SurfaceVertexBuffer { uvec4 surface_vertex[]; };
layout(std430, binding = buffer_surface_weight) readonly buffer SurfaceWeightBuffer { vec4 surface_weight[]; };

layout(std430, binding = buffer_bone) readonly buffer BoneBuffer { Bone bone[]; };
layout(std430, binding = buffer_muscle) readonly buffer MuscleBuffer { Muscle muscle[]; };
layout(std430, binding = buffer_force) readonly buffer ForceBuffer { Force force[]; };
layout(std430, binding = buffer_collider) readonly buffer ColliderBuffer { Collider collider[]; };
layout(std430, binding = buffer_decay) readonly buffer DecayBuffer { float decay[]; };

layout(std430, binding = buffer_position_before) buffer PositionBeforeBuffer { vec4 position_before[]; };
layout(std430, binding = buffer_velocity_before) buffer VelocityBeforeBuffer { vec4 velocity_before[]; };
layout(std430, binding = buffer_predicted) buffer PredictedBuffer { vec4 predicted[]; };
layout(std430, binding = buffer_iterate_before) buffer IterateBeforeBuffer { vec4 iterate_before[]; };
layout(std430, binding = buffer_response) readonly buffer ResponseBuffer { Response response[]; };

layout(std430, binding = buffer_spared) readonly buffer SparedBuffer { uint spared[]; };
layout(std430, binding = buffer_tied) buffer TiedBuffer { vec4 tied[]; };
layout(std430, binding = buffer_tie) readonly buffer TieBuffer { Tie tie[]; };
layout(std430, binding = buffer_tie_offset) readonly buffer TieOffsetBuffer { uint tie_offset[]; };
layout(std430, binding = buffer_tie_index) readonly buffer TieIndexBuffer { uint tie_index[]; };
layout(std430, binding = buffer_tie_coefficient) readonly buffer TieCoefficientBuffer { float tie_coefficient[]; };

uint item_index() { return push.first_slice * slice_width + gl_GlobalInvocationID.x; }

// Entry k of vertex i's one-ring is at ring_start(i) + k ring_stride.
const uint ring_stride = slice_width;
uint ring_start(uint i) { return slice[i / slice_width] + (i % slice_width); }
uint ring_size(uint i) { return tag_and_degree[i] >> degree_shift; }

// An entry of vertex i; `word` is its word in share_taken or share_given: the neighbour and its share.
uint neighbour_of(uint i, uint entry, uint word) {
  if (with_near) return uint(int(i / slice_width * slice_width) + (int(word << share_shift) >> share_shift));
  return ring[entry];
}
float share_of(uint word) {
  // The 16 bits of a share, added below those of 1: exact, without a conversion.
  if (with_near) return uintBitsToFloat(0x3f800000u | (word >> share_shift) << 7u) - 1.0f;
  return uintBitsToFloat(word);
}

bool is_kinematic(uint i) { return (tag_and_degree[i] & tag_kinematic) != 0u; }
uint layer_of(uint i) { return tag_and_degree[i] & tag_layer_mask; }
bool has_skeleton() { return push.substep.joint_count != 0u; }

Vector vector_of(vec4 r) {
  Vector v;
  v.x = r.x;
  v.y = r.y;
  v.z = r.z;
  return v;
}

vec4 record_of(Vector v) { return vec4(v.x, v.y, v.z, 0.0f); }

Vector zero_vector() {
  Vector v;
  v.x = 0.0f;
  v.y = 0.0f;
  v.z = 0.0f;
  return v;
}

// A map from its three rows.
Transform transform_of(vec4 x, vec4 y, vec4 z) {
  Transform t;
  t.linear.xx = x.x;
  t.linear.xy = x.y;
  t.linear.xz = x.z;
  t.linear.yx = y.x;
  t.linear.yy = y.y;
  t.linear.yz = y.z;
  t.linear.zx = z.x;
  t.linear.zy = z.y;
  t.linear.zz = z.z;
  t.translation.x = x.w;
  t.translation.y = y.w;
  t.translation.z = z.w;
  return t;
}

Transform load_transform(uint i) {
  uint n = push.substep.vertex_count;
  return transform_of(transform[i], transform[n + i], transform[2u * n + i]);
}

void store_transform(uint i, Transform t) {
  uint n = push.substep.vertex_count;
  transform[i] = vec4(t.linear.xx, t.linear.xy, t.linear.xz, t.translation.x);
  transform[n + i] = vec4(t.linear.yx, t.linear.yy, t.linear.yz, t.translation.y);
  transform[2u * n + i] = vec4(t.linear.zx, t.linear.zy, t.linear.zz, t.translation.z);
}

#endif
