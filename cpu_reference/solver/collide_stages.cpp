#include "cpu_reference/solver/collide_stages.h"

#include <algorithm>
#include <array>

#include "cpu_reference/solver/collide_reach.h"
#include "shaders/kernel/collide.inc"

namespace fascicle::cpu_reference {

namespace {

using model::Model;
using Point = kernel::Vector<float>;

Point point_at(const Floats& values, std::size_t stride, std::uint32_t i) {
  const float* v = values.data() + stride * i;
  return {v[0], v[1], v[2]};
}

void put_point(Floats& values, std::size_t stride, std::uint32_t i, const Point& p) {
  float* v = values.data() + stride * i;
  v[0] = p.x;
  v[1] = p.y;
  v[2] = p.z;
}

kernel::Transform<float> map_at_end(const shader::Collider& c) {
  return {{c.xx, c.xy, c.xz, c.yx, c.yy, c.yz, c.zx, c.zy, c.zz}, {c.xt, c.yt, c.zt}};
}

kernel::Transform<float> map_at_beginning(const shader::Collider& c) {
  return {{c.before_xx, c.before_xy, c.before_xz, c.before_yx, c.before_yy, c.before_yz, c.before_zx,
           c.before_zy, c.before_zz},
          {c.before_xt, c.before_yt, c.before_zt}};
}

float squared_distance(const float* a, const float* b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

// Calls use(model, in, fields, i) for each vertex that may reach a solid which it does not ignore.
template <class WayOf>
void for_each_near(const Model& model, const SubstepInput& in, Fields& fields, const WayOf& way_of,
                   Range range, void (*use)(const Model&, const SubstepInput&, Fields&, std::uint32_t)) {
  constexpr std::uint32_t block = 256;
  std::array<std::uint32_t, block> marks;
  for (std::uint32_t first = range.first; first < range.last; first += block) {
    const Range part{first, std::min(range.last, first + block)};
    marks.fill(0);
    for (const ColliderReach& solid : in.reaches) mark_reached(solid, way_of, part, marks.data());
    for (std::uint32_t i = part.first; i < part.last; ++i)
      if ((marks[i - part.first] & ~model.spared[i]) != 0) use(model, in, fields, i);
  }
}

struct Collided {
  Point place;
  Point raised;    // the part of the move that adds no velocity
  Point velocity;  // with the solids' impulses
  bool touches = false;
};

// The last two solids that pressed, the newer one first, and the directions away from them.
struct Pressing {
  std::size_t newer, older;
  Point away_newer{}, away_older{};
};

// Applies one solid; `pressing` are the last ones before it. Returns whether it touches.
bool collided_with(const SubstepInput& in, std::size_t k, const Point& start, bool rubs, Pressing& pressing,
                   Collided& r) {
  const shader::Collider& c = in.colliders[k];
  const kernel::CollideShape<float> shape{{c.half_x, c.half_y, c.half_z}, c.radius, c.is_plane};
  const kernel::Transform<float> map = map_at_end(c), map_before = map_at_beginning(c);
  const Point p0 = kernel::apply<float>(map_before, start), p1 = kernel::apply<float>(map, r.place);
  const kernel::CollideSide<float> first = kernel::collide_side<float>(shape, p0);
  if (!kernel::collide_may_touch<float>(first.distance, kernel::subtract<float>(p1, p0))) return false;
  const float friction = rubs ? c.friction : 0.0f;
  const kernel::CollideMove<float> m = kernel::collide_move<float>(shape, first, p0, p1, friction, c.lifted);
  if (!(m.touches > 0.0f)) return false;
  const auto turned_back = [&](const Point& v) { return kernel::collide_turned_back<float>(map.linear, v); };
  const Point away = turned_back(m.away);
  Point other = k == pressing.newer ? pressing.away_older : pressing.away_newer;
  if (rubs) other = {};
  r.place = kernel::snap_vector<float>(
      kernel::vector_sum<float>(r.place, kernel::collide_led<float>(turned_back(m.move), away, other)));
  // Later passes repeat the lift if another solid has undone it; only the first counts.
  if (rubs) r.raised = kernel::vector_sum<float>(r.raised, turned_back(m.raised));
  const Point moved = kernel::subtract<float>(
      r.place, kernel::collide_carried_from<float>(map_before, kernel::apply<float>(map, r.place)));
  const Point seen = kernel::multiply<float>(
      map.linear,
      kernel::subtract<float>(r.velocity, kernel::scaled_vector<float>(in.step.inverse_h, moved)));
  const Point impulse = turned_back(kernel::collide_impulse<float>(seen, m.away, friction));
  r.velocity = kernel::vector_sum<float>(r.velocity, kernel::collide_led<float>(impulse, away, other));
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
Collided collided(const Model& model, const SubstepInput& in, std::uint32_t i, const Point& start,
                  const Point& place, const Point& velocity) {
  Collided r{place, {}, velocity};
  const std::size_t none = in.colliders.size();
  Pressing pressing{none, none};
  std::size_t unmoved = 0;  // number of solids since the last one that touched
  for (std::uint32_t pass = 0; pass < shader::collide_passes && unmoved < none; ++pass)
    for (std::size_t k = 0; k < none && unmoved < none; ++k) {
      const bool touches =
          (model.spared[i] >> k & 1U) == 0 && collided_with(in, k, start, pass == 0, pressing, r);
      unmoved = touches ? 1 : unmoved + 1;
    }
  return r;
}

void collide_explicit(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  const Point x = point_at(fields.vertices, vertex_stride, i),
              v = point_at(fields.velocities, vector_stride, i);
  const Collided c = collided(model, in, i, kernel::collide_start<float>(x, v, in.step.h), x, v);
  if (!c.touches) return;
  put_point(fields.vertices, vertex_stride, i, c.place);
  put_point(fields.velocities, vector_stride, i,
            kernel::collide_velocity<float>(v, c.place, x, c.raised, in.step.inverse_h));
}

void collide_implicit(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  const Point start = point_at(fields.positions_before, vector_stride, i),
              y = point_at(fields.predicted, vector_stride, i),
              pull = kernel::collide_pull<float>(y, point_at(fields.goals, vector_stride, i),
                                                 in.responses[i].to_goal),
              free = kernel::collide_free_velocity<float>(point_at(fields.velocities, vector_stride, i), pull,
                                                          in.implicit.inverse_step);
  // The iterations end outside the solids, so test as well where the vertex would be without what they pushed
  // away.
  Collided c = collided(model, in, i, start, point_at(fields.vertices, vertex_stride, i), free);
  const Collided pushed = collided(model, in, i, start, kernel::vector_sum<float>(y, pull), free);
  if (!c.touches && !pushed.touches) return;
  if (pushed.touches) c.velocity = pushed.velocity;
  const Point impulse = kernel::subtract<float>(c.velocity, free);
  put_point(fields.vertices, vertex_stride, i, c.place);
  put_point(fields.predicted, vector_stride, i, c.place);
  put_point(fields.goals, vector_stride, i, c.place);
  put_point(fields.velocities, vector_stride, i, kernel::snap_vector<float>(c.velocity));
  put_point(fields.positions_before, vector_stride, i,
            kernel::collide_begun<float>(start, c.place, y, pull, impulse, in.step.h));
  put_point(fields.velocities_before, vector_stride, i,
            kernel::snap_vector<float>(
                kernel::vector_sum<float>(point_at(fields.velocities_before, vector_stride, i), impulse)));
}

}  // namespace

void collide_vertex(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  if (model.is_kinematic(i)) return;
  if (model.is_implicit())
    collide_implicit(model, in, fields, i);
  else
    collide_explicit(model, in, fields, i);
}

void obstruct_vertex(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  if (model.is_kinematic(i)) return;
  const Collided c = collided(model, in, i, point_at(fields.positions_before, vector_stride, i),
                              point_at(fields.vertices, vertex_stride, i), Point{});
  if (c.touches) put_point(fields.vertices, vertex_stride, i, c.place);
}

void collide(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto at = [](const Floats& values, std::size_t stride, std::uint32_t i) {
    return values.data() + stride * i;
  };
  if (!model.is_implicit()) {
    const float squared_h = in.step.h * in.step.h;
    const auto way_of = [&](std::uint32_t i) {
      const float* v = at(fields.velocities, vector_stride, i);
      return Way{at(fields.vertices, vertex_stride, i),
                 squared_h * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])};
    };
    for_each_near(model, in, fields, way_of, range, &collide_vertex);
    return;
  }
  // Both tested paths count: one ends at the position, the other at most as far from y as the goal is.
  const auto way_of = [&](std::uint32_t i) {
    const float *start = at(fields.positions_before, vector_stride, i),
                *y = at(fields.predicted, vector_stride, i);
    const float along_goal =
        2.0f * squared_distance(y, start) + 2.0f * squared_distance(at(fields.goals, vector_stride, i), y);
    return Way{start, squared_distance(at(fields.vertices, vertex_stride, i), start) + along_goal};
  };
  for_each_near(model, in, fields, way_of, range, &collide_vertex);
}

void obstruct(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto way_of = [&](std::uint32_t i) {
    const float* end = fields.vertices.data() + vertex_stride * i;
    return Way{end, squared_distance(end, fields.positions_before.data() + vector_stride * i)};
  };
  for_each_near(model, in, fields, way_of, range, &obstruct_vertex);
}

}  // namespace fascicle::cpu_reference
