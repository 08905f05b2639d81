// Surfaces before they are filled: welding, bones, points inside.
#include <cmath>
#include <ctime>
#include <limits>

#include <gtest/gtest.h>

#include "host/build/bones.h"
#include "host/build/weld.h"
#include "tests/build/scenes.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests {
namespace {

using mesh::SurfaceMesh;
using scene::Vector3d;

TEST(Weld, MakesOneVertexOfEqualOnes) {
  // A cube whose triangles share no vertices.
  const SurfaceMesh cube = cube_surface(2.0);
  SurfaceMesh split;
  for (const auto& t : cube.triangles) {
    const auto first = static_cast<std::uint32_t>(split.vertices.size());
    for (const std::uint32_t corner : t) split.vertices.push_back(cube.vertices[corner]);
    split.triangles.push_back({first, first + 1, first + 2});
  }
  build::Report report;
  const build::WeldedSurface welded = build::weld(split, "test", report);
  EXPECT_EQ(welded.surface.vertices.size(), 8u);
  EXPECT_EQ(welded.surface.triangles.size(), 12u);
  EXPECT_TRUE(report.warnings.empty());
  for (std::size_t v = 0; v < split.vertices.size(); ++v)
    EXPECT_EQ(welded.surface.vertices[welded.of_vertex[v]], split.vertices[v]);
}

TEST(Weld, JoinsWithinABillionthOfTheDiagonalOnly) {
  const double diagonal = 2.0 * std::sqrt(3.0);
  const auto welded_with_gap = [&](double gap) {
    SurfaceMesh cube = cube_surface(2.0);
    // Vertex 8 is a copy of vertex 0, `gap` away, used in one of its triangles.
    cube.vertices.push_back(cube.vertices[0] + Vector3d(-gap, 0, 0));
    for (std::uint32_t& corner : cube.triangles[0])
      if (corner == 0) corner = 8;
    build::Report report;
    return build::weld(cube, "test", report).surface.vertices.size();
  };
  EXPECT_EQ(welded_with_gap(0.5e-9 * diagonal), 8u);
  EXPECT_EQ(welded_with_gap(2e-9 * diagonal), 9u);
}

// Exporters leave vertices behind that no triangle uses: they neither coarsen the weld nor merge with others,
// even if they are very far away.
TEST(Weld, LooseVerticesDecideNothing) {
  // Vertex 8 is used and 8e-9 from vertex 0, twice the distance within which vertices are welded.
  for (const double away : {0.0, 30.0, 1e8, 1e12, 1e90}) {
    SurfaceMesh cube = cube_surface(2.0);
    cube.vertices.push_back(cube.vertices[0] + Vector3d(-8e-9, 0, 0));
    for (std::uint32_t& corner : cube.triangles[0])
      if (corner == 0) corner = 8;
    const std::vector<Vector3d> used = cube.vertices;
    cube.vertices.emplace_back(away, 0.0, 0.0);
    build::Report report;
    const build::WeldedSurface welded = build::weld(cube, "test", report);
    EXPECT_EQ(welded.surface.vertices, used) << away;
  }
}

// Thousands of vertices in one place are one vertex, the first.
TEST(Weld, ManyVerticesMayLieInOnePlace) {
  SurfaceMesh cube = cube_surface(2.0);
  cube.vertices.resize(200'008, cube.vertices[7]);
  cube.triangles[0][0] = 100'000;
  cube.triangles[0][1] = 8;
  cube.triangles[0][2] = 9;
  build::Report report;
  const build::WeldedSurface welded = build::weld(cube, "test", report);
  EXPECT_EQ(welded.surface.triangles.size(), 11u);
  for (std::size_t v = 7; v < cube.vertices.size(); ++v) ASSERT_EQ(welded.of_vertex[v], 7u) << v;
}

TEST(Weld, KeepsTheOrderAndPassesByStrayVertices) {
  SurfaceMesh cube = cube_surface(2.0);
  cube.vertices.insert(cube.vertices.begin(), Vector3d(0.9, 0.9, 0.95));
  for (auto& t : cube.triangles)
    for (std::uint32_t& corner : t) ++corner;
  build::Report report;
  const build::WeldedSurface welded = build::weld(cube, "test", report);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0].text.substr(0, 31), "1 vertex of the surface belongs");
  EXPECT_EQ(welded.surface.vertices, cube_surface(2.0).vertices);
  EXPECT_EQ(welded.surface.vertices[welded.of_vertex[0]], Vector3d(1, 1, 1));
}

// On a lattice, so that strays are often equally far from several vertices.
SurfaceMesh strip_on_a_lattice(std::uint32_t length) {
  SurfaceMesh strip;
  for (std::uint32_t k = 0; k <= length; ++k) {
    strip.vertices.emplace_back(k % 100, k / 100, 0);
    strip.vertices.emplace_back(k % 100, k / 100, 1);
    if (k > 0) strip.triangles.push_back({2 * k - 2, 2 * k - 1, 2 * k});
    if (k > 0) strip.triangles.push_back({2 * k - 1, 2 * k + 1, 2 * k});
  }
  return strip;
}

TEST(Weld, StrayVerticesFollowTheNearestOrTheLowest) {
  SurfaceMesh strip = strip_on_a_lattice(500);
  const std::size_t used = strip.vertices.size();
  for (std::uint32_t k = 0; k < 2000; ++k)
    strip.vertices.emplace_back(k % 97 / 2.0, k % 13 / 2.0 - 1.0, k % 5 / 4.0 + (k % 7 == 0 ? 1e6 : 0.0));
  build::Report report;
  const build::WeldedSurface welded = build::weld(strip, "test", report);
  ASSERT_EQ(welded.surface.vertices.size(), used);
  for (std::size_t v = used; v < strip.vertices.size(); ++v) {
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 1; i < used; ++i)
      if ((strip.vertices[i] - strip.vertices[v]).squaredNorm() <
          (strip.vertices[nearest] - strip.vertices[v]).squaredNorm())
        nearest = i;
    ASSERT_EQ(welded.of_vertex[v], nearest) << v;
  }
}

// Compared one by one, these take half a minute.
TEST(Weld, ManyStrayVerticesAreQuick) {
  SurfaceMesh strip = strip_on_a_lattice(75'000);
  for (std::uint32_t k = 0; k < 150'000; ++k)
    strip.vertices.emplace_back(k % 97, k % 751 + 0.3, k % 13 + 0.2);
  const std::clock_t start = std::clock();
  build::Report report;
  build::weld(strip, "test", report);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 5.0);
}

TEST(Weld, LeavesOutCollapsedTrianglesWithAWarning) {
  SurfaceMesh cube = cube_surface(2.0);
  cube.vertices.push_back(cube.vertices[0]);
  cube.triangles.push_back({0, 8, 1});
  build::Report report;
  EXPECT_EQ(build::weld(cube, "test", report).surface.triangles.size(), 12u);
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_NE(report.warnings[0].text.find("1 triangle has"), std::string::npos);
}

TEST(Weld, WarnsOfCornersThatTheFileRepeats) {
  SurfaceMesh cube = cube_surface(2.0);
  for (const std::uint64_t count : {1u, 12u}) {
    cube.repeated_corners = count;
    build::Report report;
    build::weld(cube, "test", report);
    ASSERT_EQ(report.warnings.size(), 1u);
    EXPECT_EQ(report.warnings[0].text.substr(0, 20),
              count == 1 ? "1 corner of the file" : "12 corners of the fi");
  }
}

TEST(Weld, RefusesMalformedSurfacesWithIds) {
  const auto refusal = [](const std::function<void(SurfaceMesh&)>& spoil, const std::string& part) {
    SurfaceMesh cube = cube_surface(2.0);
    spoil(cube);
    build::Report report;
    expect_refusal([&] { build::weld(cube, "test", report); }, part);
  };
  refusal([](SurfaceMesh& m) { m.triangles.clear(); }, "no triangles");
  refusal([](SurfaceMesh& m) { m.triangles[5][1] = 8; }, "triangle 5 ");
  refusal([](SurfaceMesh& m) { m.vertices[3][2] = std::numeric_limits<double>::quiet_NaN(); }, "vertex 3 ");
  refusal([](SurfaceMesh& m) { std::fill(m.vertices.begin(), m.vertices.end(), Vector3d(1, 2, 3)); },
          "at the same place");
  refusal(
      [](SurfaceMesh& m) {
        for (Vector3d& p : m.vertices) p = {p[0] + 0.3 * p[1] + 0.1 * p[2], 0.0, 0.0};
      },
      "flat to a line");
}

TEST(Bones, GivePointsInsideAndApart) {
  const SurfaceMesh cube = cube_surface(2.0);
  // One bone runs out of the cube; a second bone overlaps the first.
  const std::vector<build::Bone> bones = {{{-0.9, 0, 0}, {3, 0, 0}, {}}, {{0, 0, 0}, {0.5, 0.01, 0}, {}}};
  const std::vector<Vector3d> points = build::points_along_bones(bones, cube, 0.3);
  EXPECT_GE(points.size(), 5u);
  for (std::size_t a = 0; a < points.size(); ++a) {
    EXPECT_LE(points[a].cwiseAbs().maxCoeff(), 1.0 - 0.15 + 1e-12);
    for (std::size_t b = 0; b < a; ++b) EXPECT_GE((points[a] - points[b]).norm(), 0.15);
  }
}

}  // namespace
}  // namespace fascicle::tests
