// The effect of a file's blend shapes on a baked surface, compared with what a viewer shows of the file.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/formats/character_file.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/skinned_surface.h"
#include "host/gltf/gltf.h"
#include "host/rig/pose.h"
#include "tests/formats/baked_character.h"
#include "tests/gltf/gltf_builder.h"
#include "tests/gltf/gltf_viewer.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;

// The bind pose, with the shapes at their rest weights, after skinning: a baked surface without dynamics.
std::vector<float> skinned(const Baked& baked, std::uint64_t frame) {
  const auto& of = std::get<rig::Character>(baked.scene.geometry);
  const auto pose =
      rig::pose_at(of, &of.clips.front(), baked.scene.start + static_cast<double>(frame) / baked_fps);
  std::vector<float> surface;
  for (std::size_t i = 0; i < of.surface.vertices.size(); ++i) {
    Eigen::Vector4d p = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < 8; ++k)
      p += of.weights[i][k] * (pose[of.joints[i][k]] * of.surface.vertices[i].homogeneous());
    for (int axis = 0; axis < 3; ++axis)
      surface.push_back(static_cast<float>(p[axis] * baked.scene.scale / baked.model.unit));
  }
  return surface;
}

double distance(const std::vector<float>& surface, double unit, const std::vector<Vector3d>& shown,
                double scale) {
  EXPECT_EQ(surface.size(), 3 * shown.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < shown.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      worst = std::max(
          worst, std::abs(unit * double{surface[3 * i + axis]} - scale * shown[i][static_cast<int>(axis)]));
  return worst;
}

class BlendShapes : public testing::TestWithParam<double> {};

TEST_P(BlendShapes, move_the_surface_as_a_viewer_shows_the_file) {
  const double scale = GetParam();
  const GltfBuilder b = column_with_shapes();
  const Baked baked(b, scale);
  const formats::ShapedSurface shapes(baked.character, baked.model, baked_fps);
  ASSERT_FALSE(shapes.empty());
  const formats::SkinnedSurface compared(baked.character, baked.model, baked_fps);
  const GltfViewer viewer(b);
  double most = 0.0;
  for (std::uint64_t frame = 0; frame <= 6; ++frame) {
    std::vector<float> surface = skinned(baked, frame);
    const std::vector<Vector3d> shown = viewer.shown(0, 0.25 + static_cast<double>(frame) / baked_fps);
    most = std::max(most, distance(surface, baked.model.unit, shown, scale));
    shapes.add_to(frame, surface);
    // The surface, the matrices and the keys in character.glb are floats of about 2.
    EXPECT_LT(distance(surface, baked.model.unit, shown, scale), 2e-6 * scale) << frame;
    EXPECT_LT(distance(compared.positions(frame), 1.0, shown, scale), 2e-6 * scale) << frame;
  }
  EXPECT_GT(most, 0.1 * scale) << "without the shapes the surface differs";
}

INSTANTIATE_TEST_SUITE_P(Scales, BlendShapes, testing::Values(1.0, 0.01));

TEST(BlendShapesOf, a_file_without_any_changes_nothing) {
  const Baked baked(column(), 1.0);
  const formats::ShapedSurface shapes(baked.character, baked.model, baked_fps);
  EXPECT_TRUE(shapes.empty());
  const std::vector<float> before = skinned(baked, 3);
  std::vector<float> after = before;
  shapes.add_to(3, after);
  EXPECT_EQ(after, before);
}

TEST(BlendShapesOf, a_still_vertex_keeps_its_bits) {
  const Baked baked(column_with_shapes(), 1.0);
  const formats::ShapedSurface shapes(baked.character, baked.model, baked_fps);
  const std::vector<float> before = skinned(baked, 4);
  std::vector<float> after = before;
  shapes.add_to(4, after);
  std::size_t same = 0;
  for (std::size_t i = 0; i < after.size(); ++i) same += before[i] == after[i] ? 1 : 0;
  EXPECT_GE(same, 3u * 8u);  // the shapes move four of twelve vertices
  EXPECT_LT(same, after.size());
}

}  // namespace
}  // namespace fascicle::tests
