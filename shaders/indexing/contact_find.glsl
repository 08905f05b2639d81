// Whether a point and a tetrahedron are in contact, and the data that later kernels need.
#ifndef FASCICLE_INDEXING_CONTACT_FIND_GLSL
#define FASCICLE_INDEXING_CONTACT_FIND_GLSL
#include "shaders/indexing/contact.glsl"

layout(constant_id = constant_ignored_contact) const bool with_ignored_contact = false;
layout(std430, binding = buffer_contact_ignored) readonly buffer ContactIgnoredBuffer { uint contact_ignored[]; };
layout(std430, binding = buffer_contact_group) readonly buffer ContactGroupBuffer { uint contact_group[]; };

// Whether nothing in a box can meet the point, because the whole box is near it at rest.
bool is_near_at_rest(ContactPoint point, uint box) {
  if (point.near_count > 0u) return false;
  vec4 low = contact_rest_box[2u * box];
  vec4 high = contact_rest_box[2u * box + 1u];
  Vector x = rest_of(point.vertex);
  return contact_is_near(x, vector_of(low), vector_of(high), point.margin);
}

bool is_across_a_gap(ContactPoint point, uint vertex) {
  for (uint k = 0u; k < point.near_count; ++k) {
    VertexRun run = contact_near[point.first_near + k];
    if (vertex < run.end) return vertex >= run.first;
  }
  return false;
}

// The depth of a vertex for a point that ignores these groups: host/model/contact_depth.h.
float depth_of(uint vertex, uint ignored) {
  float depth = contact_depth[vertex];
  uint first = push.substep.vertex_count;
  for (uint left = ignored; left != 0u; left >>= 1u) {
    if ((left & 1u) != 0u) {
      float other = contact_depth[first + vertex];
      if (other < depth) depth = other;
    }
    first += push.substep.vertex_count;
  }
  return depth;
}

bool meets(uint p, ContactPoint point, Vector x, uint t) {
  uint ignored = 0u;
  if (with_ignored_contact) {
    ignored = contact_ignored[p];
    if ((ignored & contact_group[t]) != 0u) return false;
  }
  uvec4 corners = contact_tetrahedron[t];
  Vector a = place_of(corners.x);
  Vector b = place_of(corners.y);
  Vector c = place_of(corners.z);
  Vector d = place_of(corners.w);
  if (!contact_is_in_box(x, a, b, c, d)) return false;
  ContactVolumes v = contact_volumes(x, a, b, c, d);
  if (!contact_is_inside(v)) return false;
  if (!(mobility[point.vertex] > 0.0f) && !(mobility[corners.x] > 0.0f) && !(mobility[corners.y] > 0.0f) &&
      !(mobility[corners.z] > 0.0f) && !(mobility[corners.w] > 0.0f))
    return false;
  ContactWeights w = contact_weights(v);
  Vector offset = contact_apart(w, rest_of(point.vertex), rest_of(corners.x), rest_of(corners.y), rest_of(corners.z),
                                 rest_of(corners.w));
  float squared = inner_product(offset, offset);
  bool is_far = squared > point.margin * point.margin;
  if (!is_far && !(is_across_a_gap(point, corners.x) && is_across_a_gap(point, corners.y) &&
                   is_across_a_gap(point, corners.z) && is_across_a_gap(point, corners.w)))
    return false;
  float depth_a = depth_of(corners.x, ignored);
  float depth_b = depth_of(corners.y, ignored);
  float depth_c = depth_of(corners.z, ignored);
  float depth_d = depth_of(corners.w, ignored);
  float depth = contact_mean(w, depth_a, depth_b, depth_c, depth_d);
  float pushed = depth - point.allowance;
  if (is_far) pushed = contact_depth_beyond(depth, squared, point.margin);
  ContactPush push_out = contact_push(v, pushed, depth_a, depth_b, depth_c, depth_d);
  contact_place[3u * p] = vec4(w.a, w.b, w.c, w.d);
  contact_place[3u * p + 1u] = record_of(push_out.push);
  contact_place[3u * p + 2u] = record_of(push_out.normal);
  return true;
}

#endif
