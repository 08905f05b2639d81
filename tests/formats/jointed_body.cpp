#include "tests/formats/jointed_body.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/surface.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/sink_frames.h"

namespace fascicle::tests {

using nlohmann::json;
using scene::Vector3d;

namespace {

rig::Character jointed_character(const model::Model& model) {
  rig::Character character;
  const std::vector<float> rest =
      formats::world_positions(formats::embed(model, model.rest), model.unit, model.rest_origin);
  for (std::size_t i = 0; i < rest.size(); i += 3)
    character.surface.vertices.emplace_back(rest[i], rest[i + 1], rest[i + 2]);
  character.surface.triangles = {{0, 1, 2}};
  character.joints = {{0}, {0, 1}, {1}};
  character.weights = {{1.0}, {0.625, 0.375}, {1.0}};
  for (const int parent : {-1, 0}) {
    rig::Joint joint;
    joint.name = parent < 0 ? "root" : "tip";
    joint.parent = parent;
    joint.rest_translation = parent < 0 ? Vector3d(10, 0, -3) : Vector3d(0, 0.25, 0);
    joint.rest_local.topRightCorner<3, 1>() = joint.rest_translation;
    joint.inverse_bind.topRightCorner<3, 1>() = parent < 0 ? Vector3d(-10, 0, 3) : Vector3d(-10, -0.25, 3);
    joint.skins = true;
    character.skeleton.push_back(joint);
  }
  const double half = std::sqrt(0.5);
  character.clips = {{.name = "wave",
                      .duration = 1.0,
                      .channels = {{.joint = 0, .times = {0, 1}, .values = {10, 0, -3, 11, 0, -3}},
                                   {.joint = 1,
                                    .path = rig::ChannelPath::rotation,
                                    .times = {0, 1},
                                    .values = {0, 0, 0, 1, 0, 0, half, half}}}}};
  return character;
}

}  // namespace

model::Model jointed_model() {
  model::Model model = two_tetrahedra();
  model.joint_count = 2;
  model.skin_offset = {0, 1, 2, 3, 4, 5};
  model.skin_joint = {0, 0, 1, 1, 1};
  model.skin_weight.assign(5, 1.0f);
  return model;
}

scene::Scene jointed_scene(std::uint64_t frames) {
  scene::Scene scene = short_scene(frames);
  scene.geometry = jointed_character(jointed_model());
  return scene;
}

bake::BakeResult bake_jointed(const bake::BakeOptions& options, std::uint64_t frames) {
  const model::Model model = jointed_model();
  FakeSolver solver(model);
  return bake::bake(jointed_scene(frames), model, solver, options);
}

GlbChunks read_glb(const std::filesystem::path& path) {
  const std::string bytes = read_text(path);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 4), 2u);
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 8), bytes.size());
  const auto length = read_value<std::uint32_t>(bytes, 12);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  GlbChunks glb{.document = json::parse(bytes.substr(20, length)), .binary = bytes.substr(28 + length)};
  EXPECT_EQ(read_value<std::uint32_t>(bytes, 20 + length), glb.binary.size());
  return glb;
}

}  // namespace fascicle::tests
