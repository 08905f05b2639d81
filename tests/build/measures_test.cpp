// Distances from bones, and which bones count for which vertex.
#include "host/build/measures.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/local_radius.h"

namespace fascicle::tests {
namespace {

using scene::Vector3d;

// Two upright bones, an arm at x = 0 and a flank at x = 1, and vertices between them with different weights.
build::Body body_between_two_bones() {
  build::Body body;
  body.bones = {{{0, 0, 0}, {0, 1, 0}, {0, -1, 1}}, {{1, 0, 0}, {1, 1, 0}, {2, -1, 3}}};
  body.joint_count = 4;
  body.mesh.vertices = {{0.8, 0.5, 0}, {0.8, 0.5, 0}, {0.8, 0.5, 0}, {0.8, 0.5, 0}, {0, 3, 0}};
  // All arm; 1 % flank; 2 % flank, through the joint that its bone leads to; a joint of neither bone; all
  // arm.
  body.skin.offset = {0, 1, 3, 5, 6, 7};
  body.skin.joint = {0, 0, 2, 1, 3, 3, 1};
  body.skin.weight = {1.0, 0.99, 0.01, 0.98, 0.02, 1.0, 1.0};
  return body;
}

TEST(BoneDistance, CountsOnlyBonesThatMoveTheVertex) {
  const build::Body body = body_between_two_bones();
  build::Measures test(body);
  const std::vector<double>& distance = test.bone_distances();
  // Halves and fifths, so each distance is rounded a few times.
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

// A rod 2 m long and 0.2 m thick, its distance from the skin, and the largest ball that reaches a vertex, by
// exhaustive search.
constexpr double rod_length = 2.0, rod_thickness = 0.2, rod_spacing = 0.025;

mesh::TetMesh rod() {
  scene::Bar bar;
  bar.size = {rod_length, rod_thickness, rod_thickness};
  bar.vertices = {81, 9, 9};
  return build::make_bar(bar, "rod");
}

std::vector<double> from_skin_of(const mesh::TetMesh& mesh) {
  std::vector<double> distance;
  for (const Vector3d& p : mesh.vertices)
    distance.push_back(
        std::min({p[0], rod_length - p[0], p[1], rod_thickness - p[1], p[2], rod_thickness - p[2]}));
  return distance;
}

TEST(LocalRadius, IsThatOfTheLargestBallThatReachesAVertex) {
  const mesh::TetMesh mesh = rod();
  const std::vector<double> from_skin = from_skin_of(mesh), radius = build::local_radii(mesh, from_skin);
  for (std::size_t i = 0; i < radius.size(); ++i) {
    double largest = 0.0;
    for (std::size_t c = 0; c < radius.size(); ++c)
      if ((mesh.vertices[i] - mesh.vertices[c]).norm() <= (1.5 + 1e-6) * from_skin[c])
        largest = std::max(largest, from_skin[c]);
    // The build may skip balls hidden by larger ones, which costs at most one spacing. The smallest radius is
    // half an edge. Corners that no ball reaches get the rod's radius.
    EXPECT_LE(radius[i], largest > 0.0 ? std::max(largest, rod_spacing) : rod_thickness / 2.0 + 1e-12) << i;
    EXPECT_GE(radius[i], largest - rod_spacing - 1e-12) << i;
    const double end = std::min(mesh.vertices[i][0], rod_length - mesh.vertices[i][0]);
    // Away from the ends, balls on the axis reach every vertex: the rod's edges are 1.41 radii from the axis.
    if (end > rod_thickness) {
      EXPECT_NEAR(radius[i], rod_thickness / 2.0, 1e-12) << i;
    }
  }
}

// Flesh beyond the end of the only bone has no bone inside and follows the skeleton.
TEST(FollowsJoints, FarBeyondTheLastBone) {
  build::Body body;
  body.mesh = rod();
  const double middle = rod_thickness / 2.0;
  body.bones = {{{0, middle, middle}, {1, middle, middle}, {0, -1, -1}}};
  body.joint_count = 1;
  body.joints = {{"arm", -1, 0, false}};
  body.skin.offset.push_back(0);
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    body.skin.joint.push_back(0);
    body.skin.weight.push_back(1.0);
    body.skin.offset.push_back(static_cast<std::uint32_t>(i + 1));
  }
  build::Measures measures(body);
  const std::vector<char>& follows = measures.follows_joints();
  for (std::size_t i = 0; i < follows.size(); ++i) {
    const Vector3d& p = body.mesh.vertices[i];
    // Two radii are 0.2 m; the rod's edge is 0.14 m from its axis. Next to the corners of its ends, only
    // smaller balls reach a vertex.
    if (p[0] > 0.04 && p[0] < 1.13) {
      EXPECT_EQ(int{follows[i]}, 0) << p.transpose();
    }
    if (p[0] > 1.21) {
      EXPECT_EQ(int{follows[i]}, 1) << p.transpose();
    }
    if (follows[i]) {
      EXPECT_EQ(measures.bone_distances()[i], 0.0) << p.transpose();
    }
  }
}

}  // namespace
}  // namespace fascicle::tests
