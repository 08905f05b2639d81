// Stage collide, once a substep's positions are known (and the explicit integrator's velocities): one invocation per
// vertex. For the implicit integrator, y, the goal and the position all become the place where the vertex touches, so
// that its velocity is the one written here; and the history that the next substep reads is shifted.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/collide.glsl"

void collide_explicit(uint i, Vector x, Vector v) {
  Collided c = collided(i, collide_start(x, v, push.substep.h), x, v);
  if (!c.touches) return;
  position[i] = record_of(c.place);
  velocity[i] = record_of(collide_velocity(v, c.place, x, c.raised, push.substep.inverse_h));
}

void collide_implicit(uint i, Vector x, Vector v) {
  Vector start = vector_of(position_before[i]);
  Vector y = vector_of(predicted[i]);
  Vector pull =
      collide_pull(y, vector_of(goal[i]), response[push.implicit.first_response + i].to_goal);
  Vector free = collide_free_velocity(v, pull, push.implicit.inverse_step);
  // The iterations end outside the solids, so test as well where the vertex would be without what they pushed away.
  Collided c = collided(i, start, x, free);
  Collided pushed = collided(i, start, vector_sum(y, pull), free);
  if (!c.touches && !pushed.touches) return;
  if (pushed.touches) c.velocity = pushed.velocity;
  Vector impulse = subtract(c.velocity, free);
  position[i] = record_of(c.place);
  predicted[i] = record_of(c.place);
  goal[i] = record_of(c.place);
  velocity[i] = record_of(snap_vector(c.velocity));
  position_before[i] = record_of(collide_begun(start, c.place, y, pull, impulse, push.substep.h));
  velocity_before[i] = record_of(snap_vector(vector_sum(vector_of(velocity_before[i]), impulse)));
}

void main() {
  uint i = item_index();
  if (i >= push.substep.vertex_count) return;
  if (is_kinematic(i)) return;
  Vector x = vector_of(position[i]);
  Vector v = vector_of(velocity[i]);
  if (with_implicit) {
    collide_implicit(i, x, v);
  } else {
    collide_explicit(i, x, v);
  }
}
