#include "cpu_reference/solver/collide_stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

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

// A solid with what tells in a few operations that it is out of a vertex's reach. That only rejects, and what
// it rejects the kernel would leave alone, so it decides no bit.
struct Solid {
  const shader::Collider* collider;
  std::uint32_t bit;
  // A plane's normal and height, or the middle of another solid; and how far beyond that it reaches, with
  // twice what it moves by itself.
  Point at;
  float height, reach, turning;
};

Solid solid_of(const shader::Collider& c, std::uint32_t number) {
  Solid solid{&c, 1U << number, {c.yx, c.yy, c.yz}, c.yt - c.radius, 0.0f, 0.0f};
  const auto squared = [](float x, float y, float z) { return x * x + y * y + z * z; };
  float turn = 0.0f;
  const float *now = &c.xx, *before = &c.before_xx;
  for (std::size_t k = 0; k < 12; ++k)
    if (k % 4 != 3) turn += (now[k] - before[k]) * (now[k] - before[k]);
  const float shift = std::sqrt(squared(c.xt - c.before_xt, c.yt - c.before_yt, c.zt - c.before_zt));
  // What rounding may add, many times over.
  constexpr float spare = 1e-4f;
  solid.turning = 2.1f * std::sqrt(turn);
  solid.reach = 2.1f * shift + spare;
  if (c.is_plane > 0.0f) return solid;
  solid.reach += std::sqrt(squared(c.half_x, c.half_y, c.half_z)) + c.radius;
  const Point t{c.xt, c.yt, c.zt};
  const Point back = kernel::collide_turned_back<float>(map_at_end(c).linear, t);
  solid.at = {-back.x, -back.y, -back.z};
  return solid;
}

// Where vertices begin and end, of a range of them: `start` + share x `way`.
struct Ways {
  const float* end;    // vertex_stride
  const float* other;  // vector_stride: velocities, or where they begin
  float h;             // with velocities; 0 where `other` is where they begin
};

// Marks the vertices that may reach the solid: those whose distance at the end is less than twice their way.
// Squares of sums are taken as at most three times the sum of squares. NaN is out of reach of everything.
template <bool is_plane>
void mark(const Solid& solid, const Ways& ways, Range range, std::uint32_t* marks) {
  const float reach = 3.0f * solid.reach * solid.reach, turning = 6.0f * solid.turning * solid.turning;
  const float by_velocity = ways.h * ways.h;
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    const float *x = ways.end + vertex_stride * i, *o = ways.other + vector_stride * i;
    float way = 0.0f;
    if (by_velocity > 0.0f)
      way = by_velocity * (o[0] * o[0] + o[1] * o[1] + o[2] * o[2]);
    else
      way = (x[0] - o[0]) * (x[0] - o[0]) + (x[1] - o[1]) * (x[1] - o[1]) + (x[2] - o[2]) * (x[2] - o[2]);
    const float limit = reach + 12.3f * way + turning * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + way);
    bool may_reach = false;
    if constexpr (is_plane) {
      const float distance = solid.at.x * x[0] + solid.at.y * x[1] + solid.at.z * x[2] + solid.height;
      may_reach = distance <= 0.0f || distance * distance <= limit;
    } else {
      const float a = x[0] - solid.at.x, b = x[1] - solid.at.y, c = x[2] - solid.at.z;
      may_reach = a * a + b * b + c * c <= limit;
    }
    marks[i - range.first] |= may_reach ? solid.bit : 0U;
  }
}

struct Collided {
  Point place;
  bool touches = false;
};

[[gnu::noinline]] void meet(const Solid& solid, const Point& start, Collided& r) {
  const shader::Collider& c = *solid.collider;
  const kernel::CollideShape<float> shape{{c.half_x, c.half_y, c.half_z}, c.radius, c.is_plane};
  const kernel::Transform<float> map = map_at_end(c);
  const Point p0 = kernel::apply<float>(map_at_beginning(c), start), p1 = kernel::apply<float>(map, r.place);
  const kernel::CollideSide<float> first = kernel::collide_side<float>(shape, p0);
  if (!kernel::collide_may_touch<float>(first.distance, kernel::subtract<float>(p1, p0))) return;
  const kernel::CollideMove<float> m =
      kernel::collide_move<float>(shape, first, p0, p1, c.friction, c.lifted);
  if (!(m.touches > 0.0f)) return;
  r.place = kernel::snap_vector<float>(
      kernel::vector_sum<float>(r.place, kernel::collide_turned_back<float>(map.linear, m.move)));
  r.touches = true;
}

std::vector<Solid> solids_of(const SubstepInput& in) {
  std::vector<Solid> solids;
  for (const shader::Collider& c : in.colliders)
    solids.push_back(solid_of(c, static_cast<std::uint32_t>(solids.size())));
  return solids;
}

// Calls use(i) for each free vertex that may reach a solid that holds it.
template <class Use>
void for_each_near(const Model& model, std::span<const Solid> solids, const Ways& ways, Range range,
                   const Use& use) {
  constexpr std::uint32_t block = 256;
  std::array<std::uint32_t, block> marks;
  for (std::uint32_t first = range.first; first < range.last; first += block) {
    const Range part{first, std::min(range.last, first + block)};
    marks.fill(0);
    for (const Solid& solid : solids)
      if (solid.collider->is_plane > 0.0f)
        mark<true>(solid, ways, part, marks.data());
      else
        mark<false>(solid, ways, part, marks.data());
    for (std::uint32_t i = part.first; i < part.last; ++i)
      if ((marks[i - part.first] & ~model.spared[i]) != 0 && !model.is_kinematic(i)) use(i);
  }
}

// A vertex on its way from `start` to `place`, one solid after the other. Once one of them has moved it, it
// may reach others.
Collided collided(std::span<const Solid> solids, std::uint32_t spared, const Point& start,
                  const Point& place) {
  Collided r{place};
  for (const Solid& solid : solids)
    if ((spared & solid.bit) == 0) meet(solid, start, r);
  return r;
}

}  // namespace

void collide(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const bool implicit = model.is_implicit();
  const std::vector<Solid> solids = solids_of(in);
  const Ways ways{fields.vertices.data(),
                  implicit ? fields.positions_before.data() : fields.velocities.data(),
                  implicit ? 0.0f : in.step.h};
  for_each_near(model, solids, ways, range, [&](std::uint32_t i) {
    const Point x = point_at(fields.vertices, vertex_stride, i);
    const Point v = point_at(fields.velocities, vector_stride, i);
    const Point start = implicit ? point_at(fields.positions_before, vector_stride, i)
                                 : kernel::collide_start<float>(x, v, in.step.h);
    const Collided c = collided(solids, model.spared[i], start, x);
    if (!c.touches) return;
    put_point(fields.vertices, vertex_stride, i, c.place);
    const Point before = implicit ? point_at(fields.predicted, vector_stride, i) : x;
    put_point(fields.velocities, vector_stride, i,
              kernel::collide_velocity<float>(v, c.place, before,
                                              implicit ? in.implicit.inverse_step : in.step.inverse_h));
    if (!implicit) return;
    put_point(fields.predicted, vector_stride, i, c.place);
    put_point(fields.goals, vector_stride, i, c.place);
  });
}

void obstruct(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const std::vector<Solid> solids = solids_of(in);
  const Ways ways{fields.vertices.data(), fields.positions_before.data(), 0.0f};
  for_each_near(model, solids, ways, range, [&](std::uint32_t i) {
    const Collided c = collided(solids, model.spared[i], point_at(fields.positions_before, vector_stride, i),
                                point_at(fields.vertices, vertex_stride, i));
    if (c.touches) put_point(fields.vertices, vertex_stride, i, c.place);
  });
}

}  // namespace fascicle::cpu_reference
