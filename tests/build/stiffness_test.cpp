// How Young's modulus, frequency and damping ratio enter a Model, compared with the Oracle's formulas.
#include "host/build/stiffness.h"

#include <cmath>

#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle_implicit.h"
#include "host/build/lowest_mode.h"
#include "host/scene/scene.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using model::Model;

// The Oracle solves for the compliance on nine entries of the strain; the build uses the invariants of S.
TEST(Stiffness, IsTheOracles) {
  const Model m = build_quietly(elastic_scene(1.7e4));
  check_model(m);
  const std::vector<double> k = cpu_reference::region_stiffness(m);
  const std::vector<double> K = cpu_reference::vertex_stiffness(m, k);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    EXPECT_EQ(m.youngs_modulus[i], 1.7e4);
    // Volumes come from double positions here and from float positions there: 1e-7 of the body divided by a
    // cell's size.
    EXPECT_NEAR(m.stiffness[i] * m.mass[i], K[i], 1e-5 * K[i]);
  }
}

// A regular tetrahedron's four vertices: S = (m/4) sum r r^T is a multiple of the identity s, C = 1/s.
TEST(Stiffness, OfARegularTetrahedronIsByHand) {
  scene::Scene scene = elastic_scene(1e3);
  mesh::TetMesh mesh;
  mesh.vertices = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  mesh.tetrahedra = {{0, 1, 2, 3}};
  scene.geometry = mesh;
  scene.layers[0].density = 600.0;
  scene.pins.clear();
  const Model m = build_quietly(scene);
  // Volume 8/3, a quarter of it at each vertex; sum m r r^T = 4 m I; k = E V / (4 m) = E / (4 density); four
  // regions.
  for (const double stiffness : m.stiffness) EXPECT_NEAR(stiffness, 4.0 * 1e3 / (4.0 * 600.0), 1e-6);
}

// A kinematic layer has no modulus; its regions are as stiff as the flesh they reach into.
TEST(Stiffness, ARegionWithoutAModulusTakesItsNeighbours) {
  scene::Scene scene = elastic_scene(5e3);
  scene::Layer bone;
  bone.name = "bone";
  bone.kinematic = true;
  bone.where = {scene::HalfSpace{scene::Axis::x, true, true, 0.3}};
  scene.layers.push_back(bone);
  for (const double E : build_quietly(scene).youngs_modulus) EXPECT_NEAR(E, 5e3, 1e-9);
}

// Bone below 0.12 m, flesh, and stiffer flesh from 0.32 m on, in cells of 0.02 m of a few grams each.
TEST(Stiffness, ARegionWithoutAModulusTakesNoOthers) {
  scene::Scene scene = elastic_scene(5e3);
  scene::Layer stiff = scene.layers[0], bone;
  stiff.name = "stiff";
  stiff.youngs_modulus = 2e4;
  stiff.where = {scene::HalfSpace{scene::Axis::x, false, true, 0.8}};
  bone.name = "bone";
  bone.kinematic = true;
  bone.where = {scene::HalfSpace{scene::Axis::x, true, true, 0.3}};
  scene.layers.push_back(stiff);
  scene.layers.push_back(bone);
  scene.pins.clear();
  const Model m = build_quietly(scene);
  const build::OneRings rings{m.ring_offset, m.ring};
  std::size_t beside_flesh = 0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    if (!m.is_kinematic(r)) continue;
    double least = 1e30, most = 0.0;
    for (const std::uint32_t i : rings[r]) {
      if (m.is_kinematic(i)) continue;
      least = std::min(least, m.youngs_modulus[i]);
      most = std::max(most, m.youngs_modulus[i]);
    }
    if (most == 0.0) continue;
    ++beside_flesh;
    EXPECT_EQ(least, 5e3);
    EXPECT_NEAR(m.youngs_modulus[r], 5e3, 1e-9) << "its neighbours' are " << least << " to " << most;
  }
  EXPECT_GT(beside_flesh, 10u);
}

// The lowest mode scales with the root of E: twice the frequency takes four times the modulus, and a modulus
// gives back its frequency.
TEST(Stiffness, FrequencyGivesAModulus) {
  scene::Scene scene = elastic_scene(2e4);
  scene.layers[0].youngs_modulus.reset();
  scene.layers[0].frequency = 2.5;
  scene.layers[0].damping_ratio = 0.25;
  const Model slow = build_quietly(scene);
  EXPECT_NEAR(slow.layers[0].frequency, 2.5, 1e-9);
  EXPECT_NEAR(slow.layers[0].damping, 2.0 * 0.25 * 2.0 * M_PI * 2.5, 1e-9);
  scene.layers[0].frequency = 5.0;
  EXPECT_NEAR(build_quietly(scene).youngs_modulus[0], 4.0 * slow.youngs_modulus[0],
              1e-6 * slow.youngs_modulus[0]);

  scene::Scene by_modulus = elastic_scene(slow.youngs_modulus[0]);
  by_modulus.layers[0].damping_ratio = 0.25;
  EXPECT_NEAR(build_quietly(by_modulus).layers[0].frequency, 2.5, 1e-6);
}

// Stopped early, the quotient is above the mode's, and it is reported as not settled.
TEST(Stiffness, AnUnsettledLowestModeSaysSo) {
  const Model m = build_quietly(elastic_scene(2e4));
  const build::OneRings rings{m.ring_offset, m.ring};
  const build::RestState state{m.rest, m.mass, m.fibre, m.beta};
  const build::RegionWeights weights = build::region_weights(rings, state, m.weight_form);
  const std::vector<double> k(m.vertex_count, 1.0);
  std::vector<char> is_free;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) is_free.push_back(m.is_kinematic(i) ? 0 : 1);
  const auto settled = build::lowest_mode({rings, state, weights, k}, is_free);
  const auto early = build::lowest_mode({rings, state, weights, k}, is_free, {.most_iterations = 3});
  ASSERT_TRUE(settled && early);
  EXPECT_TRUE(settled->settled);
  EXPECT_FALSE(early->settled);
  EXPECT_GT(early->square, settled->square);
}

TEST(Stiffness, ABodyThatNothingHoldsHasNoLowestMode) {
  scene::Scene scene = elastic_scene(2e4);
  scene.layers[0].damping_ratio = 0.25;
  scene.pins.clear();
  expect_refusal([&] { build_quietly(scene); }, "nothing holds it");
}

}  // namespace
}  // namespace fascicle::tests
