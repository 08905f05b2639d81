// Blend shapes: the effect of the file's weights on the bind pose, and of its clips over time.
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/blend_shapes.h"
#include "host/rig/pose.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_viewer.h"

namespace fascicle::tests::gltf_shapes_test {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

// Matrices and coordinates of the generated files are floats near 1.
constexpr double float_rounding = 1e-6;

double distance(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  EXPECT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

std::vector<Vector3d> rigged(const gltf::Rig& rig, int clip, double time) {
  const rig::Clip* played = clip < 0 ? nullptr : &rig.character.clips.at(static_cast<std::size_t>(clip));
  const auto joints = rig::joint_transforms_at(rig.character, played, time);
  std::vector<Vector3d> result;
  for (const gltf::RigPart& part : rig.parts) {
    const std::vector<Vector3d> shaped = gltf::shaped_positions(part, played, time);
    for (std::size_t i = 0; i < shaped.size(); ++i) {
      Eigen::Vector4d p = Eigen::Vector4d::Zero();
      for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
        p += part.weight[k] * (joints[part.skin_joint[part.slot[k]]] * part.inverse_bind[part.slot[k]] *
                               shaped[i].homogeneous());
      result.push_back(p.head<3>());
    }
  }
  return result;
}

void expect_shown(const GltfBuilder& b, int clip) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("face.glb", b.glb());
  const GltfViewer viewer(b);
  EXPECT_LT(distance(gltf::read_gltf(path).surface.vertices, viewer.shown(-1, 0.0)), float_rounding);
  const gltf::Rig rig = gltf::read_rig(path);
  for (const double time : {-1.0, 0.0, 0.3, 0.5, 0.9, 1.0, 7.0})
    EXPECT_LT(distance(rigged(rig, clip, time), viewer.shown(clip, time)), float_rounding) << time;
}

TEST(GltfShapes, rest_weights_stand_in_the_bind_pose) {
  GltfBuilder b = column_with_shapes();
  const std::vector<Vector3d> without = GltfViewer(column()).shown(-1, 0.0);
  EXPECT_GT(distance(GltfViewer(b).shown(-1, 0.0), without), 0.1);  // the mesh's weights
  expect_shown(b, 0);
  b.document["nodes"][3]["weights"] = {0.0, 0.0};  // the node's weights override the mesh's
  EXPECT_EQ(distance(GltfViewer(b).shown(-1, 0.0), without), 0.0);
  expect_shown(b, 0);
  b.document["nodes"][3]["weights"] = {-0.5, 1.5};
  expect_shown(b, 0);
}

TEST(GltfShapes, clips_move_them_by_steps_and_straight) {
  GltfBuilder b = column_with_shapes();
  const gltf::Rig rig = gltf::read_rig(TemporaryFolder().write("face.glb", b.glb()));
  ASSERT_EQ(rig.parts.size(), 1u);
  ASSERT_EQ(rig.parts[0].shapes.size(), 2u);
  EXPECT_EQ(rig.parts[0].shapes[1].vertex, (std::vector<std::uint32_t>{2, 9}));  // sparse in the file
  ASSERT_EQ(rig.character.clips[0].weights.size(), 1u);
  EXPECT_EQ(rig.character.clips[0].channels.size(), 1u);
  EXPECT_TRUE(rig.character.clips[1].weights.empty());
  expect_shown(b, 0);
  expect_shown(b, 1);
  b.document["animations"][0]["samplers"][1]["interpolation"] = "STEP";
  expect_shown(b, 0);
}

// Cubic keys by hand: without tangents u^2 (3 - 2 u) of the way; one tangent adds half its slope.
TEST(GltfShapes, cubic_keys) {
  rig::WeightChannel channel{.interpolation = rig::Interpolation::cubic_spline,
                             .times = {1.0, 3.0},
                             .values = std::make_shared<const std::vector<double>>(
                                 std::vector<double>{0, 0, 0.0, 2.0, 0, 1, 0, 0, 1.0, 2.0, 0, 0})};
  const std::vector<double> at = rig::weights_at(channel, 1.5);
  ASSERT_EQ(at.size(), 2u);
  EXPECT_NEAR(at[0], 0.0625 * 2.5, 1e-15);
  // Slope 1 per second over two seconds: 2 (u^3 - 2 u^2 + u) at a quarter is 2 * 0.140625.
  EXPECT_NEAR(at[1], 2.0 + 0.28125, 1e-15);
  EXPECT_EQ(rig::weights_at(channel, 0.0), (std::vector<double>{0.0, 2.0}));
  EXPECT_EQ(rig::weights_at(channel, 9.0), (std::vector<double>{1.0, 2.0}));
}

TEST(GltfShapes, a_clip_of_weights_alone_has_a_duration) {
  GltfBuilder b = column_with_shapes();
  json& channels = b.document["animations"][0]["channels"];
  channels.erase(0);
  const rig::Character c = gltf::read_gltf(TemporaryFolder().write("face.glb", b.glb()));
  EXPECT_EQ(c.clips[0].duration, 1.0);
  EXPECT_TRUE(c.clips[0].channels.empty());
  expect_shown(b, 0);
}

TEST(GltfShapes, integer_targets) {
  GltfBuilder b = column_with_shapes();
  std::vector<std::int8_t> moves(48, 0);  // with a stride of four bytes
  moves[4 * 5 + 2] = 100;
  const std::size_t accessor = b.add("VEC4", moves, {{"type", "VEC3"}, {"count", 12}});
  b.document["bufferViews"].back()["byteStride"] = 4;
  b.document["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = accessor;
  const gltf::Rig rig = gltf::read_rig(TemporaryFolder().write("face.glb", b.glb()));
  EXPECT_EQ(rig.parts[0].shapes[0].vertex, std::vector<std::uint32_t>{5});
  EXPECT_EQ(rig.parts[0].shapes[0].move[0], Vector3d(0, 0, 100));
}

}  // namespace
}  // namespace fascicle::tests::gltf_shapes_test
