// Smoothing, compared with positions known by symmetry, and on a distorted mesh.
#include "host/build/smooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/mass.h"

namespace fascicle::tests {
namespace {

using mesh::TetMesh;
using scene::Vector3d;

double worst_quality(const TetMesh& mesh) {
  double worst = 1.0;
  for (const auto& t : mesh.tetrahedra) worst = std::min(worst, build::shape_quality(mesh, t));
  return worst;
}

// A point inside an octahedron, connected to its eight faces.
TetMesh octahedron(const Vector3d& middle) {
  TetMesh mesh;
  mesh.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, middle};
  for (std::uint32_t x = 0; x < 2; ++x)
    for (std::uint32_t y = 2; y < 4; ++y)
      for (std::uint32_t z = 4; z < 6; ++z) {
        std::array<std::uint32_t, 4> t{x, y, z, 6};
        if (!(build::signed_volume(mesh, t) > 0.0)) std::swap(t[0], t[1]);
        mesh.tetrahedra.push_back(t);
      }
  return mesh;
}

// Kuhn tetrahedra; inner vertices are displaced by up to two fifths of the spacing unless that inverts a
// tetrahedron.
TetMesh shaken_bar() {
  TetMesh mesh = build::make_bar({.size = {8.0, 5.0, 5.0}, .vertices = {9, 6, 6}}, "test");
  std::vector<char> outside(mesh.vertices.size(), 0);
  for (const auto& t : build::boundary_triangles(mesh, "test"))
    for (const std::uint32_t corner : t) outside[corner] = 1;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-0.4, 0.4);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (outside[i]) continue;
    const Vector3d before = mesh.vertices[i];
    mesh.vertices[i] += Vector3d(shake(random), shake(random), shake(random));
    for (const auto& t : mesh.tetrahedra)
      if (!(build::signed_volume(mesh, t) > 0.0)) mesh.vertices[i] = before;
  }
  return mesh;
}

TEST(Smooth, QualityIsOneForTheRegularTetrahedronWhateverItsSizeAndNothingForAFlatOne) {
  const std::array<std::uint32_t, 4> t{0, 1, 2, 3};
  for (const double size : {1.0, 1e-3, 40.0}) {
    const TetMesh regular{{size * Vector3d(1, 1, 1), size * Vector3d(-1, -1, 1), size * Vector3d(-1, 1, -1),
                           size * Vector3d(1, -1, -1)},
                          {t}};
    // The tolerance covers about a dozen roundings.
    EXPECT_NEAR(build::shape_quality(regular, t), 1.0, 1e-14) << size;
  }
  const TetMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {t}};
  EXPECT_EQ(build::shape_quality(flat, t), 0.0);
}

TEST(Smooth, AVertexGoesToTheMiddleOfAnOctahedron) {
  TetMesh mesh = octahedron({0.5, -0.3, 0.1});
  build::smooth_inside(mesh, std::vector<char>(7, 0));
  // Near the centre the sum is 1 + 2.8 |x|^2 times its minimum, and smoothing stops when a step gains less
  // than a thousandth: at 0.03, 2.5 thousandths remain. The vertex starts at 0.59.
  EXPECT_LT(mesh.vertices[6].norm(), 0.03);
  const TetMesh before = octahedron({0.5, -0.3, 0.1});
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(mesh.vertices[i], before.vertices[i]) << i;
}

TEST(Smooth, WhatIsFixedStays) {
  const Vector3d place(0.5, -0.3, 0.1);
  TetMesh mesh = octahedron(place);
  build::smooth_inside(mesh, {0, 0, 0, 0, 0, 0, 1});
  EXPECT_EQ(mesh.vertices[6], place);
}

TEST(Smooth, AShakenBarLosesItsFlatTetrahedraAndKeepsItsOutside) {
  TetMesh mesh = shaken_bar();
  const TetMesh before = mesh;
  const double shaken = worst_quality(mesh);
  // All of Kuhn's tetrahedra have (2/3)^3 3/4 = 0.22, so smoothing can meet this bound.
  const double still =
      worst_quality(build::make_bar({.size = {8.0, 5.0, 5.0}, .vertices = {9, 6, 6}}, "test"));
  ASSERT_LT(shaken, 0.01);
  build::smooth_inside(mesh, std::vector<char>(mesh.vertices.size(), 0));
  EXPECT_GT(worst_quality(mesh), 0.5 * still);
  const auto outside = build::boundary_triangles(before, "test");
  EXPECT_EQ(build::boundary_triangles(mesh, "test"), outside);
  for (const auto& t : outside)
    for (const std::uint32_t corner : t) EXPECT_EQ(mesh.vertices[corner], before.vertices[corner]);
  for (const auto& t : mesh.tetrahedra) EXPECT_GT(build::signed_volume(mesh, t), 0.0);
}

}  // namespace
}  // namespace fascicle::tests
