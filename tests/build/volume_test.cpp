// The volume term: which regions have it, how strong it is, and the rest-shape data for the solvers.
#include "host/build/volume.h"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;

scene::Scene stiff_and_soft(double lower, double upper) {
  scene::Scene scene = bar_scene();
  scene::Layer soft = scene.layers[0];
  soft.name = "soft";
  soft.alpha = 0.3;
  soft.volume = upper;
  soft.where = {scene::HalfSpace{scene::Axis::y, false, true, 0.5}};
  scene.layers[0].volume = lower;
  scene.layers.push_back(soft);
  return scene;
}

// The moment (8) at rest about the weighted centre, from all members including the vertex itself.
Matrix3d moment_at_rest(const Model& m, std::uint32_t r) {
  const auto rest = [&](std::uint32_t i) {
    return Vector3d(double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]});
  };
  double own = 1.0;
  for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k) own -= double{m.share_given[k]};
  std::vector<std::pair<std::uint32_t, double>> parts{{r, own * double{m.pull[r]}}};
  for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
    parts.emplace_back(m.ring[k], double{m.share_taken[k]} * double{m.pull[m.ring[k]]});
  Vector3d centre = Vector3d::Zero();
  double weight = 0.0;
  for (const auto& [i, w] : parts) {
    centre += w * rest(i);
    weight += w;
  }
  centre /= weight;
  Matrix3d sum = Matrix3d::Zero();
  for (const auto& [i, w] : parts) sum += w * (rest(i) - centre) * (rest(i) - centre).transpose();
  return sum;
}

TEST(Volume, WithoutItTheModelIsAsItWas) {
  const Model none = build_quietly(stiff_and_soft(0.0, 0.0));
  EXPECT_TRUE(none.volume_gain.empty());
  EXPECT_TRUE(none.region_volume.empty());
  const Model some = build_quietly(stiff_and_soft(0.0, 1.0));
  EXPECT_EQ(some.pull, none.pull);
  EXPECT_EQ(some.share_given, none.share_given);
  EXPECT_EQ(some.region_rest, none.region_rest);
}

// 2 (2.5 / alpha - 1), at most 32, for the stiffest vertex in the region.
TEST(Volume, GainIsWhatStiffnessLeavesRoomFor) {
  EXPECT_EQ(build::volume_gain(0.0, 1.0), 0.0);
  EXPECT_EQ(build::volume_gain(1.0, 0.0), 0.0);
  EXPECT_EQ(build::volume_gain(1.0, 1.0), 3.0);
  EXPECT_EQ(build::volume_gain(0.5, 1.0), 1.5);
  EXPECT_EQ(build::volume_gain(1.0, 0.25), 18.0);
  EXPECT_EQ(build::volume_gain(1.0, 0.1), 32.0);
  EXPECT_EQ(build::volume_gain(1.0, 3.0), 0.0);

  const Model m = build_quietly(stiff_and_soft(0.0, 0.5));
  ASSERT_EQ(m.volume_gain.size(), m.vertex_count);
  int at_the_border = 0, inside = 0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    bool stiff = m.layer_of(r) == 0;
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
      stiff = stiff || m.alpha[m.ring[k]] == 1.0f;
    const float expected = m.layer_of(r) == 0 ? 0.0f : stiff ? 1.5f : 22.0f / 3.0f;
    EXPECT_FLOAT_EQ(m.volume_gain[r], expected) << r;
    at_the_border += expected == 1.5f;
    inside += expected > 7.0f;
  }
  EXPECT_GT(at_the_border, 0);
  EXPECT_GT(inside, 0);
}

// The build's numbers are rounded to floats. Here the moment is summed in another order, about a separately
// computed centre, from float weights: 1e-5 is a hundred roundings.
TEST(Volume, RegionsHoldTheRestShape) {
  const Model m = build_quietly(stiff_and_soft(1.0, 1.0));
  EXPECT_NO_THROW(model::check_model(m));
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    ASSERT_GT(m.volume_gain[r], 0.0f) << r;
    const Matrix3d A0 = double{m.region_volume[3 * r]} * moment_at_rest(m, r);
    EXPECT_NEAR(A0.determinant(), 1.0, 1e-5);
    EXPECT_NEAR(double{m.region_volume[3 * r + 1]} / A0.inverse().squaredNorm(), 1.0, 1e-5);
    EXPECT_NEAR(double{m.region_volume[3 * r + 2]} * A0.inverse().trace() / A0.inverse().squaredNorm() /
                    double{m.volume_gain[r]},
                1.0, 1e-5);
  }
}

// A plate one cell thick, 400 times as long as thick. The moments of its regions are flat, and their volume
// is only rounding.
TEST(Volume, FlatRegionsHaveNone) {
  scene::Scene scene = bar_scene();
  scene.layers[0].volume = 1.0;
  scene.geometry = scene::Bar{.size = {4.0, 4.0, 0.01}, .vertices = {5, 5, 2}};
  EXPECT_TRUE(build_quietly(scene).volume_gain.empty());
}

}  // namespace
}  // namespace fascicle::tests
