// A Model's limits, from the layers' least volumes.
#include "host/build/limits.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

// A bar of two layers, pinned at one end, two cells deep.
scene::Scene two_layers(double lower, double upper) {
  scene::Scene scene = bar_scene();
  scene.pins = {{"end", {scene::HalfSpace{scene::Axis::x, true, true, 0.11}}}};
  scene.solver.integrator = scene::Integrator::implicit_step;
  scene.layers[0].youngs_modulus = 1e4;
  scene.layers[0].least_volume = lower;
  scene::Layer soft = scene.layers[0];
  soft.name = "soft";
  soft.density = 500.0;
  soft.least_volume = upper;
  soft.where = {scene::HalfSpace{scene::Axis::y, false, true, 0.5}};
  scene.layers.push_back(soft);
  return scene;
}

std::array<std::uint32_t, 4> corners_of(const shader::Limit& l) {
  return {l.corner_a, l.corner_b, l.corner_c, l.corner_d};
}

TEST(Limits, WithoutThemTheModelIsAsItWas) {
  const Model none = build_quietly(two_layers(0.0, 0.0));
  EXPECT_FALSE(none.has_limits());
  EXPECT_TRUE(none.mobility.empty());
  const Model some = build_quietly(two_layers(0.3, 0.3));
  check_model(some);
  EXPECT_EQ(some.pull, none.pull);
  EXPECT_EQ(some.share_given, none.share_given);
  EXPECT_EQ(some.stiffness, none.stiffness);
  EXPECT_EQ(some.tetrahedron, none.tetrahedron);
}

// Each tetrahedron appears once, with the largest share of its free corners times its own volume; tetrahedra
// without free corners do not appear.
TEST(Limits, ATetrahedronKeepsTheLargestShareOfItsFreeCorners) {
  const Model m = build_quietly(two_layers(0.2, 0.4));
  check_model(m);
  const auto rest = [&](std::uint32_t i) {
    return Vector3d(double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]});
  };
  std::set<std::array<std::uint32_t, 4>> limited;
  std::set<double> shares;
  for (const shader::Limit& l : m.limit) {
    const auto c = corners_of(l);
    limited.insert(c);
    double expected = 0.0;
    for (const std::uint32_t i : c)
      if (!m.is_kinematic(i)) expected = std::max(expected, m.layer_of(i) == 0 ? 0.2 : 0.4);
    const double six = (rest(c[1]) - rest(c[0])).cross(rest(c[2]) - rest(c[0])).dot(rest(c[3]) - rest(c[0]));
    const double size = double{l.size};
    EXPECT_NEAR(double{l.least} * size * size * size / six, expected, 1e-5);
    shares.insert(expected);
  }
  EXPECT_EQ(shares.size(), 2u);
  EXPECT_EQ(limited.size(), m.limit.size());
  std::size_t expected = 0;
  for (std::size_t t = 0; t < m.tetrahedron.size(); t += 4) {
    bool free = false;
    for (std::size_t k = 0; k < 4; ++k) free = free || !m.is_kinematic(m.tetrahedron[t + k]);
    expected += free;
  }
  EXPECT_LT(expected, std::size_t{m.tetrahedron_count()});
  EXPECT_EQ(m.limit.size(), expected);
}

// A layer without a least volume is unlimited, except in tetrahedra that it shares with a limited layer.
TEST(Limits, ALayerOfItsOwn) {
  const Model m = build_quietly(two_layers(0.0, 0.3));
  EXPECT_TRUE(m.has_limits());
  for (const shader::Limit& l : m.limit) {
    bool soft = false;
    for (const std::uint32_t i : corners_of(l)) soft = soft || (m.layer_of(i) == 1 && !m.is_kinematic(i));
    EXPECT_TRUE(soft);
  }
}

TEST(Limits, MobilitiesAreInverseMassesAroundOne) {
  const Model m = build_quietly(two_layers(0.3, 0.3));
  double mass = 0.0, free = 0.0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    if (!m.is_kinematic(i)) {
      mass += m.mass[i];
      free += 1.0;
    }
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    EXPECT_NEAR(double{m.mobility[i]}, m.is_kinematic(i) ? 0.0 : mass / free / m.mass[i], 1e-4);
}

}  // namespace
}  // namespace fascicle::tests
