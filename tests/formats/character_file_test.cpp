// character.glb: the motion that a bake writes, compared with that of the source.
#include "host/formats/character_file.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/pose.h"
#include "tests/formats/baked_character.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

// The column, whose lower joint also takes these scales, in x, y and z, at 0 s, 0.5 s and 1 s.
GltfBuilder scaled_column(const std::vector<float>& scales) {
  GltfBuilder b = column();
  json& animation = b.document["animations"][0];
  const std::size_t times = b.add<float>("SCALAR", {0.0f, 0.5f, 1.0f}, {{"min", {0}}, {"max", {1}}});
  animation["samplers"].push_back({{"input", times}, {"output", b.add<float>("VEC3", scales)}});
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", 1}, {"path", "scale"}}}});
  return b;
}

// The largest difference between the joints that character.glb gives and the source's, over all frames.
double furthest_joint(const Baked& baked) {
  const gltf::Rig rig = gltf::read_rig(baked.character);
  const auto& of = std::get<rig::Character>(baked.scene.geometry);
  double furthest = 0.0;
  for (std::uint64_t frame = 0; frame <= 6; ++frame) {
    const auto shown = formats::baked_joints(rig, true, frame, baked_fps);
    const auto expected = rig::joint_transforms_at(of, &of.clips.front(), baked.time(frame));
    EXPECT_EQ(shown.size(), expected.size());
    for (std::size_t j = 0; j < shown.size(); ++j) {
      EXPECT_TRUE(shown[j].allFinite()) << frame;
      furthest = std::max(furthest, (shown[j] - expected[j]).cwiseAbs().maxCoeff());
    }
  }
  return furthest;
}

// Keys are floats near 1, below a matrix of centimetres.
constexpr double float_keys = 1e-6;

// A prop is hidden by a scale of zero; nothing can be seen of its joints then, and what comes after must be
// right.
TEST(CharacterFile, KeepsTheMotionBelowAScaleOfZero) {
  const Baked baked(scaled_column({1, 1, 1, 0, 0, 0, 1, 1, 1}), 1.0);
  EXPECT_LT(furthest_joint(baked), float_keys);
  const gltf::Rig rig = gltf::read_rig(baked.character);
  const auto& of = std::get<rig::Character>(baked.scene.geometry);
  // Frame 2 is at 0.5 s. The upper joint turns on meanwhile.
  const auto found = formats::baked_parts(rig, true, 2, baked_fps);
  const auto expected = rig::joint_parts_at(of, &of.clips.front(), 0.5);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t j = 0; j < found.size(); ++j) {
    EXPECT_LT((found[j].rotation - expected[j].rotation).norm(), float_keys) << j;
    EXPECT_LT((found[j].scale - expected[j].scale).norm(), float_keys) << j;
  }
  EXPECT_TRUE(found[0].scale.isZero(0.0) || found[1].scale.isZero(0.0)) << "one joint is hidden";
}

TEST(CharacterFile, KeepsAScaleThatTurnsNegative) {
  EXPECT_LT(furthest_joint(Baked(scaled_column({1, 1, 1, -1, 1, 1, -2, 1, 1}), 1.0)), float_keys);
  EXPECT_LT(furthest_joint(Baked(scaled_column({1, 1, 1, 1, -1, -1, 1, -1, -1}), 1.0)), float_keys);
}

}  // namespace
}  // namespace fascicle::tests
