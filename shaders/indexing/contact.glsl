// Shared by the shaders of stage contact.
#ifndef FASCICLE_INDEXING_CONTACT_GLSL
#define FASCICLE_INDEXING_CONTACT_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/contact.inc"

layout(std430, binding = buffer_contact) readonly buffer ContactBuffer { ContactPoint contact[]; };
layout(std430, binding = buffer_contact_near) readonly buffer ContactNearBuffer { VertexRun contact_near[]; };
layout(std430, binding = buffer_contact_tetrahedron) readonly buffer ContactTetrahedronBuffer {
  uvec4 contact_tetrahedron[];
};
layout(std430, binding = buffer_contact_depth) readonly buffer ContactDepthBuffer { float contact_depth[]; };
layout(std430, binding = buffer_contact_number) readonly buffer ContactNumberBuffer { uint contact_number[]; };
layout(std430, binding = buffer_contact_offset) readonly buffer ContactOffsetBuffer { uint contact_offset[]; };
layout(std430, binding = buffer_contact_entry) readonly buffer ContactEntryBuffer { uint contact_entry[]; };
layout(std430, binding = buffer_contact_rest_box) readonly buffer ContactRestBoxBuffer { vec4 contact_rest_box[]; };
layout(std430, binding = buffer_mobility) readonly buffer MobilityBuffer { float mobility[]; };
layout(std430, binding = buffer_contact_box) buffer ContactBoxBuffer { vec4 contact_box[]; };
layout(std430, binding = buffer_contact_branch_box) buffer ContactBranchBoxBuffer { vec4 contact_branch_box[]; };
layout(std430, binding = buffer_contact_found) buffer ContactFoundBuffer { uint contact_found[]; };
layout(std430, binding = buffer_contact_place) buffer ContactPlaceBuffer { vec4 contact_place[]; };
layout(std430, binding = buffer_contact_first) buffer ContactFirstBuffer { uint contact_first[]; };
layout(std430, binding = buffer_contact_next) buffer ContactNextBuffer { uint contact_next[]; };
layout(std430, binding = buffer_contact_crowd) buffer ContactCrowdBuffer { float contact_crowd[]; };
layout(std430, binding = buffer_contact_impulse) buffer ContactImpulseBuffer { vec4 contact_impulse_of[]; };

uint leaf_count() { return (push.substep.contact_tetrahedron_count + (contact_leaf - 1u)) / contact_leaf; }
uint branch_count() { return (leaf_count() + (contact_branch - 1u)) / contact_branch; }

Vector place_of(uint i) { return vector_of(position[i]); }

Vector rest_of(uint i) { return vector_of(rest[i]); }

bool box_holds(vec4 low, vec4 high, Vector x) {
  return x.x >= low.x && x.x <= high.x && x.y >= low.y && x.y <= high.y && x.z >= low.z && x.z <= high.z;
}
// An empty box. NaN extends no box.
const vec4 nothing_is_lower = vec4(3.0e38f, 3.0e38f, 3.0e38f, 0.0f);
const vec4 nothing_is_higher = vec4(-3.0e38f, -3.0e38f, -3.0e38f, 0.0f);
vec4 lower(vec4 a, vec4 b) {
  return vec4(b.x < a.x ? b.x : a.x, b.y < a.y ? b.y : a.y, b.z < a.z ? b.z : a.z, 0.0f);
}
vec4 higher(vec4 a, vec4 b) {
  return vec4(b.x > a.x ? b.x : a.x, b.y > a.y ? b.y : a.y, b.z > a.z ? b.z : a.z, 0.0f);
}

// The weight of corner `corner` in the contact of point p.
float weight_of(uint p, uint corner) {
  vec4 w = contact_place[3u * p];
  return corner == 0u ? w.x : corner == 1u ? w.y : corner == 2u ? w.z : w.w;
}

#endif
