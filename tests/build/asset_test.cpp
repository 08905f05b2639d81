// Real inputs built into models: the Stanford bunny and a walking man. Needs ../shared/assets and the mesher.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <unistd.h>

#include "host/build/measures.h"
#include "host/gltf/gltf.h"
#include "host/mesh/mesh_file.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

// The render mesh has the file's vertices and triangles in the file's order, at the file's positions.
void expect_own_surface(const Model& model, const mesh::SurfaceMesh& surface, double scale) {
  ASSERT_EQ(model.surface_count(), surface.vertices.size());
  ASSERT_EQ(model.surface_triangle.size(), 3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(model.surface_triangle[3 * t + k], surface.triangles[t][k]);
  for (std::uint32_t v = 0; v < model.surface_count(); ++v) {
    Vector3d p = Vector3d::Zero();
    for (std::size_t c = 0; c < 4; ++c)
      p += double{model.surface_weight[4 * v + c]} * metres(model, model.surface_vertex[4 * v + c]);
    // Half an ULP of a float below 1 per axis, plus the weld's 1e-9 of the diagonal (at most 4 units).
    EXPECT_LE((p - scale * surface.vertices[v]).norm(), model.unit * (0x1p-24 + 4e-9));
  }
}

double enclosed_volume(const mesh::SurfaceMesh& surface) {
  double volume = 0.0;
  for (const auto& t : surface.triangles)
    volume += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]])) / 6.0;
  return std::abs(volume);
}

TEST(Assets, TheBunnyInThreeLayers) {
  const std::filesystem::path file = asset("bunny.off");
  FASCICLE_NEEDS_ASSET(file);
  const mesh::SurfaceMesh surface = mesh::read_surface_mesh(file);
  scene::Scene scene = bar_scene();
  scene.geometry = surface;
  Vector3d low = surface.vertices[0], high = low;
  for (const Vector3d& p : surface.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3d middle = (low + high) / 2.0;
  const double size = (high - low).maxCoeff();
  scene.bones = {{"spine", middle - Vector3d(size / 5, 0, 0), middle + Vector3d(size / 5, 0, 0)}};
  scene.layers = {layer_named("bone", {scene::BoneDistance{0.0, 0.06 * size}}),
                  layer_named("muscle", {scene::BoneDistance{0.06 * size, 0.2 * size}}), layer_named("fat")};
  scene.pins = {{"base", {scene::HalfSpace{scene::Axis::y, true, true, 0.05}}}};

  build::Report report;
  const Model model = build::build_model(scene, report, with_mesher());
  ASSERT_NO_THROW(model::check_model(model));
  expect_own_surface(model, surface, 1.0);
  // Sums of thousands of rounded volumes and as many triangles; the surface is off the origin by up to its
  // own size.
  EXPECT_NEAR(report.volume, enclosed_volume(surface), 1e-9 * report.volume);
  for (const build::LayerShare& share : report.layers) EXPECT_GT(share.vertices, 0u) << share.name;
  EXPECT_GT(report.pinned_vertices, 0u);
  EXPECT_EQ(report.flipped_tetrahedra, 0u);
}

// Figure 2: three layers by distance from drawn bones. They nest, and each fills its requested share.
TEST(Assets, TheBunnysLayersNestAndFillTheirShares) {
  const std::filesystem::path file = asset("bunny.off");
  FASCICLE_NEEDS_ASSET(file);
  const mesh::SurfaceMesh surface = mesh::read_surface_mesh(file);
  scene::Scene scene = bar_scene();
  scene.geometry = surface;
  Vector3d low = surface.vertices[0], high = low;
  for (const Vector3d& p : surface.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3d size = high - low;
  const auto at = [&](double x, double y, double z) {
    return Vector3d(low + size.cwiseProduct(Vector3d(x, y, z)));
  };
  scene.bones = {{"spine", at(0.75, 0.3, 0.5), at(0.35, 0.4, 0.5)},
                 {"neck", at(0.35, 0.4, 0.5), at(0.25, 0.65, 0.6)}};
  scene.layers = {layer_named("fat"), layer_named("muscle", {scene::VolumeShare{0.0, 0.6, true}}),
                  layer_named("bone", {scene::VolumeShare{0.0, 0.1, true}})};
  scene.pins = {{"base", {scene::HalfSpace{scene::Axis::y, true, true, 0.05}}}};
  scene.resolution = 0.005;
  build::Report report;
  const Model model = build::build_model(scene, report, with_mesher());
  const std::vector<double> asked{0.4, 0.5, 0.1};
  for (std::size_t l = 0; l < 3; ++l)
    EXPECT_NEAR(report.layers[l].volume / report.volume, asked[l], 0.02) << report.layers[l].name;
  std::vector<double> nearest(3, 1e9), farthest(3, 0.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    double distance = 1e9;
    for (const scene::BoneSegment& bone : scene.bones)
      distance = std::min(distance, build::segment_distance(metres(model, i), bone.from, bone.to));
    nearest[model.layer_of(i)] = std::min(nearest[model.layer_of(i)], distance);
    farthest[model.layer_of(i)] = std::max(farthest[model.layer_of(i)], distance);
  }
  // Positions are floats; the body is 0.15 m long.
  EXPECT_LE(farthest[2], nearest[1] + 1e-7);
  EXPECT_LE(farthest[1], nearest[0] + 1e-7);
}

TEST(Assets, RefusesAnOpenSurfaceByItsName) {
  const std::filesystem::path file = asset("bunny.off");
  FASCICLE_NEEDS_ASSET(file);
  mesh::SurfaceMesh surface = mesh::read_surface_mesh(file);
  surface.triangles.pop_back();
  scene::Scene scene = bar_scene();
  scene.geometry = surface;
  scene.body.cage = scene::Cage::off;
  build::Report report;
  expect_refusal([&] { build::build_model(scene, report, with_mesher()); }, "test: mesh: ");
}

scene::Scene man_scene(const rig::Character& man) {
  scene::Scene scene = bar_scene();
  scene.geometry = man;
  scene.body.cage = scene::Cage::off;
  scene.pins.clear();
  scene.layers = {layer_named("fat"), layer_named("muscle", {scene::BoneDistance{0.0, 0.07}}),
                  layer_named("bone", {scene::BoneDistance{0.0, 0.03}})};
  scene.layers[0].alpha = 0.3;
  scene.layers[2].kinematic = true;
  return scene;
}

TEST(Assets, TheWalkingMan) {
  const std::filesystem::path file = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(file);
  const rig::Character man = gltf::read_gltf(file);
  build::Report report;
  const Model model = build::build_model(man_scene(man), report, with_mesher());
  ASSERT_NO_THROW(model::check_model(model));
  expect_own_surface(model, man.surface, 1.0);
  EXPECT_EQ(model.joint_count, man.skeleton.size());
  EXPECT_NEAR(report.volume, enclosed_volume(man.surface), 1e-9 * report.volume);
  for (const build::LayerShare& share : report.layers) EXPECT_GT(share.vertices, 0u) << share.name;

  // A render vertex that is not duplicated by a seam keeps its own weights.
  std::vector<std::uint32_t> doubles(model.vertex_count, 0);
  for (std::uint32_t v = 0; v < model.surface_count(); ++v) ++doubles[model.surface_vertex[4 * v]];
  std::size_t single = 0;
  for (std::uint32_t v = 0; v < model.surface_count(); ++v) {
    const std::uint32_t i = model.surface_vertex[4 * v];
    if (doubles[i] != 1) continue;
    ++single;
    for (std::uint32_t k = model.skin_offset[i]; k < model.skin_offset[i + 1]; ++k) {
      double given = 0.0;
      for (std::size_t c = 0; c < 8; ++c)
        if (man.joints[v][c] == model.skin_joint[k]) given += man.weights[v][c];
      // Shares below 1e-4 are dropped, at most seven per vertex.
      EXPECT_NEAR(double{model.skin_weight[k]}, given, 7e-4);
    }
  }
  EXPECT_GT(single, 1000u);
}

// docs/examples/walking-man.toml shows the options of layers.
TEST(Assets, TheExampleOfACharacterBuilds) {
  const std::filesystem::path file = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(file);
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("fascicle-example-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::filesystem::path example = std::filesystem::path(FASCICLE_SOURCE_DIR) / "docs" / "examples";
  std::filesystem::copy(example / "walking-man.toml", folder);
  std::filesystem::copy(file, folder);
  const scene::Scene scene = scene::load_scene((folder / "walking-man.toml").string());
  std::filesystem::remove_all(folder);
  build::Report report;
  const Model model = build::build_model(scene, report, with_mesher());
  ASSERT_NO_THROW(model::check_model(model));
  EXPECT_EQ(report.bone_islands, 1u);
  EXPECT_GT(report.fibres.constraints, 0u);
  EXPECT_EQ(report.fibres.without, 0u);
  // Edges along which lines turn by more than 60 degrees: measured 1.8 %.
  EXPECT_LT(report.fibres.bent_edges, report.fibres.edges / 25);
  for (const build::LayerShare& layer : report.layers)
    EXPECT_GT(layer.volume / report.volume, 0.05) << layer.name;
}

TEST(Assets, TheWalkingManIsTheSameEveryTime) {
  const std::filesystem::path file = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(file);
  const scene::Scene scene = man_scene(gltf::read_gltf(file));
  build::Report report;
  const Model a = build::build_model(scene, report, with_mesher());
  const Model b = build::build_model(scene, report, with_mesher());
  EXPECT_EQ(a.rest, b.rest);
  EXPECT_EQ(a.tetrahedron, b.tetrahedron);
  EXPECT_EQ(a.skin_weight, b.skin_weight);
  EXPECT_EQ(a.share_taken, b.share_taken);
  EXPECT_EQ(a.tag, b.tag);
}

// The bone layer is connected. Without extra points along the bones it would fall apart into islands.
TEST(Assets, TheWalkingMansBoneLayerHoldsTogether) {
  const std::filesystem::path file = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(file);
  const Model m = build_with(man_scene(gltf::read_gltf(file)), with_mesher());
  std::vector<char> seen(m.vertex_count, 0);
  std::size_t bone_vertices = 0, largest = 0;
  for (std::uint32_t start = 0; start < m.vertex_count; ++start) {
    if (!m.is_kinematic(start)) continue;
    ++bone_vertices;
    if (seen[start]) continue;
    std::vector<std::uint32_t> open{start};
    seen[start] = 1;
    std::size_t size = 0;
    while (!open.empty()) {
      const std::uint32_t i = open.back();
      open.pop_back();
      ++size;
      for (std::uint32_t k = m.ring_offset[i]; k < m.ring_offset[i + 1]; ++k)
        if (m.is_kinematic(m.ring[k]) && !seen[m.ring[k]]) {
          seen[m.ring[k]] = 1;
          open.push_back(m.ring[k]);
        }
    }
    largest = std::max(largest, size);
  }
  // Most of the layer is one piece. Feet and hands may be separate where the skin is closer than the spacing.
  EXPECT_GT(2 * largest, bone_vertices);
}

// A robot of rigid parts: the only warning is about the file itself.
TEST(Assets, ARobotIsNotBotheredWithFlesh) {
  const std::filesystem::path file = asset("RobotExpressive.glb");
  FASCICLE_NEEDS_ASSET(file);
  build::Report report;
  build::build_model(scene::load_scene(file.string()), report, with_mesher());
  ASSERT_EQ(report.warnings.size(), 1u) << report.warnings.back().text;
  EXPECT_EQ(report.warnings[0].text.find("skin weights: 752 of 7214 vertices"), 0u)
      << report.warnings[0].text;
}

}  // namespace
}  // namespace fascicle::tests
