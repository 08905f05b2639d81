// How solids stop a vertex, shared by collide.comp and obstruct.comp.
#ifndef FASCICLE_INDEXING_COLLIDE_GLSL
#define FASCICLE_INDEXING_COLLIDE_GLSL
#include "shaders/indexing/buffers.glsl"
#include "shaders/kernel/collide.inc"

Transform map_at_end(Collider c) {
  return transform_of(vec4(c.xx, c.xy, c.xz, c.xt), vec4(c.yx, c.yy, c.yz, c.yt), vec4(c.zx, c.zy, c.zz, c.zt));
}

Transform map_at_beginning(Collider c) {
  return transform_of(vec4(c.before_xx, c.before_xy, c.before_xz, c.before_xt),
                      vec4(c.before_yx, c.before_yy, c.before_yz, c.before_yt),
                      vec4(c.before_zx, c.before_zy, c.before_zz, c.before_zt));
}

CollideShape shape_of(Collider c) {
  CollideShape s;
  s.half_size.x = c.half_x;
  s.half_size.y = c.half_y;
  s.half_size.z = c.half_z;
  s.radius = c.radius;
  s.is_plane = c.is_plane;
  return s;
}

struct Collided {
  Vector place;
  Vector raised;    // the part of the move that adds no velocity
  Vector velocity;  // with the solids' impulses
  bool touches;
};

// The last two solids that pressed, the newer one first, and the directions away from them.
struct Pressing {
  uint newer, older;
  Vector away_newer, away_older;
};

// Applies one solid; `pressing` are the last ones before it. Returns whether it touches.
bool collided_with(uint k, Vector start, bool rubs, inout Pressing pressing, inout Collided r) {
  Collider c = collider[push.substep.first_collider + k];
  CollideShape shape = shape_of(c);
  Transform map = map_at_end(c);
  Transform map_before = map_at_beginning(c);
  Vector p0 = apply(map_before, start);
  Vector p1 = apply(map, r.place);
  CollideSide first = collide_side(shape, p0);
  if (!collide_may_touch(first.distance, subtract(p1, p0))) return false;
  float friction = rubs ? c.friction : 0.0f;
  CollideMove m = collide_move(shape, first, p0, p1, friction, c.lifted);
  if (!(m.touches > 0.0f)) return false;
  Vector away = collide_turned_back(map.linear, m.away);
  Vector other = k == pressing.newer ? pressing.away_older : pressing.away_newer;
  if (rubs) other = zero_vector();
  r.place = snap_vector(vector_sum(
      r.place, collide_led(collide_turned_back(map.linear, m.move), away, other)));
  // Later passes repeat the lift if another solid has undone it; only the first counts.
  if (rubs) r.raised = vector_sum(r.raised, collide_turned_back(map.linear, m.raised));
  Vector moved = subtract(r.place, collide_carried_from(map_before, apply(map, r.place)));
  Vector seen = multiply(map.linear, subtract(r.velocity, scaled_vector(push.substep.inverse_h, moved)));
  Vector impulse = collide_turned_back(map.linear, collide_impulse(seen, m.away, friction));
  r.velocity = vector_sum(r.velocity, collide_led(impulse, away, other));
  r.touches = true;
  if (k != pressing.newer) {
    pressing.older = pressing.newer;
    pressing.away_older = pressing.away_newer;
    pressing.newer = k;
  }
  pressing.away_newer = away;
  return true;
}

// Moves vertex i from `start` to `place`, one solid after another.
Collided collided(uint i, Vector start, Vector place, Vector velocity) {
  Collided r;
  r.place = place;
  r.raised = zero_vector();
  r.velocity = velocity;
  r.touches = false;
  uint none = push.substep.collider_count;
  Pressing pressing;
  pressing.newer = none;
  pressing.older = none;
  pressing.away_newer = zero_vector();
  pressing.away_older = zero_vector();
  uint unmoved = 0u;  // number of solids since the last one that touched
  for (uint pass = 0u; pass < collide_passes && unmoved < none; ++pass) {
    for (uint k = 0u; k < none && unmoved < none; ++k) {
      bool touches = false;
      if ((spared[i] >> k & 1u) == 0u) touches = collided_with(k, start, pass == 0u, pressing, r);
      unmoved = touches ? 1u : unmoved + 1u;
    }
  }
  return r;
}

#endif
