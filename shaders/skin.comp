// Stage skin: one invocation a vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/skin.inc"

Transform influence(uint k) {
  Bone b = bone[push.substep.first_bone + skin_joint[k]];
  Transform t;
  t.linear.xx = b.xx;
  t.linear.xy = b.xy;
  t.linear.xz = b.xz;
  t.linear.yx = b.yx;
  t.linear.yy = b.yy;
  t.linear.yz = b.yz;
  t.linear.zx = b.zx;
  t.linear.zy = b.zy;
  t.linear.zz = b.zz;
  t.translation.x = b.xt;
  t.translation.y = b.yt;
  t.translation.z = b.zt;
  return skin_term(skin_weight[k], t);
}

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  uint first = skin_offset[i];
  uint end = skin_offset[i + 1u];
  Transform blend = influence(first);
  for (uint k = first + 1u; k < end; ++k) blend = skin_add(blend, influence(k));
  skinned[i] = record_of(skin_position(blend, vector_of(rest[i])));
}
