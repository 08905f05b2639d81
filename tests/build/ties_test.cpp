// A Model's ties from a sliding layer, compared with a search of all triangles, and which pairs of vertices
// share regions.
#include "host/build/ties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle_implicit.h"
#include "host/bake/identity.h"
#include "host/build/steps.h"
#include "tests/build/scenes.h"
#include "tests/support/sliding_models.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

scene::Layer skin_layer(bool sliding = true) {
  scene::Layer skin;
  skin.name = "skin";
  skin.sliding = sliding;
  skin.where = {scene::HalfSpace{scene::Axis::y, false, true, 1.0}};
  return skin;
}

// A bar with skin on top; one end is pinned, including its skin.
scene::Scene skin_scene(bool sliding = true) {
  scene::Scene scene = bar_scene();
  scene.geometry = scene::Bar{.vertices = {9, 4, 4}, .jitter = 0.2};
  scene.layers.push_back(skin_layer(sliding));
  return scene;
}

bool is_free_skin(const Model& m, std::uint32_t i) {
  return m.layer_of(i) == 1 && !m.is_kinematic(i);
}

bool are_neighbours(const Model& m, std::uint32_t i, std::uint32_t j) {
  return std::binary_search(m.ring.begin() + m.ring_offset[i], m.ring.begin() + m.ring_offset[i + 1], j);
}

TEST(Ties, SkinSharesNoRegionWithFreeFlesh) {
  const Model m = build_quietly(skin_scene()), whole = build_quietly(skin_scene(false));
  check_model(m);
  std::size_t dropped = 0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    for (std::uint32_t e = whole.ring_offset[i]; e < whole.ring_offset[i + 1]; ++e) {
      const std::uint32_t j = whole.ring[e];
      const bool apart = !m.is_kinematic(i) && !m.is_kinematic(j) && m.layer_of(i) != m.layer_of(j);
      EXPECT_EQ(are_neighbours(m, i, j), !apart);
      dropped += apart;
    }
  EXPECT_GT(dropped, 0u);
  EXPECT_EQ(m.ring.size() + dropped, whole.ring.size());
}

// Repeats the search over all triangles: the nearest one, and on a shared edge the one with the largest
// height.
TEST(Ties, EachSkinVertexIsTiedToTheNearestPlaceBelow) {
  const Model m = build_quietly(skin_scene());
  const auto at = [&](std::uint32_t i) {
    return Vector3d(double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]});
  };
  std::set<std::uint32_t> tied;
  for (const shader::Tie& tie : m.tie) {
    EXPECT_TRUE(is_free_skin(m, tie.sliding));
    EXPECT_TRUE(tied.insert(tie.sliding).second);
    const Vector3d s = at(tie.sliding);
    double least = 1e300, highest = 0.0;
    for (std::size_t t = 0; t < m.tetrahedron.size(); t += 4) {
      std::vector<std::uint32_t> below;
      for (std::size_t k = t; k < t + 4; ++k)
        if (m.layer_of(m.tetrahedron[k]) != 1) below.push_back(m.tetrahedron[k]);
      if (below.size() != 3) continue;
      const std::array<Vector3d, 3> x{at(below[0]), at(below[1]), at(below[2])};
      const Vector3d b = nearest_weights(s, x[0], x[1], x[2]);
      const double distance = (b[0] * x[0] + b[1] * x[1] + b[2] * x[2] - s).norm();
      if (distance > least * (1.0 + 1e-9)) continue;
      if (distance < least * (1.0 - 1e-9)) highest = 0.0;
      least = std::min(least, distance);
      highest = std::max(highest, std::abs((s - x[0]).dot((x[1] - x[0]).cross(x[2] - x[0]).normalized())));
    }
    EXPECT_NEAR(double{tie.rest_height}, highest, 1e-6 * highest);
    const Vector3d a = at(tie.corner_a);
    const Vector3d n = (at(tie.corner_b) - a).cross(at(tie.corner_c) - a).normalized();
    EXPECT_NEAR((s - a).dot(n), double{tie.rest_height}, 1e-6 * highest);
  }
  std::size_t free_skin = 0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) free_skin += is_free_skin(m, i);
  EXPECT_EQ(tied.size(), free_skin);
}

// With positions scaled by the square roots of the masses, the ties' step is x <- x - S x, S = sum of k c
// c^T. No eigenvalue of S exceeds tie_share, wherever the feet are, so all ties together are as stable as
// one. The largest is close to it, so none of the share is wasted.
TEST(Ties, AllAtOnceMoveNothingTooFar) {
  const Model m = build_quietly(skin_scene());
  const auto n = static_cast<Eigen::Index>(m.vertex_count);
  for (const double slide : {0.0, 0.02, 0.1}) {
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
    for (const shader::Tie& tie : m.tie) {
      const auto at = [&](std::uint32_t i) {
        return Vector3d(double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]});
      };
      Eigen::Matrix3d frame;
      frame.col(0) = at(tie.corner_b) - at(tie.corner_a);
      frame.col(1) = at(tie.corner_c) - at(tie.corner_a);
      frame.col(2) = frame.col(0).cross(frame.col(1));
      const Vector3d foot =
          frame.inverse() * (at(tie.sliding) + Vector3d(slide, 0, slide) - at(tie.corner_a));
      const Vector3d b(1.0 - foot[0] - foot[1], foot[0], foot[1]);
      const double load = 1.0 + b[0] * b[0] * double{tie.mobility_a} + b[1] * b[1] * double{tie.mobility_b} +
                          b[2] * b[2] * double{tie.mobility_c};
      const double k = build::tie_share * m.mass[tie.sliding] / load;
      Eigen::VectorXd c = Eigen::VectorXd::Zero(n);
      const auto put = [&](std::uint32_t i, double of) {
        c[i] = m.is_kinematic(i) ? 0.0 : of / std::sqrt(m.mass[i]);
      };
      put(tie.sliding, -1.0);
      put(tie.corner_a, b[0]);
      put(tie.corner_b, b[1]);
      put(tie.corner_c, b[2]);
      S += k * c * c.transpose();
    }
    const double largest =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
    EXPECT_LE(largest, build::tie_share * (1.0 + 1e-6)) << slide;
    EXPECT_GE(largest, 0.8 * build::tie_share) << slide;
  }
}

// Without sliding there are no ties, and neither the hash nor the file includes them (model_file_test.cpp).
TEST(Ties, NoneWithoutSliding) {
  const Model m = build_quietly(skin_scene(false));
  EXPECT_FALSE(m.has_ties());
  EXPECT_TRUE(m.tie_offset.empty());
  EXPECT_NE(bake::model_hash(m), bake::model_hash(build_quietly(skin_scene())));
}

TEST(Ties, SkinOnNothingIsRefusedByName) {
  scene::Scene scene = skin_scene();
  scene.layers[0].kinematic = true;
  expect_refusal([&] { build_quietly(scene); },
                 "layers.skin.sliding: none of its free vertices lies on free flesh");
  scene = skin_scene();
  scene.layers[1].where = {scene::HalfSpace{scene::Axis::y, false, true, 0.0}};
  expect_refusal([&] { build_quietly(scene); }, "layers.skin.sliding");
}

// All but the lowest vertices are skin: sliding would leave those below neighbours in their own plane only.
// They keep their pairs, and skin farther up, which has none with them, its own.
TEST(Ties, FleshThatSlidingWouldLeaveFlatKeepsItsPairs) {
  const auto implicit = [](bool sliding) {
    scene::Scene scene = skin_scene(sliding);
    scene.geometry = scene::Bar{.vertices = {9, 4, 4}};
    scene.layers[1].where = {scene::HalfSpace{scene::Axis::y, false, true, 0.2}};
    scene.solver.integrator = scene::Integrator::implicit_step;
    for (scene::Layer& layer : scene.layers) layer.youngs_modulus = 5000.0;
    return scene;
  };
  build::Report report;
  const Model m = build::build_model(implicit(true), report), whole = build_quietly(implicit(false));
  check_model(m);
  const auto may_share = [&](std::uint32_t i, std::uint32_t j) {
    return m.is_kinematic(i) || m.is_kinematic(j) || m.layer_of(i) == m.layer_of(j);
  };
  const auto would_be_flat = [&](std::uint32_t i) {
    if (m.is_kinematic(i) || m.layer_of(i) == 1) return false;
    for (std::uint32_t e = whole.ring_offset[i]; e < whole.ring_offset[i + 1]; ++e)
      if (may_share(i, whole.ring[e]) && m.rest[3 * whole.ring[e] + 1] != m.rest[3 * i + 1]) return false;
    return true;
  };
  std::size_t flat = 0, dropped = 0;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    flat += would_be_flat(i);
    EXPECT_TRUE(std::isfinite(m.stiffness[i]) && m.stiffness[i] > 0.0);
    for (std::uint32_t e = whole.ring_offset[i]; e < whole.ring_offset[i + 1]; ++e) {
      const std::uint32_t j = whole.ring[e];
      const bool together = may_share(i, j) || would_be_flat(i) || would_be_flat(j);
      EXPECT_EQ(are_neighbours(m, i, j), together);
      dropped += !together;
    }
  }
  EXPECT_GT(flat, 20u);
  EXPECT_EQ(m.ring.size() + dropped, whole.ring.size());
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_EQ(report.warnings[0].text.find(std::to_string(flat) + " vertices do not slide,"), 0u)
      << report.warnings[0].text;
}

// With jitter nothing is flat, and every pair across the border is cut, implicit or not.
TEST(Ties, AllElseSlidesInImplicitScenesToo) {
  scene::Scene scene = skin_scene();
  const Model printed = build_quietly(scene);
  scene.solver.integrator = scene::Integrator::implicit_step;
  for (scene::Layer& layer : scene.layers) layer.youngs_modulus = 5000.0;
  build::Report report;
  EXPECT_EQ(build::build_model(scene, report).ring, printed.ring);
  for (const build::Warning& warning : report.warnings)
    EXPECT_EQ(warning.text.find("not slide"), std::string::npos) << warning.text;
}

TEST(Ties, WarnsOfSkinThatNothingHolds) {
  const auto warnings = [](const scene::Scene& scene) {
    build::Report report;
    build::build_model(scene, report);
    std::string all;
    for (const build::Warning& warning : report.warnings) all += warning.text + "\n";
    return all;
  };
  scene::Scene scene = skin_scene();
  EXPECT_EQ(warnings(scene), "");
  scene.pins[0].where = {scene::Box{{-1.0, -1.0, -1.0}, {0.01, 0.05, 1.0}}};
  EXPECT_NE(warnings(scene).find("1 part of the sliding layers"), std::string::npos) << warnings(scene);
}

// Skin is a sheet: in its plane, a square grid of spacing d has S = m (d^2 a, d^2 b) from its neighbours; the
// direction across it must not count.
TEST(Ties, ASheetIsAsStiffAsTheOraclesAndFinite) {
  scene::Scene scene = skin_scene();
  scene.solver.integrator = scene::Integrator::implicit_step;
  scene.layers[0].youngs_modulus = 3e3;
  scene.layers[1].youngs_modulus = 3.5e4;
  for (const auto [bend, slope] : {std::array{0.0, 0.0}, {0.3, 0.0}, {0.3, 0.2}}) {
    // The second sheet is curved: the bar is bent into an arch. The third is also curved across, and its
    // normals have no coordinate that is 0.
    mesh::TetMesh mesh;
    const Model flat = build_quietly(skin_scene());
    for (std::uint32_t i = 0; i < flat.vertex_count; ++i) {
      const Vector3d p = Vector3d(flat.rest[3 * i], flat.rest[3 * i + 1], flat.rest[3 * i + 2]) * flat.unit;
      const double drop = bend * p[0] * p[0] / 0.2 + slope * (p[2] + 10.0 * p[2] * p[2]);
      mesh.vertices.push_back(p - Vector3d(0.0, drop, 0.0));
    }
    for (std::size_t t = 0; t < flat.tetrahedron.size(); t += 4)
      mesh.tetrahedra.push_back(
          {flat.tetrahedron[t], flat.tetrahedron[t + 1], flat.tetrahedron[t + 2], flat.tetrahedron[t + 3]});
    if (bend > 0.0) {
      scene.geometry = mesh;
      scene.layers[1].where = {scene::HalfSpace{scene::Axis::y, false, true, 0.93}};
    }
    const Model m = build_quietly(scene);
    check_model(m);
    ASSERT_TRUE(m.has_ties());
    const std::vector<double> K = cpu_reference::vertex_stiffness(m, cpu_reference::region_stiffness(m));
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      ASSERT_TRUE(std::isfinite(m.stiffness[i]));
      // As in stiffness_test.cpp: volumes from doubles here, from floats there.
      EXPECT_NEAR(m.stiffness[i] * m.mass[i], K[i], 1e-4 * K[i]) << i;
    }
  }
}

}  // namespace
}  // namespace fascicle::tests
