// Stage skin: one invocation per vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/skin.inc"

Transform map_term(uint k, Bone b) {
  return skin_term(skin_weight[k], transform_of(vec4(b.xx, b.xy, b.xz, b.xt), vec4(b.yx, b.yy, b.yz, b.yt),
                                                vec4(b.zx, b.zy, b.zz, b.zt)));
}

Vector gravity_term(uint k, Bone b) {
  Vector g;
  g.x = b.gravity_x;
  g.y = b.gravity_y;
  g.z = b.gravity_z;
  return skin_gravity_term(skin_weight[k], g);
}

Bone bone_of(uint k) { return bone[push.substep.first_bone + skin_joint[k]]; }

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  uint first = skin_offset[i];
  uint end = skin_offset[i + 1u];
  Bone b = bone_of(first);
  Transform blend = map_term(first, b);
  Vector turned = gravity_term(first, b);
  for (uint k = first + 1u; k < end; ++k) {
    b = bone_of(k);
    blend = skin_add(blend, map_term(k, b));
    turned = skin_gravity_add(turned, gravity_term(k, b));
  }
  skinned[i] = record_of(skin_position(blend, vector_of(rest[i])));
  gravity[i] = record_of(snap_vector(turned));
}
