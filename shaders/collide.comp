// Stage collide, when a substep's positions are there: one invocation a vertex. The explicit integrator's velocities
// are there too. Of the implicit one they follow from y, the goal and the position, which all become the place where
// the vertex touches; what it was moved by since y goes into the velocity.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/collide.glsl"

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (is_kinematic(i)) return;
  Vector x = vector_of(position[i]);
  Vector v = vector_of(velocity[i]);
  Vector start = collide_start(x, v, push.substep.h);
  if (with_implicit) start = vector_of(position_before[i]);
  Collided c = collided(i, start, x);
  if (!c.touches) return;
  position[i] = record_of(c.place);
  if (with_implicit) {
    velocity[i] = record_of(collide_velocity(v, c.place, vector_of(predicted[i]), push.implicit.inverse_step));
    predicted[i] = record_of(c.place);
    goal[i] = record_of(c.place);
  } else {
    velocity[i] = record_of(collide_velocity(v, c.place, x, push.substep.inverse_h));
  }
}
