// Distances from bones: which bones count for which vertex.
#include "host/build/measures.h"

#include <cmath>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using scene::Vector3d;

// Two upright bones, an arm at x = 0 and a flank at x = 1, and vertices between them with weights of their
// own.
build::Body body_between_two_bones() {
  build::Body body;
  body.bones = {{{0, 0, 0}, {0, 1, 0}, {0, -1, 1}}, {{1, 0, 0}, {1, 1, 0}, {2, -1, 3}}};
  body.joint_count = 4;
  body.mesh.vertices = {{0.8, 0.5, 0}, {0.8, 0.5, 0}, {0.8, 0.5, 0}, {0.8, 0.5, 0}, {0, 3, 0}};
  // All the arm's; 1 % of the flank's; 2 % of the flank's, through the joint it leads to; a joint of neither;
  // the arm's.
  body.skin.offset = {0, 1, 3, 5, 6, 7};
  body.skin.joint = {0, 0, 2, 1, 3, 3, 1};
  body.skin.weight = {1.0, 0.99, 0.01, 0.98, 0.02, 1.0, 1.0};
  return body;
}

TEST(BoneDistance, CountsOnlyBonesThatMoveTheVertex) {
  const build::Body body = body_between_two_bones();
  build::Measures test(body);
  const std::vector<double>& distance = test.bone_distances();
  // Halves and fifths: each distance is rounded a few times.
  EXPECT_NEAR(distance[0], 0.8, 1e-15);
  EXPECT_NEAR(distance[1], 0.8, 1e-15);
  EXPECT_NEAR(distance[2], 0.2, 1e-15);
  EXPECT_NEAR(distance[3], 0.2, 1e-15);
  EXPECT_NEAR(distance[4], 2.0, 1e-15);
}

TEST(BoneDistance, CountsAllBonesWhereNoneIsTheVertexsOwn) {
  build::Body body = body_between_two_bones();
  body.bones.erase(body.bones.begin());
  build::Measures test(body);
  EXPECT_NEAR(test.bone_distances()[0], 0.2, 1e-15);
}

TEST(BoneDistance, CountsAllBonesWithoutASkeleton) {
  build::Body body = body_between_two_bones();
  body.skin = {};
  build::Measures test(body);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(test.bone_distances()[i], 0.2, 1e-15);
}

TEST(BoneDistance, OfASegmentWithoutLengthIsThatOfItsPoint) {
  EXPECT_DOUBLE_EQ(build::segment_distance({3, 4, 0}, {0, 0, 0}, {0, 0, 0}), 5.0);
  EXPECT_DOUBLE_EQ(build::segment_distance({3, 4, 0}, {0, 0, 0}, {1, 0, 0}), std::sqrt(20.0));
  EXPECT_DOUBLE_EQ(build::segment_distance({0.5, 4, 3}, {0, 0, 0}, {1, 0, 0}), 5.0);
}

}  // namespace
}  // namespace fascicle::tests
