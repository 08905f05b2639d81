// Parametric bars: counts, volumes, jitter.
#include "host/build/bar.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "host/build/mass.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using build::signed_volume;

double smallest_volume(const mesh::TetMesh& mesh) {
  double smallest = 1e300;
  for (const auto& t : mesh.tetrahedra) smallest = std::min(smallest, signed_volume(mesh, t));
  return smallest;
}

TEST(Bar, HasSixEqualTetrahedraACell) {
  const mesh::TetMesh mesh = build::make_bar({.size = {0.4, 0.1, 0.2}, .vertices = {5, 3, 4}}, "test");
  ASSERT_EQ(mesh.vertices.size(), 60u);
  ASSERT_EQ(mesh.tetrahedra.size(), 4u * 2u * 3u * 6u);
  const double each = 0.4 * 0.1 * 0.2 / 144.0;
  // Coordinates below 0.5 are rounded to 2^-54 and edges are about 0.07, so the relative error of a volume is
  // a few 2^-50.
  for (const auto& t : mesh.tetrahedra) EXPECT_NEAR(signed_volume(mesh, t), each, each * 1e-13);
}

// Cells of a bar are divided along one body diagonal, and each of their faces along one diagonal.
TEST(Bar, ReportsItsEdges) {
  scene::Scene scene = bar_scene();
  scene.geometry = scene::Bar{.size = {0.3, 0.1, 0.1}, .vertices = {4, 2, 2}};
  build::Report report;
  build::build_model(scene, report);
  const double edges = 28, faces = 16, cells = 3;
  EXPECT_NEAR(report.shortest_edge, 0.1, 1e-15);
  EXPECT_NEAR(report.longest_edge, 0.1 * std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(report.mean_edge,
              0.1 * (edges + faces * std::sqrt(2.0) + cells * std::sqrt(3.0)) / (edges + faces + cells),
              1e-15);
}

TEST(Bar, SpansItsSizeExactly) {
  const scene::Bar bar{.size = {0.3, 0.7, 1.1}, .vertices = {7, 4, 12}, .jitter = 0.3};
  const mesh::TetMesh mesh = build::make_bar(bar, "test");
  scene::Vector3d low = mesh.vertices[0], high = low;
  for (const auto& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  EXPECT_EQ(low, scene::Vector3d::Zero());
  EXPECT_EQ(high, bar.size);
}

TEST(Bar, StaysPositiveUnderTheLargestJitter) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const scene::Bar bar{.vertices = {12, 7, 6}, .jitter = 0.3, .seed = seed};
    const double whole = bar.size.prod() / (11.0 * 6.0 * 5.0 * 6.0);
    EXPECT_GE(smallest_volume(build::make_bar(bar, "test")), 0.1 * whole) << "seed " << seed;
  }
}

TEST(Bar, JitterMovesInsideVerticesOnlyAndNoFurtherThanAsked) {
  const scene::Bar still{.vertices = {6, 5, 7}};
  scene::Bar jittered = still;
  jittered.jitter = 0.2;
  const mesh::TetMesh a = build::make_bar(still, "test");
  const mesh::TetMesh b = build::make_bar(jittered, "test");
  const scene::Vector3d spacing = still.size.cwiseQuotient(scene::Vector3d(5, 4, 6));
  std::size_t moved = 0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    const bool inside =
        (a.vertices[i].array() > 0.0).all() && (a.vertices[i].array() < still.size.array()).all();
    const scene::Vector3d d = b.vertices[i] - a.vertices[i];
    if (!inside) {
      EXPECT_EQ(d, scene::Vector3d::Zero());
    }
    // The slack is for the difference of two rounded coordinates.
    for (int k = 0; k < 3; ++k) EXPECT_LE(std::abs(d[k]), 0.2 * spacing[k] + 1e-15);
    moved += d.norm() > 0.0;
  }
  EXPECT_EQ(moved, 4u * 3u * 5u);
}

TEST(Bar, JitterFollowsItsSeed) {
  const scene::Bar one{.vertices = {4, 4, 4}, .jitter = 0.1, .seed = 7};
  scene::Bar other = one;
  other.seed = 8;
  EXPECT_EQ(build::make_bar(one, "test").vertices, build::make_bar(one, "test").vertices);
  EXPECT_NE(build::make_bar(one, "test").vertices, build::make_bar(other, "test").vertices);
}

// SplitMix64 from seed 1 begins with 0x910a2dec89025cc1 (any published implementation); the first
// displacement is computed from it by hand.
TEST(Bar, JitterIsTheSameOnEveryMachine) {
  const mesh::TetMesh mesh =
      build::make_bar({.size = {2, 2, 2}, .vertices = {3, 3, 3}, .jitter = 0.1, .seed = 1}, "test");
  const double expected = static_cast<double>(0x910a2dec89025cc1u >> 11) * 0x1p-52 - 1.0;
  EXPECT_EQ(mesh.vertices[13][0], 1.0 + 0.1 * expected);
}

TEST(Bar, RefusesWhatIsNoBar) {
  expect_refusal([] { build::make_bar({.vertices = {1, 5, 5}}, "here"); }, "here: bar: vertices");
  expect_refusal([] { build::make_bar({.size = {0.4, 0.0, 0.1}}, "here"); }, "size");
  expect_refusal([] { build::make_bar({.size = {0.4, NAN, 0.1}}, "here"); }, "size");
  expect_refusal([] { build::make_bar({.size = {0.4, 1e-30, 0.1}}, "here"); }, "here: bar: size");
  expect_refusal([] { build::make_bar({.vertices = {4000, 4000, 4000}}, "here"); }, "coarser");
  expect_refusal([] { build::make_bar({.jitter = 0.5}, "here"); }, "jitter");
}

TEST(Bar, BuildsAModelThatKeepsItsPromises) {
  for (const double jitter : {0.0, 0.25}) {
    scene::Scene scene = bar_scene();
    std::get<scene::Bar>(scene.geometry).jitter = jitter;
    build::Report report;
    const model::Model model = build::build_model(scene, report);
    EXPECT_NO_THROW(model::check_model(model));
    EXPECT_EQ(report.vertices, 525u);
    EXPECT_EQ(report.tetrahedra, 20u * 4u * 4u * 6u);
    // A closed surface of genus 0: V - E + F = 2 with E = 3F/2.
    EXPECT_EQ(2 * report.surface_vertices, report.surface_triangles + 4);
    EXPECT_EQ(report.pinned_vertices, 25u);
    EXPECT_EQ(report.flipped_tetrahedra, 0u);
    EXPECT_TRUE(report.warnings.empty());
  }
}

}  // namespace
}  // namespace fascicle::tests
