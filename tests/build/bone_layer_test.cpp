// Bone layers that are completed until they are connected.
#include "host/build/bone_layer.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/build/bar.h"

namespace fascicle::tests {
namespace {

using build::Body;
using scene::Vector3d;

// A bar of 41 x 9 x 9 vertices, 0.01 m apart, with two bones along its middle.
Body bar_body() {
  Body body;
  scene::Bar bar;
  bar.vertices = {41, 9, 9};
  body.mesh = build::make_bar(bar, "test");
  body.bones = {{{0.0, 0.04, 0.04}, {0.19, 0.04, 0.04}, {}}, {{0.21, 0.04, 0.04}, {0.4, 0.04, 0.04}, {}}};
  return body;
}

bool is_on_axis(const Vector3d& p) {
  return std::abs(p[1] - 0.04) < 1e-9 && std::abs(p[2] - 0.04) < 1e-9;
}

// Marks the vertices on the axis except those with from < x < to.
std::vector<char> axis_without(const Body& body, double from, double to) {
  std::vector<char> is_bone;
  for (const Vector3d& p : body.mesh.vertices)
    is_bone.push_back(is_on_axis(p) && !(p[0] > from && p[0] < to));
  return is_bone;
}

struct Completed {
  build::BoneLayerReport report;
  std::vector<char> is_bone;
};
Completed complete(const Body& body, std::vector<char> is_bone, const std::vector<char>& closed = {}) {
  build::Measures measures(body);
  const build::OneRings rings = build::one_rings(body.mesh.vertices.size(), body.mesh.tetrahedra);
  Completed result;
  result.report = build::complete_bone_layer(
      measures, rings, closed.empty() ? std::vector<char>(is_bone.size(), 0) : closed, is_bone);
  result.is_bone = std::move(is_bone);
  return result;
}

TEST(BoneLayer, IsJoinedAlongTheBone) {
  const Body body = bar_body();
  const Completed result = complete(body, axis_without(body, 0.175, 0.195));  // x = 0.18 and 0.19
  EXPECT_EQ(result.report.islands_before, 2u);
  EXPECT_EQ(result.report.islands, 1u);
  EXPECT_EQ(result.report.added, 2u);
  EXPECT_TRUE(result.report.without.empty());
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i)
    EXPECT_EQ(result.is_bone[i] != 0, is_on_axis(body.mesh.vertices[i])) << body.mesh.vertices[i].transpose();
}

TEST(BoneLayer, IsLeftAloneWhereItHoldsTogether) {
  const Body body = bar_body();
  const Completed result = complete(body, axis_without(body, 1.0, 1.0));
  EXPECT_EQ(result.report.islands_before, 1u);
  EXPECT_EQ(result.report.added, 0u);
}

// Like a bull's shank: nothing near its bone is marked, and the gap is 0.44 of the diagonal.
TEST(BoneLayer, LiesAlongABoneOfAnyLength) {
  const Body body = bar_body();
  const Completed result = complete(body, axis_without(body, 0.11, 0.29));
  EXPECT_EQ(result.report.islands_before, 2u);
  EXPECT_EQ(result.report.islands, 1u);
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i)
    EXPECT_EQ(result.is_bone[i] != 0, is_on_axis(body.mesh.vertices[i])) << body.mesh.vertices[i].transpose();
  // The same with no vertex marked at all.
  const Completed bare = complete(body, axis_without(body, -1.0, 1.0));
  EXPECT_EQ(bare.report.islands, 1u);
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i)
    EXPECT_EQ(bare.is_bone[i] != 0, is_on_axis(body.mesh.vertices[i])) << body.mesh.vertices[i].transpose();
}

TEST(BoneLayer, ReportsGapsThatAreTooWide) {
  Body body = bar_body();
  // The gap is between the two bones, where no bone leads. A tenth of the diagonal is 0.042 m.
  body.bones[0].to[0] = 0.11;
  body.bones[1].from[0] = 0.29;
  const Completed result = complete(body, axis_without(body, 0.115, 0.285));
  EXPECT_EQ(result.report.islands_before, 2u);
  EXPECT_EQ(result.report.islands, 2u);
  EXPECT_EQ(result.report.added, 0u);
  ASSERT_EQ(result.report.island_vertex.size(), 1u);
  EXPECT_TRUE(result.is_bone[result.report.island_vertex[0]]);
}

TEST(BoneLayer, GivesEveryBoneAVertex) {
  const Body body = bar_body();
  const Completed result = complete(body, axis_without(body, 0.19, 1.0));
  EXPECT_TRUE(result.report.without.empty());
  EXPECT_GE(result.report.added, 1u);
  bool second = false;
  build::Measures measures(body);
  for (std::size_t i = 0; i < result.is_bone.size(); ++i)
    second = second || (result.is_bone[i] && measures.nearest_bones()[i].bone == 1);
  EXPECT_TRUE(second);
}

TEST(BoneLayer, GoesRoundClosedVertices) {
  const Body body = bar_body();
  const std::vector<char> start = axis_without(body, 0.195, 0.205);  // x = 0.20
  std::vector<char> closed;
  for (const Vector3d& p : body.mesh.vertices)
    closed.push_back(is_on_axis(p) && std::abs(p[0] - 0.2) < 0.005);
  const Completed round = complete(body, start, closed);
  EXPECT_EQ(round.report.islands, 1u);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i]) {
      EXPECT_FALSE(round.is_bone[i]);
    }
  }
  // All closed: nothing can be added, and the report says so.
  const Completed never = complete(body, start, std::vector<char>(start.size(), 1));
  EXPECT_EQ(never.report.added, 0u);
  EXPECT_EQ(never.report.islands, 2u);
}

}  // namespace
}  // namespace fascicle::tests
