// Cages: defects found in a skin, when a skin is wrapped, and that the wrap contains all of it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "host/build/boundary.h"
#include "host/build/build.h"
#include "host/build/check_mesh.h"
#include "host/build/embedding.h"
#include "host/build/mass.h"
#include "host/build/tetrahedralize.h"
#include "host/build/wrap.h"
#include "tests/build/cages.h"
#include "tests/build/made_surfaces.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::Vector3d;

// The smallest barycentric coordinate of any skin point in its best tetrahedron; found by exhaustive search,
// without the builder's homes.
double least_of_all(const TetMesh& mesh, const SurfaceMesh& skin) {
  double least = 1.0;
  for (const Vector3d& p : skin.vertices) {
    double best = -1e30;
    for (std::size_t i = 0; i < mesh.tetrahedra.size() && best < 0.0; ++i) {
      const auto weights = build::barycentric(mesh, mesh.tetrahedra[i], p);
      best = std::max(best, *std::min_element(weights.begin(), weights.end()));
    }
    least = std::min(least, best);
  }
  return least;
}

SurfaceMesh open_box() {
  SurfaceMesh box = cube_surface(1.0);
  box.triangles.pop_back();
  box.triangles.pop_back();
  return box;
}

SurfaceMesh cubes_at_an_edge() {
  SurfaceMesh cubes = cube_surface(1.0);
  append(cubes, cube_surface(1.0), Vector3d(1, 1, 0));
  build::Report report;
  return build::weld(cubes, "test", report).surface;
}

SurfaceMesh crossing_balls() {
  SurfaceMesh balls = ball(0.5, 24);
  append(balls, ball(0.5, 24), Vector3d(0.6, 0.013, 0.007));
  return balls;
}

TEST(Findings, OfACleanSurface) {
  const build::SurfaceFindings found = build::find_defects(ball(1.0, 16), with_mesher());
  EXPECT_EQ(found.parts.count, 1u);
  EXPECT_EQ(found.open_edges.count, 0u);
  EXPECT_EQ(found.non_manifold_edges.count, 0u);
  EXPECT_EQ(found.non_manifold_vertices.count, 0u);
  EXPECT_EQ(found.turned_edges.count, 0u);
  EXPECT_EQ(found.inverted_parts.count, 0u);
  EXPECT_EQ(found.intersections.count, 0u);
  EXPECT_EQ(found.genus, 0);
}

TEST(Findings, OfAnOpenBox) {
  const build::SurfaceFindings found = build::find_defects(open_box(), with_mesher());
  EXPECT_EQ(found.open_edges.count, 4u);
  // The missing side is the cube's last: x = 1, vertices 1, 3, 5 and 7.
  EXPECT_EQ(std::set<std::uint32_t>(found.open_edges.vertices.begin(), found.open_edges.vertices.end()),
            (std::set<std::uint32_t>{1, 3, 5, 7}));
  EXPECT_EQ(found.inverted_parts.count, 0u);
}

TEST(Findings, OfCubesThatShareAnEdge) {
  const build::SurfaceFindings found = build::find_defects(cubes_at_an_edge(), with_mesher());
  EXPECT_EQ(found.parts.count, 1u);
  EXPECT_EQ(found.non_manifold_edges.count, 1u);
  EXPECT_EQ(found.open_edges.count, 0u);
}

TEST(Findings, OfCubesThatShareACorner) {
  SurfaceMesh cubes = cube_surface(1.0);
  append(cubes, cube_surface(1.0), Vector3d(1, 1, 1));
  build::Report report;
  const build::SurfaceFindings found =
      build::find_defects(build::weld(cubes, "test", report).surface, with_mesher());
  ASSERT_EQ(found.non_manifold_vertices.count, 1u);
  EXPECT_EQ(found.non_manifold_vertices.vertices, (std::vector<std::uint32_t>{7}));
  EXPECT_EQ(found.non_manifold_edges.count, 0u);
}

TEST(Findings, OfCrossingBalls) {
  const build::SurfaceFindings found = build::find_defects(crossing_balls(), with_mesher());
  EXPECT_EQ(found.parts.count, 2u);
  EXPECT_GT(found.intersections.count, 0u);
  EXPECT_FALSE(found.intersections.vertices.empty());
  EXPECT_EQ(found.open_edges.count, 0u);
}

TEST(Findings, OfSurfacesThatFaceWrong) {
  SurfaceMesh inverted = ball(1.0, 8);
  for (auto& t : inverted.triangles) std::swap(t[1], t[2]);
  const build::SurfaceFindings inside_out = build::find_defects(inverted, with_mesher());
  EXPECT_EQ(inside_out.inverted_parts.count, 1u);
  EXPECT_EQ(inside_out.turned_edges.count, 0u);

  SurfaceMesh turned = ball(1.0, 8);
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  EXPECT_EQ(build::find_defects(turned, with_mesher()).turned_edges.count, 3u);
}

TEST(Findings, CountHandles) {
  // A square ring, like a picture frame.
  SurfaceMesh ring;
  for (const double z : {0.0, 1.0})
    for (const double r : {1.0, 2.0})
      for (int k = 0; k < 4; ++k)
        ring.vertices.push_back(Vector3d(k == 0 || k == 3 ? r : -r, k < 2 ? r : -r, z));
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t n = (k + 1) % 4;
    const auto wall = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
      ring.triangles.push_back({a, b, c});
      ring.triangles.push_back({a, c, d});
    };
    wall(4 + k, 4 + n, 12 + n, 12 + k);  // outside
    wall(n, k, 8 + k, 8 + n);            // inside
    wall(8 + k, 12 + k, 12 + n, 8 + n);  // top
    wall(k, n, 4 + n, 4 + k);            // bottom
  }
  const build::SurfaceFindings found = build::find_defects(ring, with_mesher());
  EXPECT_EQ(found.open_edges.count, 0u);
  EXPECT_EQ(found.turned_edges.count, 0u);
  EXPECT_EQ(found.genus, 1);
}

TEST(Cage, CleanSurfacesAreKept) {
  const Filled filled = fill(scene_of(ball(0.5, 16)));
  EXPECT_TRUE(filled.body.keeps_skin);
  EXPECT_FALSE(filled.report.fill.cage.is_cage);
  EXPECT_TRUE(filled.body.anchor.empty());
  for (std::size_t v = 0; v < filled.welded.surface.vertices.size(); ++v)
    EXPECT_EQ(filled.body.mesh.vertices[v], filled.welded.surface.vertices[v]);
}

TEST(Cage, OffRefusesWhatCannotBeFilled) {
  expect_refusal([] { fill(scene_of(open_box(), scene::Cage::off)); }, "has only one triangle");
}

// A surface that cannot be filled directly gets a cage that can and that contains all of it.
void expect_cage(const SurfaceMesh& surface, const std::string& reason) {
  scene::Scene scene = scene_of(surface);
  scene.body.vertices = 1500;
  scene.body.cage_detail = 30.0;
  const Filled filled = fill(scene);
  EXPECT_FALSE(filled.body.keeps_skin);
  EXPECT_NE(filled.report.fill.cage.reason.find(reason), std::string::npos) << filled.report.fill.cage.reason;
  EXPECT_GE(least_of_all(filled.body.mesh, filled.welded.surface), -0.05);
  EXPECT_GE(least_at_home(filled), -0.05);
  for (const auto& t : filled.body.mesh.tetrahedra) ASSERT_GT(build::signed_volume(filled.body.mesh, t), 0.0);
  EXPECT_NO_THROW(build::boundary_triangles(filled.body.mesh, "test"));
  // The bound on unevenness.
  EXPECT_LE(filled.report.fill.cage.spacing.ratio(), 4.0);
}

TEST(Cage, HoldsAnOpenBox) {
  expect_cage(open_box(), "4 open edges");
}

TEST(Cage, HoldsCubesThatShareAnEdge) {
  expect_cage(cubes_at_an_edge(), "1 edge of more than two triangles");
}

TEST(Cage, HoldsCrossingBalls) {
  expect_cage(crossing_balls(), "2 parts");
}

TEST(Cage, OfCrossingBallsIsOneSolid) {
  scene::Scene scene = scene_of(crossing_balls());
  scene.body.vertices = 3000;
  const Filled filled = fill(scene);
  EXPECT_EQ(parts_of(filled.body.mesh), 1u);
  // Two balls of radius r with centres d apart, minus their common lens.
  constexpr double pi = 3.14159265358979, r = 0.5;
  const double d = Vector3d(0.6, 0.013, 0.007).norm();
  const double lens = pi * (4.0 * r + d) * (2.0 * r - d) * (2.0 * r - d) / 12.0;
  const double both = 2.0 * 4.0 / 3.0 * pi * r * r * r - lens;
  // Lower bound: balls with 24 facets around enclose 2.5 % less. Upper bound: a cage may add 8 %.
  EXPECT_GT(build::total_volume(filled.body.mesh), 0.97 * both);
  EXPECT_LT(build::total_volume(filled.body.mesh), 1.08 * both);
}

TEST(Cage, FollowsTheResolution) {
  for (const std::uint32_t wanted : {1000u, 4000u}) {
    scene::Scene scene = scene_of(ball(0.5, 24), scene::Cage::wrap);
    scene.body.vertices = wanted;
    const auto got = static_cast<double>(fill(scene).body.mesh.vertices.size());
    // The number is only a target: TetGen's count varies by some per cent with the shape.
    EXPECT_NEAR(got, wanted, 0.25 * wanted);
  }
  scene::Scene scene = scene_of(ball(0.5, 24), scene::Cage::wrap);
  scene.resolution = 0.08;
  const Filled filled = fill(scene);
  EXPECT_LT(filled.report.fill.cage.edges.low, 0.08);
  EXPECT_GT(filled.report.fill.cage.edges.high, 0.08);
  EXPECT_NEAR((filled.report.fill.cage.edges.low + filled.report.fill.cage.edges.high) / 2.0, 0.08, 0.016);
}

TEST(Cage, KeptInsidesFollowTheResolution) {
  scene::Scene scene = scene_of(ball(0.5, 24), scene::Cage::off);
  scene.body.vertices = 6000;
  const auto got = static_cast<double>(fill(scene).body.mesh.vertices.size());
  EXPECT_NEAR(got, 6000.0, 0.25 * 6000.0);
}

// A closed box, facing outward, with two triangles a side.
SurfaceMesh box_of(const Vector3d& size) {
  SurfaceMesh box;
  for (int k = 0; k < 8; ++k)
    box.vertices.emplace_back(k & 1 ? size.x() : 0.0, k & 2 ? size.y() : 0.0, k & 4 ? size.z() : 0.0);
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return box;
}

// The requested vertices cover the two large sides. Derived from the volume alone, edges would be a
// thousandth of that length, and the wrap would have a million times as many vertices.
TEST(Cage, ANearlyFlatSkinIsWrappedAsFineAsItsVerticesCoverIt) {
  for (const double height : {1e-9, 0.05}) {
    scene::Scene scene = scene_of(box_of({1.0, height, 1.0}), scene::Cage::wrap);
    scene.body.vertices = 500;
    scene.body.cage_detail = 50.0;
    const Filled filled = fill(scene);
    // 2 m^2 covered by 500 vertices in equilateral triangles: 68 mm. A gap is a fiftieth of the diagonal: 28
    // mm.
    EXPECT_NEAR(filled.report.fill.cage.alpha, std::sqrt(2.0) / 50.0, 1e-4) << height;
    EXPECT_GT(filled.body.mesh.vertices.size(), 200u) << height;
    // A thin wrap is remeshed at 0.6 of the edge if coarser triangles cross: 500 / 0.6^2.
    EXPECT_LT(filled.body.mesh.vertices.size(), 1400u) << height;
  }
}

// Between cubes 5 mm apart, a wrap remeshed at 12 mm crosses itself, so the mesher wraps them again, farther
// out. The report has the lengths that it used, and a warning.
TEST(Cage, AWrapFartherOutThanOrderedIsTold) {
  for (const double gap : {0.0048, 0.1}) {
    SurfaceMesh cubes = cube_surface(0.1);
    append(cubes, cube_surface(0.1), Vector3d(0, 0.1 + gap, 0));
    scene::Scene scene = scene_of(cubes);
    scene.resolution = 0.012;
    const Filled filled = fill(scene);
    const build::CageReport& cage = filled.report.fill.cage;
    const std::size_t told = static_cast<std::size_t>(
        std::count_if(filled.report.warnings.begin(), filled.report.warnings.end(), [](const auto& warning) {
          return warning.text.find("mm outside it, and skin less than about") != std::string::npos;
        }));
    const double alpha = Vector3d(0.1, 0.2 + gap, 0.1).norm() / scene.body.cage_detail;
    const double inside = build::total_volume(filled.body.mesh);
    if (gap > 0.05) {
      EXPECT_EQ(told, 0u);
      EXPECT_NEAR(cage.alpha, alpha, 1e-9);
      EXPECT_NEAR(cage.offset, alpha / 30.0, 1e-9);
      EXPECT_NEAR(inside, 0.002, 0.05 * 0.002);
      continue;
    }
    EXPECT_EQ(told, 1u);
    EXPECT_NEAR(cage.alpha, 0.012, 1e-9);
    EXPECT_NEAR(cage.offset, 0.004, 1e-9);
    // Two cubes become one bar, 4 mm larger on all sides.
    EXPECT_EQ(parts_of(filled.body.mesh), 1u);
    EXPECT_NEAR(inside, 0.108 * 0.108 * (0.2 + gap + 0.008), 0.03 * inside);
  }
}

// The order is refused before the missing mesher is started.
TEST(Cage, AWrapThatCannotFitIsRefusedBeforeItIsTried) {
  build::WrapOrder order;
  order.alpha = 1e-5;
  build::BuildOptions options = with_mesher();
  options.mesher = "/nowhere/fascicle-mesher";
  expect_refusal([&] { build::wrap_surface(box_of({1.0, 1.0, 1.0}), order, options); }, "million vertices");
  order.alpha = 1e-3;
  expect_refusal([&] { build::wrap_surface(box_of({1.0, 1.0, 1.0}), order, options); }, "no such program");
}

// A ball with a cavity, a ball in the cavity, and a ball next to it.
SurfaceMesh hollow_balls() {
  SurfaceMesh surface = ball(0.5, 16), wall = ball(0.3, 16);
  for (auto& t : wall.triangles) std::swap(t[1], t[2]);
  append(surface, wall);
  append(surface, ball(0.1, 16));
  append(surface, ball(0.2, 16), Vector3d(1, 0, 0));
  return surface;
}

TEST(Shells, InsideOthersAreLeftOut) {
  SurfaceMesh surface = hollow_balls();
  // The control: the mesher does not support nested parts.
  expect_refusal([&] { build::tetrahedralize(surface, 0.15, {}, with_mesher()); }, "inside another part");
  build::drop_inner_shells(surface);
  SurfaceMesh outer = ball(0.5, 16);
  append(outer, ball(0.2, 16), Vector3d(1, 0, 0));
  EXPECT_EQ(surface.vertices, outer.vertices);
  EXPECT_EQ(surface.triangles, outer.triangles);
  const TetMesh filled = build::tetrahedralize(surface, 0.15, {}, with_mesher());
  EXPECT_EQ(parts_of(filled), 2u);
}

// 3,000 tetrahedra side by side, and one in a ball: what is held grows with the parts, not with their square,
// which would be 860 MB of vertices.
TEST(Shells, InManyPartsTakeLittleMemory) {
  SurfaceMesh grain;
  grain.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  grain.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  SurfaceMesh grains = grain;
  for (int k = 1; k < 3000; ++k) append(grains, grain, Vector3d(2.0 * k, 0, 0));
  append(grains, ball(0.5, 16), Vector3d(-20, 0, 0));
  const SurfaceMesh outer = grains;
  append(grains, grain, Vector3d(-20.1, -0.1, -0.1));
  for (std::size_t k = 1; k < 4; ++k) {
    Vector3d& p = grains.vertices[grains.vertices.size() - k];
    p = Vector3d(-20.1, -0.1, -0.1) + 0.1 * (p - Vector3d(-20.1, -0.1, -0.1));
  }
  const auto peak = [] {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
  };
  const long before = peak();
  build::drop_inner_shells(grains);
  EXPECT_LT(peak() - before, 100) << "MiB";
  EXPECT_EQ(grains.vertices, outer.vertices);
  EXPECT_EQ(grains.triangles, outer.triangles);
}

// A flattened ball is closed, but its tetrahedra have no height. Users who supply a surface cannot fix
// tetrahedra, so no message names tetrahedra by number.
TEST(Cage, ASheetIsToldAsAFaultOfTheSurface) {
  std::set<std::string> refusals;
  for (const double height : {1e-4, 1e-5, 3e-6, 1e-6, 1e-7, 1e-8}) {
    SurfaceMesh sheet = ball(0.3, 12);
    for (Vector3d& p : sheet.vertices) p[2] *= height;
    build::Report report;
    try {
      build::build_model(scene_of(sheet, scene::Cage::off), report);
    } catch (const scene::SceneError& error) {
      refusals.insert(error.what());
    }
  }
  EXPECT_FALSE(refusals.empty());
  for (const std::string& text : refusals) {
    EXPECT_NE(text.find("surface"), std::string::npos) << text;
    EXPECT_EQ(text.find("counted from 0"), std::string::npos) << text;
  }
}

// A ball squeezed into a point or onto a line has no area, one squeezed onto a plane no volume. The mesher
// once crashed on each of them.
TEST(Cage, ASurfaceWithoutAreaOrVolumeIsRefusedWithItsReason) {
  const SurfaceMesh whole = ball(0.3, 12);
  for (const Vector3d& kept : {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 1, 0)}) {
    SurfaceMesh squeezed = whole;
    for (Vector3d& p : squeezed.vertices) p = p.cwiseProduct(kept);
    for (const scene::Cage cage : {scene::Cage::off, scene::Cage::wrap, scene::Cage::automatic}) {
      SCOPED_TRACE(std::to_string(kept.sum()) + " dimensions, cage " +
                   std::to_string(static_cast<int>(cage)));
      scene::Scene scene = scene_of(squeezed, cage);
      scene.body.vertices = 500;
      scene.body.cage_detail = 30.0;
      try {
        const Filled filled = fill(scene);
        // A wrap around a sheet is a thin body.
        EXPECT_EQ(kept.sum(), 2.0);
        EXPECT_NE(cage, scene::Cage::off);
        for (const auto& t : filled.body.mesh.tetrahedra)
          ASSERT_GT(build::signed_volume(filled.body.mesh, t), 0.0);
      } catch (const scene::SceneError& error) {
        const std::string text = error.what();
        EXPECT_EQ(text.find("crashed"), std::string::npos) << text;
        EXPECT_NE(text.find(kept.sum() < 2.0 ? "every triangle" : "surface"), std::string::npos) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      }
    }
  }
}

TEST(Cage, TetrahedraWithoutVolumeAreFound) {
  TetMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.3, 0.3, 1e-14}, {0.3, 0.3, 1e-9}};
  mesh.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}, {0, 2, 1, 3}};
  EXPECT_EQ(build::tetrahedra_without_volume(mesh), std::vector<std::uint32_t>{1});
}

}  // namespace
}  // namespace fascicle::tests
