// The lowest mode: with and without cube grids, and the grids compared with the body they approximate.
#include "host/build/lowest_mode.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/build/cube_grid.h"
#include "host/scene/scene.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

// The inputs of a search; pins and layers come from the scene.
struct HeldBody {
  explicit HeldBody(const scene::Scene& scene)
      : model(build_quietly(scene)),
        rings{model.ring_offset, model.ring},
        state{model.rest, model.mass, model.fibre, model.beta},
        weights(build::region_weights(rings, state, model.weight_form)),
        k(model.vertex_count, 1.0) {
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) is_free.push_back(model.is_kinematic(i) ? 0 : 1);
  }
  build::ElasticBody elastic() const { return {rings, state, weights, k}; }

  Model model;
  build::OneRings rings;
  build::RestState state;
  build::RegionWeights weights;
  std::vector<double> k;
  std::vector<char> is_free;
};

scene::Scene jittered_bar(std::array<std::uint32_t, 3> vertices) {
  scene::Scene scene = bar_scene();
  scene.geometry = scene::Bar{.vertices = vertices, .jitter = 0.2};
  return scene;
}

double square(const HeldBody& body, std::size_t least_for_grids, std::size_t threads = 2) {
  const auto lowest = build::lowest_mode(body.elastic(), body.is_free,
                                         {.least_for_grids = least_for_grids, .threads = threads});
  EXPECT_TRUE(lowest && lowest->settled);
  return lowest->square;
}

// Both converge from above and stop when further iterations gain less than 1e-5. The two bending modes of a
// bar with a square cross-section are a few per cent apart, which makes a search without grids slow.
TEST(LowestMode, ByGridsIsThatWithout) {
  constexpr std::size_t never = 1000000;
  for (const std::array<std::uint32_t, 3> vertices :
       {std::array{31u, 7u, 7u}, {41u, 9u, 5u}, {13u, 13u, 13u}}) {
    const HeldBody body(jittered_bar(vertices));
    const double without = square(body, never);
    EXPECT_NEAR(square(body, 0), without, 1e-3 * without) << vertices[0];
  }
}

// The mode follows from the stiffness per mass. Powers of two keep every bit, also of the small term that
// keeps a region on a line from dividing by zero.
TEST(LowestMode, DoesNotDependOnTheUnitsOfMassAndLength) {
  constexpr std::size_t never = 1000000;
  HeldBody body(jittered_bar({13, 5, 5}));
  const double before = square(body, never);
  for (double& mass : body.model.mass) mass *= 0x1p-20;
  for (float& coordinate : body.model.rest) coordinate *= 0x1p-7f;
  body.weights = build::region_weights(body.rings, body.state, body.model.weight_form);
  EXPECT_NEAR(square(body, never), before, 1e-5 * before);
}

// Two parts separated by a wall thicker than a region; the longer part has the lower mode.
TEST(LowestMode, FindsTheLowestOfSeveralParts) {
  HeldBody body(jittered_bar({41, 9, 5}));
  const double whole = square(body, 0);
  for (std::uint32_t i = 0; i < body.model.vertex_count; ++i)
    if (std::abs(body.model.rest[3 * i] - 0.04f) < 0.08f) body.is_free[i] = 0;
  const double parts = square(body, 0);
  EXPECT_GT(parts, whole);
  double lowest = 1e30;
  for (const float side : {-1.0f, 1.0f}) {
    HeldBody part = body;
    for (std::uint32_t i = 0; i < part.model.vertex_count; ++i)
      if (side * (part.model.rest[3 * i] - 0.04f) < 0.0f) part.is_free[i] = 0;
    lowest = std::min(lowest, square(part, 1000000));
  }
  EXPECT_NEAR(parts, lowest, 1e-3 * lowest);
}

// For `count` vertices or nodes, without a preferred direction.
std::vector<Vector3d> waves(std::size_t count, double step) {
  std::vector<Vector3d> x;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = step * static_cast<double>(i);
    x.emplace_back(std::sin(at), std::cos(2.0 * at), std::sin(3.0 * at));
  }
  return x;
}

// More vertices than one thread takes, so the body is split.
TEST(LowestMode, DoesNotDependOnThreads) {
  const HeldBody body(jittered_bar({141, 17, 17}));
  const double by_one = square(body, 0, 1);
  EXPECT_EQ(square(body, 0, 2), by_one);
  EXPECT_EQ(square(body, 0, 5), by_one);

  const build::RegionStiffness one(body.elastic(), body.is_free, 1), two(body.elastic(), body.is_free, 2);
  std::vector<Vector3d> x = waves(one.size(), 1.0), by_two, alone;
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!body.is_free[i]) x[i] = Vector3d::Zero();
  one.apply(x, alone);
  two.apply(x, by_two);
  EXPECT_EQ(alone, by_two);
}

// The pull on a vertex is the sum of its shares of the regions that hold it, the first and the last vertex
// included. A sum of about 15 terms rounds in the last digits.
TEST(RegionStiffness, SharesSumToThePullOnAVertex) {
  HeldBody body(jittered_bar({7, 5, 5}));
  for (std::size_t r = 0; r < body.k.size(); ++r) body.k[r] = 1.0 + 0.01 * static_cast<double>(r);
  const build::RegionStiffness stiffness(body.elastic(), body.is_free, 1);
  std::vector<double> sum(stiffness.size(), 0.0);
  for (std::size_t r = 0; r < stiffness.size(); ++r)
    stiffness.for_each_member(r, [&](std::size_t i, double w, const Vector3d&) { sum[i] += w; });
  for (std::size_t i = 0; i < sum.size(); ++i) {
    double expected = body.k[i];
    for (const std::uint32_t r : body.rings[i]) expected += body.k[r];
    expected *= body.model.mass[i];
    EXPECT_NEAR(stiffness.diagonal(i), expected, 1e-12 * expected) << i;
    EXPECT_NEAR(sum[i], expected, 1e-12 * expected) << i;
  }
}

double energy(const build::CubeGrid& grid, const std::vector<Vector3d>& x) {
  double sum = 0.0;
  for (std::size_t k = 0; k < grid.place.size(); ++k)
    for (std::size_t a = 0; a < 24; ++a)
      for (std::size_t b = 0; b < 24; ++b) {
        const std::size_t row = std::max(a, b), column = std::min(a, b);
        sum += x[grid.corner[k][a / 3]][static_cast<int>(a % 3)] *
               grid.stiffness[k][row * (row + 1) / 2 + column] *
               x[grid.corner[k][b / 3]][static_cast<int>(b % 3)];
      }
  return sum;
}

// Cubes of any size represent an affine displacement exactly, so its energy equals the body's.
TEST(CubeGrid, AnAffineDisplacementHasTheBodysEnergy) {
  HeldBody body(jittered_bar({21, 7, 7}));
  body.is_free.assign(body.is_free.size(), 1);
  const build::RegionStiffness stiffness(body.elastic(), body.is_free, 1);
  build::BodyGrid fine = build::grid_of_body(stiffness, 3.0 * stiffness.mean_edge());
  const build::CubeGrid coarse = build::coarser_grid(fine.grid);
  Matrix3d gradient;
  gradient << 0.3, -0.2, 0.5, 0.1, 0.4, -0.6, -0.7, 0.2, 0.9;
  const Vector3d shift(0.2, -0.4, 0.3);

  std::vector<Vector3d> x, Lx;
  for (std::size_t i = 0; i < stiffness.size(); ++i) x.push_back(gradient * stiffness.rest(i) + shift);
  stiffness.apply(x, Lx);
  double expected = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) expected += x[i].dot(Lx[i]);
  ASSERT_GT(expected, 0.0);

  const auto nodes_of = [&](const build::CubeGrid& grid) {
    std::vector<Vector3d> nodes(grid.node.size());
    for (std::size_t k = 0; k < grid.place.size(); ++k)
      for (std::size_t c = 0; c < 8; ++c) {
        const auto& place = grid.place[k];
        const auto along = [&](std::size_t axis) {
          return static_cast<double>(place[axis] + (c >> axis & 1u));
        };
        const Vector3d at(along(0), along(1), along(2));
        nodes[grid.corner[k][c]] = gradient * (grid.origin + grid.size * at) + shift;
      }
    return nodes;
  };
  EXPECT_LT(coarse.place.size(), fine.grid.place.size());
  const std::vector<Vector3d> on_fine = nodes_of(fine.grid), on_coarse = nodes_of(coarse);
  EXPECT_NEAR(energy(fine.grid, on_fine), expected, 1e-9 * expected);
  EXPECT_NEAR(energy(coarse, on_coarse), expected, 1e-9 * expected);

  std::vector<Vector3d> moved(x.size(), Vector3d::Zero());
  build::add_on_body(fine, stiffness, on_fine, moved);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR((moved[i] - x[i]).norm(), 0.0, 1e-12);
  const std::vector<Vector3d> interpolated = build::on_finer_grid(coarse, fine.grid, on_coarse);
  for (std::size_t i = 0; i < on_fine.size(); ++i)
    EXPECT_NEAR((interpolated[i] - on_fine[i]).norm(), 0.0, 1e-12);
}

// The work of a force on a displacement is the same on the body and on its grids.
TEST(CubeGrid, ForcesTakeTheTransposedWay) {
  const HeldBody body(jittered_bar({21, 7, 7}));
  const build::RegionStiffness stiffness(body.elastic(), body.is_free, 2);
  build::BodyGrid fine = build::grid_of_body(stiffness, 3.0 * stiffness.mean_edge());
  const build::CubeGrid coarse = build::coarser_grid(fine.grid);
  const auto work = [](const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
  };
  const std::vector<Vector3d> x = waves(coarse.node.size(), 0.7), force = waves(stiffness.size(), 0.3);
  const std::vector<Vector3d> on_fine = build::on_finer_grid(coarse, fine.grid, x);
  std::vector<Vector3d> moved(stiffness.size(), Vector3d::Zero());
  build::add_on_body(fine, stiffness, on_fine, moved);
  const std::vector<Vector3d> on_grid = build::onto_grid(fine, stiffness, force);
  EXPECT_NEAR(work(on_fine, on_grid), work(moved, force), 1e-9);
  EXPECT_NEAR(work(x, build::onto_coarser_grid(coarse, fine.grid, on_grid)), work(moved, force), 1e-9);
}

}  // namespace
}  // namespace fascicle::tests
