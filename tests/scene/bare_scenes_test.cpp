// Scenes of meshes and characters that are given without one.
#include "host/scene/bare_scenes.h"

#include <locale>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/scene_file.h"

namespace fascicle::tests {
namespace {

mesh::SurfaceMesh tetrahedron_of(double size) {
  mesh::SurfaceMesh mesh;
  mesh.vertices = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// Decimal comma and grouped digits, as in a German locale.
struct GermanNumbers final : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

std::vector<std::string> scenes_of_many_sizes() {
  std::vector<std::string> scenes;
  for (double size = 1e-5; size < 1e5; size *= 3.7)
    scenes.push_back(scene::scene_for_mesh("a.obj", tetrahedron_of(size), 1.0));
  return scenes;
}

TEST(BareScenes, AreTheSameInEveryLocale) {
  const std::vector<std::string> plain = scenes_of_many_sizes();
  const std::locale old = std::locale::global(std::locale(std::locale::classic(), new GermanNumbers));
  std::ostringstream control;
  control << 1234.5;
  const std::vector<std::string> german = scenes_of_many_sizes();
  std::locale::global(old);
  EXPECT_EQ(control.str(), "1.234,5");
  EXPECT_EQ(german, plain);
}

// Three digits, of which none is lost with the point or the exponent.
TEST(BareScenes, RoundStiffness) {
  // 60 x 1000 kg/m^3 x 9.81 m/s^2 = 588,600 Pa per metre, and 1.6 / s x sqrt(9.81 m/s^2 / size).
  const std::string one = scene::scene_for_mesh("a.obj", tetrahedron_of(1.0), 1.0);
  EXPECT_NE(one.find("youngs_modulus = 589000.0\n"), std::string::npos) << one;
  EXPECT_NE(one.find("damping = 5.01\n"), std::string::npos) << one;
  const std::string small = scene::scene_for_mesh("a.obj", tetrahedron_of(1.0), 0.001);
  EXPECT_NE(small.find("youngs_modulus = 589.0\n"), std::string::npos) << small;
  EXPECT_NE(small.find("damping = 158.0\n"), std::string::npos) << small;
}

// Exporters leave vertices behind that no triangle uses, wherever they were.
TEST(BareScenes, DoNotMeasureLooseVertices) {
  rig::Character character;
  character.surface = tetrahedron_of(1.0);
  rig::Character loose = character;
  loose.surface.vertices.emplace_back(30.0, 0.0, 0.0);
  EXPECT_EQ(scene::scene_for_mesh("a.obj", loose.surface, 1.0),
            scene::scene_for_mesh("a.obj", character.surface, 1.0));
  const auto layers = [](const rig::Character& of) {
    return scene::layers_for_character(of, scene::Stiffness::modulus, "a.glb");
  };
  EXPECT_EQ(layers(loose), layers(character));
  EXPECT_EQ(layers(scene::what_layers_go_by({loose})), layers(character));
  // The control: a larger body is stiffer.
  loose.surface.triangles.push_back({0, 1, 4});
  EXPECT_NE(layers(loose), layers(character));
}

// A floor of 20 m below a body of 1 m, in the same file.
TEST(BareScenes, DoNotMeasureFloors) {
  const auto layers = [](const rig::Character& of) {
    return scene::layers_for_character(of, scene::Stiffness::modulus, "a.glb");
  };
  rig::Character character;
  character.surface = tetrahedron_of(1.0);
  character.joints.assign(4, {0});
  character.weights.assign(4, {1.0});
  rig::Character on_floor = character;
  for (const auto& [x, z] : {std::pair{-10.0, -10.0}, {-10.0, 10.0}, {10.0, 10.0}, {10.0, -10.0}})
    on_floor.surface.vertices.emplace_back(x, -0.1, z);
  on_floor.surface.triangles.push_back({4, 5, 6});
  on_floor.surface.triangles.push_back({4, 6, 7});
  on_floor.joints.resize(8, {1});
  on_floor.weights.resize(8, {1.0});
  EXPECT_EQ(layers(on_floor), layers(character));
  EXPECT_EQ(layers(scene::what_layers_go_by({on_floor})), layers(character));
  // Before its parts are checked, a character may lack joints or name vertices that it does not have.
  rig::Character incomplete = on_floor;
  incomplete.joints.clear();
  EXPECT_NE(layers(incomplete), layers(character));
  rig::Character broken = on_floor;
  broken.surface.triangles.push_back({0, 1, 4000000000U});
  EXPECT_EQ(layers(broken), layers(character));
  // A wing that is three times as long as the body is part of it.
  rig::Character winged = character;
  for (const double x : {1.2, 4.2})
    for (const double z : {-0.5, 1.5}) winged.surface.vertices.emplace_back(x, 0.9, z);
  winged.surface.triangles.push_back({4, 5, 6});
  winged.surface.triangles.push_back({6, 5, 7});
  winged.joints.resize(8, {1});
  winged.weights.resize(8, {1.0});
  EXPECT_NE(layers(winged), layers(character));
  // The controls: a sheet that two joints move is cloth, and a sheet alone is the body.
  rig::Character on_cloth = on_floor;
  on_cloth.joints.back() = {0};
  EXPECT_NE(layers(on_cloth), layers(character));
  rig::Character sheet = on_floor;
  sheet.surface.triangles.erase(sheet.surface.triangles.begin(), sheet.surface.triangles.end() - 2);
  EXPECT_EQ(layers(sheet), layers(on_cloth));
}

}  // namespace
}  // namespace fascicle::tests
