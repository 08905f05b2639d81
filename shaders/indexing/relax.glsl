// Stage relax for one vertex, shared by relax.comp and iterate.comp.
#ifndef FASCICLE_INDEXING_RELAX_GLSL
#define FASCICLE_INDEXING_RELAX_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/relax.inc"

void relax_free(uint i, Vector g) {
  Response answer = response[push.implicit.first_response + i];
  vec4 x = position[i];
  position[i] = record_of(relax_position(vector_of(x), vector_of(iterate_before[i]), vector_of(predicted[i]), g,
                                         answer.to_goal, answer.to_inertia, push.implicit.gain,
                                         push.implicit.omega));
  iterate_before[i] = x;
}

#endif
