#include "cpu_reference/solver/collide_stages.h"

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

struct Collided {
  Point place;
  bool touches = false;
};

// Vertex i on its way from `start` to `place`, one solid after the other.
Collided collided(const Model& model, const SubstepInput& in, std::uint32_t i, const Point& start,
                  const Point& place) {
  Collided r{place};
  for (std::uint32_t k = 0; k < in.colliders.size(); ++k) {
    if ((model.spared[i] >> k & 1U) != 0) continue;
    const shader::Collider& c = in.colliders[k];
    const kernel::CollideShape<float> shape{{c.half_x, c.half_y, c.half_z}, c.radius, c.is_plane};
    const kernel::Transform<float> map = map_at_end(c);
    const Point p0 = kernel::apply<float>(map_at_beginning(c), start),
                p1 = kernel::apply<float>(map, r.place);
    const kernel::CollideSide<float> first = kernel::collide_side<float>(shape, p0);
    if (!kernel::collide_may_touch<float>(first.distance, kernel::subtract<float>(p1, p0))) continue;
    const kernel::CollideMove<float> m =
        kernel::collide_move<float>(shape, first, p0, p1, c.friction, c.lifted);
    if (!(m.touches > 0.0f)) continue;
    r.place = kernel::snap_vector<float>(
        kernel::vector_sum<float>(r.place, kernel::collide_turned_back<float>(map.linear, m.move)));
    r.touches = true;
  }
  return r;
}

}  // namespace

void collide(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const bool implicit = model.is_implicit();
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_kinematic(i)) continue;
    const Point x = point_at(fields.vertices, vertex_stride, i);
    const Point v = point_at(fields.velocities, vector_stride, i);
    const Point start = implicit ? point_at(fields.positions_before, vector_stride, i)
                                 : kernel::collide_start<float>(x, v, in.step.h);
    const Collided c = collided(model, in, i, start, x);
    if (!c.touches) continue;
    put_point(fields.vertices, vertex_stride, i, c.place);
    const Point before = implicit ? point_at(fields.predicted, vector_stride, i) : x;
    put_point(fields.velocities, vector_stride, i,
              kernel::collide_velocity<float>(v, c.place, before,
                                              implicit ? in.implicit.inverse_step : in.step.inverse_h));
    if (!implicit) continue;
    put_point(fields.predicted, vector_stride, i, c.place);
    put_point(fields.goals, vector_stride, i, c.place);
  }
}

void obstruct(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_kinematic(i)) continue;
    const Collided c = collided(model, in, i, point_at(fields.positions_before, vector_stride, i),
                                point_at(fields.vertices, vertex_stride, i));
    if (c.touches) put_point(fields.vertices, vertex_stride, i, c.place);
  }
}

}  // namespace fascicle::cpu_reference
