// What CpuSolver rejects before the kernel, the kernel would leave unchanged. Compares the bits after the
// kernel on marked vertices with those after the kernel on every vertex, as a GPU runs it, over random
// shapes, motions and paths, up to the limits of floats.
#include "cpu_reference/solver/collide_reach.h"

#include <cstring>

#include "cpu_reference/solver/collide_stages.h"
#include "tests/cpu_reference/collide_models.h"

namespace fascicle::tests::collide_reach_test {

namespace {

namespace cpu = cpu_reference;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  // Uniform on a logarithmic scale.
  double size_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool once_in(int times) { return std::uniform_int_distribution<int>(1, times)(engine_) == 1; }
  Vector3d direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(engine_), normal(engine_), normal(engine_)).normalized();
  }
  std::mt19937& engine() { return engine_; }

 private:
  std::mt19937 engine_;
};

// Vertices on paths near solids. `far` is the distance of the whole scene from the origin; it affects only
// rounding.
struct Case {
  Case(unsigned seed, bool implicit, double far) : random(seed) {
    model.vertex_count = vertices;
    model.tag.assign(vertices, 0);
    model.spared.assign(vertices, 0);
    if (implicit) model.stiffness.assign(vertices, 1.0);
    const double h = random.size_between(1e-4, 0.1);
    in.step.h = float(h);
    in.step.inverse_h = float(1.0 / h);
    in.implicit.inverse_step = float(1.5 / h);
    const Vector3d place = far * random.direction();
    scale = random.size_between(0.01, 10.0);
    const int count = 1 + int(random.between(0.0, 3.99));
    for (int k = 0; k < count; ++k) add_solid(place, h);
    model.collider_count = std::uint32_t(count);
    in.colliders = colliders;
    for (cpu::Floats* field : {&fields.velocities, &fields.predicted, &fields.goals, &fields.positions_before,
                               &fields.velocities_before})
      field->assign(cpu::vector_stride * vertices, 0.0f);
    fields.vertices.assign(cpu::vertex_stride * vertices, 0.0f);
    for (std::uint32_t i = 0; i < vertices; ++i) {
      if (random.once_in(20)) model.tag[i] = shader::tag_kinematic;
      if (random.once_in(10)) model.spared[i] = 1u << random.engine()() % 4;
      add_way(i, h);
    }
    in.responses = responses;
  }

  // A solid that stands still, moves slowly, moves by its own size or jumps, and rotates likewise.
  void add_solid(const Vector3d& place, double h) {
    const Solid::Shape shapes[] = {Solid::plane, Solid::sphere, Solid::capsule, Solid::box};
    Solid at = random_solid(shapes[random.engine()() % 4], random.engine());
    at.center = place + scale * at.center;
    at.half_size *= scale;
    at.radius *= random.once_in(3) && at.shape == Solid::plane ? 0.0 : scale;
    Solid before = at;
    if (!random.once_in(3)) before.center += scale * random.size_between(1e-5, 10.0) * random.direction();
    if (!random.once_in(3))
      before.axes = AngleAxisd(random.size_between(1e-5, pi), random.direction()) * at.axes;
    befores.push_back(before);
    ats.push_back(at);
    colliders.push_back(collider(before, at, random.once_in(3) ? 0.0 : random.between(0.0, 2.0), h));
  }

  // A path from a point around a solid's earlier surface, about as long as its distance from it, with or
  // without following the solid's rotation.
  void add_way(std::uint32_t i, double h) {
    const std::size_t k = random.engine()() % ats.size();
    const Solid& before = befores[k];
    Vector3d start = before.center + scale * random.size_between(0.01, 3.0) * random.direction();
    if (before.shape == Solid::plane) start += scale * random.between(-2, 2) * before.axes.col(0);
    const double distance = distance_to(before, start);
    const Vector3d seen = before.axes.transpose() * (start - before.center);
    const Vector3d carried = ats[k].center + ats[k].axes * seen;
    Vector3d towards = random.direction();
    if (!random.once_in(4)) {
      const double step = 1e-3 * scale;
      Vector3d slope;
      for (int a = 0; a < 3; ++a) slope[a] = distance_to(before, start + step * Vector3d::Unit(a)) - distance;
      if (slope.norm() > 0.0) towards = -(ats[k].axes * before.axes.transpose() * slope).normalized();
    }
    const double length = random.once_in(5)
                              ? 0.0
                              : std::abs(distance) * random.size_between(0.9, random.once_in(2) ? 1.1 : 3.0);
    const Vector3d end = (random.once_in(3) ? start : carried) + length * towards;
    put(fields.positions_before, cpu::vector_stride, i, start);
    put(fields.vertices, cpu::vertex_stride, i, end);
    put(fields.velocities, cpu::vector_stride, i, (end - start) / h);
    put(fields.velocities_before, cpu::vector_stride, i, (end - start) / h);
    const float to_goal = float(random.once_in(4) ? 1.0 : random.between(0.0, 1.0));
    responses.push_back({});
    responses.back().to_goal = to_goal;
    // The moving point is either the position or y + to_goal (goal - y).
    const Vector3d y = start + length * random.between(0.0, 1.0) * random.direction();
    put(fields.predicted, cpu::vector_stride, i, y);
    put(fields.goals, cpu::vector_stride, i, y + (end - y) / std::max(0.05, double(to_goal)));
    if (random.once_in(3)) put(fields.vertices, cpu::vertex_stride, i, start);
  }

  static void put(cpu::Floats& to, std::size_t stride, std::uint32_t i, const Vector3d& p) {
    for (int a = 0; a < 3; ++a) to[stride * i + std::size_t(a)] = float(p[a]);
  }

  // Puts a number that is no valid coordinate at a random place.
  void spoil() {
    const float odd[] = {std::numeric_limits<float>::quiet_NaN(),
                         std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity(),
                         3e38f,
                         -1e30f,
                         1e20f,
                         3e19f,
                         -1e18f,
                         std::numeric_limits<float>::denorm_min()};
    cpu::Floats* spoiled[] = {&fields.vertices, &fields.velocities, &fields.predicted, &fields.goals,
                              &fields.positions_before};
    for (std::uint32_t i = 0; i < vertices; ++i) {
      const std::size_t f = random.engine()() % std::size(spoiled);
      const std::size_t stride = f == 0 ? cpu::vertex_stride : cpu::vector_stride;
      (*spoiled[f])[stride * i + random.engine()() % 3] = odd[random.engine()() % std::size(odd)];
    }
    if (random.once_in(2)) {
      float* numbers = &colliders[0].xx;
      numbers[random.engine()() % 24] = odd[random.engine()() % std::size(odd)];
    }
  }

  static constexpr std::uint32_t vertices = 48;
  Random random;
  double scale = 1.0;
  Model model;
  cpu::SubstepInput in;
  cpu::Fields fields;
  std::vector<Solid> befores, ats;
  std::vector<shader::Collider> colliders;
  std::vector<shader::Response> responses;
};

struct Difference {
  std::uint64_t vertices = 0, acted = 0, differ = 0;
};

bool same(const cpu::Floats& a, const cpu::Floats& b, std::size_t stride, std::uint32_t i) {
  return std::memcmp(a.data() + stride * i, b.data() + stride * i, 3 * sizeof(float)) == 0;
}
bool same(const cpu::Fields& a, const cpu::Fields& b, std::uint32_t i) {
  return same(a.vertices, b.vertices, cpu::vertex_stride, i) &&
         same(a.velocities, b.velocities, cpu::vector_stride, i) &&
         same(a.predicted, b.predicted, cpu::vector_stride, i) &&
         same(a.goals, b.goals, cpu::vector_stride, i) &&
         same(a.positions_before, b.positions_before, cpu::vector_stride, i) &&
         same(a.velocities_before, b.velocities_before, cpu::vector_stride, i);
}

using Shrink = std::function<void(cpu::ColliderReach&, const shader::Collider&)>;

// Runs either stage over all vertices of a case, with and without marks.
void compare(Case& one, bool obstructs, const Shrink& shrink, Difference& sum) {
  std::vector<cpu::ColliderReach> reaches = cpu::reaches_of(one.colliders);
  for (std::size_t k = 0; k < reaches.size(); ++k) shrink(reaches[k], one.colliders[k]);
  one.in.reaches = reaches;
  cpu::Fields marked = one.fields, all = one.fields;
  (obstructs ? cpu::obstruct : cpu::collide)(one.model, one.in, marked, {0, Case::vertices});
  for (std::uint32_t i = 0; i < Case::vertices; ++i) {
    (obstructs ? cpu::obstruct_vertex : cpu::collide_vertex)(one.model, one.in, all, i);
    ++sum.vertices;
    sum.acted += !same(all, one.fields, i);
    sum.differ += !same(all, marked, i);
  }
}

Difference compared(
    unsigned cases, double far, bool spoiled, const Shrink& shrink = [](auto&, auto&) {}) {
  Difference sum;
  for (unsigned seed = 0; seed < cases; ++seed)
    for (const bool implicit : {false, true}) {
      Case one(seed, implicit, far);
      if (spoiled) one.spoil();
      compare(one, false, shrink, sum);
      if (implicit) compare(one, true, shrink, sum);
    }
  return sum;
}

TEST(CollideReach, MarksDecideNoBit) {
  for (const double far : {0.0, 1.0, 30.0, 1e3, 1e5, 1e7}) {
    const Difference d = compared(1000, far, false);
    EXPECT_EQ(d.differ, 0u) << far;
    // Both outcomes must occur, or the comparison is empty.
    EXPECT_GT(d.acted, d.vertices / 10) << far;
    EXPECT_LT(d.acted, d.vertices * 9 / 10) << far;
  }
}

TEST(CollideReach, WhatIsNoPlaceIsLeftToTheKernel) {
  for (const double far : {0.0, 1e3}) EXPECT_EQ(compared(1000, far, true).differ, 0u) << far;
}

// The controls: shrinking any part of the bound by a few times is detected.
TEST(CollideReach, SmallerMarksAreSeen) {
  const auto seen = [](double far, const Shrink& shrink) {
    return compared(1000, far, false, shrink).differ;
  };
  EXPECT_GT(seen(0.0, [](cpu::ColliderReach& r, auto&) { r.reach *= 0.1f; }), 100u);
  const std::uint64_t with_turning = seen(0.0, [](cpu::ColliderReach& r, auto&) { r.reach *= 0.03f; });
  EXPECT_GT(seen(0.0,
                 [](cpu::ColliderReach& r, auto&) {
                   r.reach *= 0.03f;
                   r.turning = 0.0f;
                 }),
            with_turning + 100);
  EXPECT_GT(seen(0.0, [](cpu::ColliderReach& r, auto&) { r.height += 0.1f; }), 0u);
  EXPECT_GT(seen(0.0, [](cpu::ColliderReach& r, auto&) { r.bit <<= 1; }), 0u);
  // Far from the origin, rounding moves a vertex by more than the slack that suffices near it.
  const Shrink without_share = [](cpu::ColliderReach& r, const shader::Collider& c) {
    const float far = std::hypot(c.xt, c.yt, c.zt) + c.radius;
    const float reach = std::sqrt(r.reach / 3.0f) - 1e-5f * far,
                turning = std::sqrt(r.turning / 6.0f) - 1e-5f;
    r.reach = 3.0f * reach * reach;
    r.turning = 6.0f * turning * turning;
  };
  EXPECT_EQ(seen(0.0, without_share), 0u);
  EXPECT_GT(seen(1e6, without_share), 20u);
}

// Vertices that touch no solid are mostly rejected, which is the purpose of the marks.
TEST(CollideReach, WhatIsFarIsRejected) {
  Case one(1, false, 0.0);
  const float place[] = {30.0f, 40.0f, 50.0f};
  for (Solid solid : {random_solid(Solid::sphere, one.random.engine()),
                      random_solid(Solid::box, one.random.engine()), floor_at()}) {
    const cpu::ColliderReach reach = cpu::reach_of(collider(solid, solid, 0.5, 0.01));
    const cpu::Way way{place, 1e-4f};
    EXPECT_FALSE(reach.is_plane ? cpu::may_reach<true>(reach, way) : cpu::may_reach<false>(reach, way));
  }
}

}  // namespace

}  // namespace fascicle::tests::collide_reach_test
