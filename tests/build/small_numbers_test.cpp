// Numbers too small to use: an alpha below 2^-40 becomes zero, and regions with almost no moment are
// reported.
#include <array>
#include <variant>

#include <gtest/gtest.h>

#include "tests/build/scenes.h"

namespace fascicle::tests {

namespace {

// Two separate tetrahedra; the second is `ratio` times the size of the first.
scene::Scene two_tetrahedra(double ratio) {
  mesh::TetMesh mesh;
  for (const double size : {1.0, ratio}) {
    const scene::Vector3d corner(size == 1.0 ? 0.0 : 2.0, 0.0, 0.0);
    mesh.vertices.push_back(corner);
    for (int a = 0; a < 3; ++a) mesh.vertices.push_back(corner + size * scene::Vector3d::Unit(a));
  }
  mesh.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  scene::Scene scene = bar_scene();
  scene.geometry = mesh;
  scene.pins.clear();
  return scene;
}

std::vector<build::Warning> stillness_warnings(const scene::Scene& scene) {
  build::Report report;
  model::check_model(build::build_model(scene, report));
  std::vector<build::Warning> found;
  for (const build::Warning& warning : report.warnings)
    if (warning.text.find("never rotates") != std::string::npos) found.push_back(warning);
  return found;
}

// Masses scale with the cube of the size and moments with its fifth power: 2^-9 gives 2^-45 of the larger
// moment, 2^-7 gives 2^-35. The mean moment is half of the larger one.
TEST(SmallNumbers, RegionsThatNeverTurnAreNamed) {
  const auto warnings = stillness_warnings(two_tetrahedra(0x1p-9));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].vertices, (std::vector<std::uint32_t>{4, 5, 6, 7}));
  EXPECT_EQ(warnings[0].text.find("4 vertices lie"), 0u) << warnings[0].text;
}

// The build numbers vertices by place, and the file as it likes; the list is in the file's order.
TEST(SmallNumbers, RegionsThatNeverTurnAreNamedInTheFilesOrder) {
  scene::Scene scene = two_tetrahedra(0x1p-9);
  auto& mesh = std::get<mesh::TetMesh>(scene.geometry);
  for (std::array<std::uint32_t, 4> order :
       {std::array{7u, 4u, 6u, 5u}, {5u, 7u, 4u, 6u}, {6u, 5u, 7u, 4u}}) {
    const std::vector<scene::Vector3d> before = mesh.vertices;
    for (std::size_t k = 0; k < 4; ++k) mesh.vertices[order[k]] = before[4 + k];
    mesh.tetrahedra[1] = order;
    const auto warnings = stillness_warnings(scene);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].vertices, (std::vector<std::uint32_t>{4, 5, 6, 7}));
    EXPECT_NE(warnings[0].text.find("(vertex 4, 5, 6, 7)"), std::string::npos) << warnings[0].text;
    mesh.vertices = before;
  }
}

TEST(SmallNumbers, RegionsThatTurnAreNot) {
  EXPECT_TRUE(stillness_warnings(two_tetrahedra(0x1p-7)).empty());
  EXPECT_TRUE(stillness_warnings(bar_scene()).empty());
}

// A push is distributed by mass, which is impossible between flesh and an almost massless gas. On its own,
// either may be that light.
TEST(SmallNumbers, LayersThatShareAPushAreOfMassesThatCompare) {
  scene::Scene scene = bar_scene();
  scene.contact.self = true;
  scene.layers.push_back(scene.layers[0]);
  scene.layers[1].name = "gas";
  scene.layers[1].where = {scene::HalfSpace{scene::Axis::x, false, true, 0.5}};
  EXPECT_NO_THROW(build_quietly(scene));
  scene.layers[1].density = 1e-30;
  expect_refusal([&] { build_quietly(scene); }, "layers.gas.density of 1e-30: ");
  scene.contact.self = false;
  EXPECT_NO_THROW(build_quietly(scene));
  for (scene::Layer& layer : scene.layers) layer.density = 1e-30;
  scene.contact.self = true;
  EXPECT_NO_THROW(model::check_model(build_quietly(scene)));
}

// Such a small alpha means no stiffness: the vertex is free and its pull is zero.
TEST(SmallNumbers, AnAlphaBelowTheLeastBuildsAFreeBody) {
  scene::Scene scene = bar_scene();
  scene.layers[0].alpha = 1e-40;
  const model::Model model = build_quietly(scene);
  EXPECT_NO_THROW(model::check_model(model));
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    EXPECT_EQ(model.alpha[i], 0.0f) << i;
    EXPECT_EQ(model.pull[i] > 0.0f, model.is_kinematic(i)) << i;
  }
}

}  // namespace

}  // namespace fascicle::tests
