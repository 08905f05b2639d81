// Tetrahedral meshes as input: what is repaired, what is refused with which message, and which changes have
// no effect.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/check_mesh.h"
#include "host/build/mass.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using mesh::TetMesh;
using scene::Vector3d;

// A bar as a mesh, jittered so that no two vertices tie in the numbering.
scene::Scene mesh_scene() {
  scene::Scene scene = bar_scene();
  scene.geometry = build::make_bar({.vertices = {8, 5, 4}, .jitter = 0.25}, "test");
  return scene;
}
TetMesh& mesh_of(scene::Scene& scene) {
  return std::get<TetMesh>(scene.geometry);
}

TEST(MeshInput, TurnsRoundNegativeTetrahedra) {
  scene::Scene scene = mesh_scene();
  const model::Model plain = build_quietly(scene);
  for (const std::size_t k : {3u, 17u, 40u})
    std::swap(mesh_of(scene).tetrahedra[k][0], mesh_of(scene).tetrahedra[k][1]);
  build::Report report;
  const model::Model repaired = build::build_model(scene, report);
  EXPECT_EQ(report.flipped_tetrahedra, 3u);
  EXPECT_EQ(repaired.share_taken, plain.share_taken);
  EXPECT_NO_THROW(model::check_model(repaired));
}

TEST(MeshInput, AMirroredMeshHasTheSameVolumeAndNoNegativeTetrahedron) {
  scene::Scene scene = mesh_scene();
  build::Report plain, mirrored;
  build::build_model(scene, plain);
  for (Vector3d& p : mesh_of(scene).vertices) p[1] = -p[1];
  const model::Model model = build::build_model(scene, mirrored);
  EXPECT_EQ(mirrored.flipped_tetrahedra, mirrored.tetrahedra);
  // The same numbers summed in another order: 500 roundings of 2^-53.
  EXPECT_NEAR(mirrored.volume, plain.volume, plain.volume * 1e-13);
  const auto at = [&](std::uint32_t i) {
    return Vector3d(double{model.rest[3 * i]}, double{model.rest[3 * i + 1]}, double{model.rest[3 * i + 2]});
  };
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    const std::uint32_t* c = &model.tetrahedron[t];
    EXPECT_GT(build::signed_volume(at(c[0]), at(c[1]), at(c[2]), at(c[3])), 0.0);
  }
}

TEST(MeshInput, RefusesMalformedMeshesWithIds) {
  const auto refusal = [](const std::function<void(TetMesh&)>& spoil, const std::string& part) {
    scene::Scene scene = mesh_scene();
    spoil(mesh_of(scene));
    expect_refusal([&] { build_quietly(scene); }, part);
  };
  refusal([](TetMesh& m) { m.tetrahedra.clear(); }, "no tetrahedra");
  refusal([](TetMesh& m) { m.tetrahedra[7][2] = 160; }, "tetrahedron 7 ");
  refusal([](TetMesh& m) { m.tetrahedra[9][2] = m.tetrahedra[9][0]; }, "named twice in tetrahedron 9 ");
  refusal([](TetMesh& m) { m.vertices.emplace_back(0, 0, 0); }, "uses vertex 160 ");
  refusal([](TetMesh& m) { m.vertices[12][1] = std::numeric_limits<double>::quiet_NaN(); }, "vertex 12 ");
  refusal([](TetMesh& m) { m.vertices[12][1] = std::numeric_limits<double>::infinity(); }, "vertex 12 ");
  // All four corners of tetrahedron 0 are in one plane.
  refusal(
      [](TetMesh& m) {
        for (const auto c : m.tetrahedra[0]) m.vertices[c][2] = 0.01;
      },
      "no volume in tetrahedron 0");
  // The same tetrahedron twice, so each of its triangles has two tetrahedra on one side.
  refusal([](TetMesh& m) { m.tetrahedra.push_back(m.tetrahedra[0]); }, "overlap");
}

TEST(MeshInput, RefusesTetrahedraThatSinglePrecisionFlattens) {
  scene::Scene scene = bar_scene();
  // Height 1e-9 over a base of 1: it has volume in double but not in float.
  TetMesh mesh{{{0, 0, 0.3}, {1, 0, 0.3}, {0, 1, 0.3}, {0.3, 0.3, 0.3 + 1e-9}, {0.3, 0.3, -0.7}},
               {{0, 1, 2, 3}, {0, 2, 1, 4}}};
  scene.geometry = mesh;
  expect_refusal([&] { build_quietly(scene); }, "too flat");
}

TEST(MeshInput, ThePermutationOfTheInputDoesNotMatter) {
  scene::Scene scene = mesh_scene();
  const model::Model plain = build_quietly(scene);

  const TetMesh given = mesh_of(scene);
  std::vector<std::uint32_t> order(given.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937 random(5);
  std::shuffle(order.begin(), order.end(), random);
  TetMesh& shuffled = mesh_of(scene);
  std::vector<std::uint32_t> number(order.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    shuffled.vertices[k] = given.vertices[order[k]];
    number[order[k]] = k;
  }
  std::shuffle(shuffled.tetrahedra.begin(), shuffled.tetrahedra.end(), random);
  for (auto& t : shuffled.tetrahedra) {
    for (std::uint32_t& corner : t) corner = number[corner];
    // An even permutation of the corners.
    t = {t[1], t[0], t[3], t[2]};
  }
  const model::Model other = build_quietly(scene);

  std::vector<std::uint32_t> source(plain.vertex_count);
  for (std::uint32_t i = 0; i < plain.vertex_count; ++i) source[i] = order[other.source_vertex[i]];
  EXPECT_EQ(source, plain.source_vertex);
  // The numbering depends only on positions, so all arrays are bit-identical.
  EXPECT_EQ(other.rest, plain.rest);
  EXPECT_EQ(other.ring, plain.ring);
  EXPECT_EQ(other.share_taken, plain.share_taken);
  EXPECT_EQ(other.pull, plain.pull);
  EXPECT_EQ(other.region_rest, plain.region_rest);
  EXPECT_EQ(other.tetrahedron, plain.tetrahedron);
  // The order of summation for masses is canonical too.
  EXPECT_EQ(other.mass, plain.mass);
}

TEST(MeshInput, TheBoundaryIsClosedAndFacesOutward) {
  const scene::Bar bar{.size = {0.4, 0.1, 0.2}, .vertices = {6, 4, 5}, .jitter = 0.2};
  const TetMesh mesh = build::make_bar(bar, "test");
  const auto triangles = build::boundary_triangles(mesh, "test");
  EXPECT_EQ(triangles.size(), 4u * (5 * 3 + 5 * 4 + 3 * 4));
  // Gauss: the flux of x/3 through a closed, outward-facing surface is its volume.
  double flux = 0.0;
  Vector3d area = Vector3d::Zero();
  for (const auto& t : triangles) {
    const Vector3d& a = mesh.vertices[t[0]];
    const Vector3d cross = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    flux += a.dot(cross) / 6.0;
    area += cross;
  }
  // 200 rounded terms, none larger than the volume.
  EXPECT_NEAR(flux, bar.size.prod(), 1e-14);
  EXPECT_LT(area.norm(), 1e-14);
}

TEST(MeshInput, RenderVerticesAreTheBoundarysByAscendingSource) {
  scene::Scene scene = mesh_scene();
  const model::Model model = build_quietly(scene);
  ASSERT_GT(model.surface_count(), 0u);
  for (std::uint32_t k = 0; k < model.surface_count(); ++k) {
    EXPECT_EQ(model.surface_weight[4 * k], 1.0f);
    if (k > 0) {
      EXPECT_LT(model.source_vertex[model.surface_vertex[4 * k - 4]],
                model.source_vertex[model.surface_vertex[4 * k]]);
    }
  }
}

TEST(MeshInput, WarnsOfPartsAndOfWhatFalls) {
  scene::Scene scene = bar_scene();
  scene.geometry =
      TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {3, 0, 0}, {4, 0, 0}, {3, 1, 0}, {3, 0, 1}},
              {{0, 1, 2, 3}, {4, 5, 6, 7}}};
  build::Report report;
  build::build_model(scene, report);
  ASSERT_EQ(report.warnings.size(), 2u);
  EXPECT_NE(report.warnings[0].text.find("2 parts"), std::string::npos);
  EXPECT_EQ(report.warnings[0].vertices, (std::vector<std::uint32_t>{0, 4}));
  EXPECT_NE(report.warnings[1].text.find("fall"), std::string::npos);
  EXPECT_EQ(report.warnings[1].vertices, (std::vector<std::uint32_t>{4}));
}

std::string warning_of_flat_cells(const TetMesh& mesh) {
  scene::Scene scene = bar_scene();
  scene.geometry = mesh;
  build::Report report;
  build::build_model(scene, report);
  for (const build::Warning& warning : report.warnings)
    if (warning.text.find("flatter than") != std::string::npos) return warning.text;
  return "";
}

// Cells get thinner towards the free end, along x only.
TetMesh graded_bar(double ratio) {
  TetMesh mesh = build::make_bar({.size = {2.0, 0.4, 0.4}, .vertices = {21, 5, 5}}, "test");
  std::vector<double> places{0.0};
  for (int k = 0; k < 20; ++k) places.push_back(places.back() + 0.1 * std::pow(ratio, -k / 19.0));
  for (Vector3d& p : mesh.vertices)
    p[0] = places[static_cast<std::size_t>(std::lround((p[0] - mesh.vertices[0][0]) / 0.1))];
  return mesh;
}

TEST(MeshInput, WarnsOfFlatTetrahedra) {
  EXPECT_EQ(warning_of_flat_cells(graded_bar(1.0)), "");
  EXPECT_EQ(warning_of_flat_cells(graded_bar(15.0)), "");
  for (const double ratio : {30.0, 100.0, 250.0}) {
    const std::string text = warning_of_flat_cells(graded_bar(ratio));
    ASSERT_NE(text, "") << ratio;
    // Vertices of the last slice, at the free end, have only such flat cells: boxes of 1:ratio.
    const std::size_t number = text.find("down to 1:");
    ASSERT_NE(number, std::string::npos) << text;
    EXPECT_NEAR(std::stod(text.substr(number + 10)), ratio, 0.01 * ratio + 0.5) << text;
  }
  // A sliver among good cells: one vertex is pushed almost onto the opposite face of one of its tetrahedra.
  TetMesh sliver = graded_bar(1.0);
  const auto t = sliver.tetrahedra[700];
  const Vector3d middle = (sliver.vertices[t[1]] + sliver.vertices[t[2]] + sliver.vertices[t[3]]) / 3.0;
  sliver.vertices[t[0]] += 0.97 * (middle - sliver.vertices[t[0]]);
  EXPECT_LT(build::flatness(sliver, t), 1.0 / 20.0);
  EXPECT_EQ(warning_of_flat_cells(sliver), "");
}

// Adds a tetrahedron of 1:ratio on a triangle at the free end, so that its tip has no other.
TetMesh bar_with_a_flat_tip(double ratio) {
  TetMesh mesh = build::make_bar({.size = {2.0, 0.4, 0.4}, .vertices = {41, 7, 7}}, "test");
  double end = mesh.vertices[0][0];
  for (const Vector3d& p : mesh.vertices) end = std::max(end, p[0]);
  for (const auto& t : build::boundary_triangles(mesh, "test")) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    if (std::min({a[0], b[0], c[0]}) < end - 1e-6) continue;
    const double area = (b - a).cross(c - a).norm() / 2.0;
    mesh.tetrahedra.push_back({t[0], t[1], t[2], static_cast<std::uint32_t>(mesh.vertices.size())});
    mesh.vertices.push_back((a + b + c) / 3.0 + Vector3d(std::sqrt(2.0 * area) / ratio, 0.0, 0.0));
    break;
  }
  return mesh;
}

// Cages of thousands of vertices have a flat place or two by chance.
TEST(MeshInput, AFlatPlaceByChanceIsNotWorthAWarning) {
  const TetMesh chance = bar_with_a_flat_tip(23.0);
  EXPECT_NEAR(build::flatness(chance, chance.tetrahedra.back()), 1.0 / 23.0, 1e-6);
  EXPECT_EQ(warning_of_flat_cells(chance), "");
  // The control: from 1:30 on it can be seen.
  EXPECT_TRUE(warning_of_flat_cells(bar_with_a_flat_tip(40.0)).starts_with("1 vertex lies"));
}

TEST(MeshInput, ScaleMultipliesMeshesButNotBars) {
  scene::Scene scene = mesh_scene();
  build::Report plain, scaled, bar;
  build::build_model(scene, plain);
  scene.scale = 0.01;
  build::build_model(scene, scaled);
  // The factor is rounded once and cubed; volumes are sums of 500 terms.
  EXPECT_NEAR(scaled.volume, plain.volume * 1e-6, plain.volume * 1e-18);
  scene.geometry = scene::Bar{};
  build::build_model(scene, bar);
  EXPECT_NEAR(bar.volume, 0.4 * 0.08 * 0.08, 1e-15);
}

// A file in millimetres, say.
TEST(MeshInput, WarnsOfASizeThatIsProbablyNotInMetres) {
  for (const double scale : {0.1, 1.0, 40.0, 400.0}) {
    scene::Scene meshes = mesh_scene(), bar = bar_scene();
    meshes.scale = scale;
    std::get<scene::Bar>(bar.geometry).size *= scale;
    build::Report report, of_bar;
    build::build_model(meshes, report);
    build::build_model(bar, of_bar);
    const auto told = [](const build::Report& r) {
      return std::count_if(r.warnings.begin(), r.warnings.end(), [](const build::Warning& warning) {
        return warning.text.find("set mesh.scale, or gravity") != std::string::npos;
      });
    };
    // The bar is 0.4 m long. One whose size the scene gives is as large as it should be.
    EXPECT_EQ(told(report), scale == 1.0 || scale == 40.0 ? 0 : 1) << scale;
    EXPECT_EQ(told(of_bar), 0) << scale;
  }
}

TEST(MeshInput, RestPositionsReturnToMetresWithinHalfAnUlp) {
  scene::Scene scene = mesh_scene();
  for (Vector3d& p : mesh_of(scene).vertices) p += Vector3d(100.3, -7.7, 3.1);
  const model::Model model = build_quietly(scene);
  EXPECT_EQ(model.unit, 0.25);  // the bar is 0.4 m long
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      const double x = double{model.rest[3 * i + a]};
      EXPECT_LE(std::abs(x), 1.0);
      const double metres = model.rest_origin[a] + model.unit * x;
      // Half an ULP of a float below 1, plus the rounding of a double 100 m from the origin.
      EXPECT_NEAR(metres, mesh_of(scene).vertices[model.source_vertex[i]][static_cast<Eigen::Index>(a)],
                  0.25 * 0x1p-25 + 1e-13);
    }
}

}  // namespace
}  // namespace fascicle::tests
