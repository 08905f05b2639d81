// Stage embed: one invocation per render vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/embed.inc"

void main() {
  uint i = item_index();
  if (i >= push.substep.surface_count) return;
  uvec4 corner = surface_vertex[i];
  vec4 w = surface_weight[i];
  vec4 a = position[corner.x];
  vec4 b = position[corner.y];
  vec4 c = position[corner.z];
  vec4 d = position[corner.w];
  surface[3u * i] = embed_coordinate(w.x, a.x, w.y, b.x, w.z, c.x, w.w, d.x);
  surface[3u * i + 1u] = embed_coordinate(w.x, a.y, w.y, b.y, w.z, c.y, w.w, d.y);
  surface[3u * i + 2u] = embed_coordinate(w.x, a.z, w.y, b.z, w.z, c.z, w.w, d.z);
}
