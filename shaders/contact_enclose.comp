// Stage contact, second: boxes around the leaves' boxes. One invocation per branch.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact.glsl"

void main() {
  uint branch = item_index();
  if (branch >= branch_count()) return;
  uint first = branch * contact_branch;
  uint end = first + contact_branch;
  if (end > leaf_count()) end = leaf_count();
  vec4 low = nothing_is_lower;
  vec4 high = nothing_is_higher;
  for (uint leaf = first; leaf < end; ++leaf) {
    low = lower(low, contact_box[2u * leaf]);
    high = higher(high, contact_box[2u * leaf + 1u]);
  }
  contact_branch_box[2u * branch] = low;
  contact_branch_box[2u * branch + 1u] = high;
}
