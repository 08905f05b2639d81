// The contact arrays built from a body's rest shape, compared with exhaustive searches.
#include "host/build/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "tests/build/scenes.h"
#include "tests/support/contact_models.h"
#include "tests/support/sliding_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using model::Model;
using Place3 = Eigen::Vector3d;

Place3 rest_place_of(const Model& m, std::uint32_t i) {
  const std::size_t k = 3 * std::size_t{i};
  return {double{m.rest[k]}, double{m.rest[k + 1]}, double{m.rest[k + 2]}};
}

using Side = std::array<std::uint32_t, 3>;

// Faces of only one tetrahedron.
std::vector<Side> outer_sides(const Model& m) {
  std::vector<Side> sides, outer;
  for (std::size_t t = 0; t < m.tetrahedron.size(); t += 4)
    for (std::size_t without = 0; without < 4; ++without) {
      Side side{};
      for (std::size_t k = 0, at = 0; k < 4; ++k)
        if (k != without) side[at++] = m.tetrahedron[t + k];
      std::sort(side.begin(), side.end());
      sides.push_back(side);
    }
  std::sort(sides.begin(), sides.end());
  for (std::size_t k = 0; k < sides.size(); ++k) {
    const bool before = k > 0 && sides[k - 1] == sides[k],
               after = k + 1 < sides.size() && sides[k + 1] == sides[k];
    if (!before && !after) outer.push_back(sides[k]);
  }
  return outer;
}

scene::ContactSettings self_contact() {
  scene::ContactSettings settings;
  settings.self = true;
  return settings;
}

Model with_contact(Model m, const scene::ContactSettings& settings = self_contact()) {
  build::write_contact(settings, "test", m);
  return m;
}

Model a_bar() {
  return make_model(jittered(kuhn_bar(7, 4, 4, 0.125), 0.125 / 64.0, 6, 3));
}

TEST(WriteContact, DoesNothingUnlessAsked) {
  Model m = a_bar();
  build::write_contact({}, "test", m);
  EXPECT_FALSE(m.has_contact());
  EXPECT_TRUE(m.mobility.empty());
  EXPECT_TRUE(m.contact_tetrahedron.empty());
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) make_kinematic(m, i);
  EXPECT_FALSE(with_contact(m).has_contact()) << "if nothing can move";
}

TEST(WriteContact, PointsAreTheBoundaryAndDepthsTheDistanceToIt) {
  scene::ContactSettings settings = self_contact();
  settings.friction = 0.75;
  const Model m = with_contact(a_bar(), settings);
  check_model(m);
  const std::vector<Side> sides = outer_sides(m);
  std::set<std::uint32_t> boundary;
  double edges = 0.0;
  for (const Side& side : sides) {
    boundary.insert(side.begin(), side.end());
    for (std::size_t k = 0; k < 3; ++k)
      edges += (rest_place_of(m, side[k]) - rest_place_of(m, side[(k + 1) % 3])).norm();
  }
  ASSERT_EQ(m.contact.size(), boundary.size());
  EXPECT_LT(boundary.size(), std::size_t{m.vertex_count});
  for (const shader::ContactPoint& point : m.contact) {
    EXPECT_EQ(boundary.count(point.vertex), 1u);
    EXPECT_NEAR(double{point.margin}, 2.0 * edges / (3.0 * static_cast<double>(sides.size())), 1e-6);
    EXPECT_EQ(point.friction, 0.75f);
    EXPECT_EQ(point.allowance, 0.0f);
  }
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    double least = std::numeric_limits<double>::infinity();
    const Place3 x = rest_place_of(m, i);
    for (const Side& side : sides) {
      const Place3 a = rest_place_of(m, side[0]), b = rest_place_of(m, side[1]),
                   c = rest_place_of(m, side[2]);
      const Place3 w = nearest_weights(x, a, b, c);
      least = std::min(least, (w[0] * a + w[1] * b + w[2] * c - x).norm());
    }
    EXPECT_NEAR(double{m.contact_depth[i]}, least, 1e-6) << i;
    if (boundary.count(i) != 0) {
      EXPECT_EQ(m.contact_depth[i], 0.0f);
    }
  }
  settings.distance = 0.25;
  Model halved = a_bar();
  halved.unit = 0.5;
  EXPECT_EQ(with_contact(halved, settings).contact[0].margin, 0.5f) << "in working units";
}

// The upper limit is a tenth of the diagonal, or four mean surface edges if the mesh is coarse. The lower
// limit is a millionth of an edge.
TEST(WriteContact, RefusesADistanceBeyondTheBody) {
  const auto is_taken = [](const Model& m, double distance) {
    scene::ContactSettings settings = self_contact();
    settings.distance = distance;
    try {
      check_model(with_contact(m, settings));
      return true;
    } catch (const scene::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find("contact.distance"), std::string::npos) << error.what();
      return false;
    }
  };
  // 16 x 4 x 4 cells: the diagonal is 17 cells long, and the mean surface edge about 1.1 cells.
  Model m = make_model(kuhn_bar(16, 4, 4, 0.0625));
  const double edge = 0.0625 * (2.0 + std::sqrt(2.0)) / 3.0;
  EXPECT_TRUE(is_taken(m, 3.99 * edge));
  EXPECT_FALSE(is_taken(m, 4.2 * edge));
  EXPECT_TRUE(is_taken(m, 2e-6 * edge));
  EXPECT_FALSE(is_taken(m, 0.5e-6 * edge));
  EXPECT_FALSE(is_taken(m, 1e-300));
  EXPECT_FALSE(is_taken(m, 1000.0));
  m.unit = 0.25;
  EXPECT_TRUE(is_taken(m, 0.25 * 3.99 * edge)) << "metres";
  EXPECT_FALSE(is_taken(m, 0.25 * 4.2 * edge));
  const Model fine = make_model(kuhn_bar(60, 3, 2, 1.0 / 64));
  const double tenth = std::sqrt(60.0 * 60 + 9 + 4) / 640;
  EXPECT_TRUE(is_taken(fine, 0.999 * tenth));
  EXPECT_FALSE(is_taken(fine, 1.001 * tenth));
}

std::multiset<std::array<std::uint32_t, 4>> set_of_tetrahedra(const std::vector<std::uint32_t>& corners) {
  std::multiset<std::array<std::uint32_t, 4>> all;
  for (std::size_t t = 0; t < corners.size(); t += 4)
    all.insert({corners[t], corners[t + 1], corners[t + 2], corners[t + 3]});
  return all;
}

double size_of_rest_boxes(const Model& m) {
  double sum = 0.0;
  for (std::size_t leaf = 0; leaf < m.contact_leaf_count(); ++leaf) {
    const float* box = m.contact_rest_box.data() + 8 * leaf;
    sum += (double{box[4]} - double{box[0]}) * (double{box[5]} - double{box[1]}) *
           (double{box[6]} - double{box[2]});
  }
  return sum;
}

// Contains every tetrahedron once, with its corners in order, sorted so that a leaf's tetrahedra are close
// together. The boxes fit the tetrahedra.
TEST(WriteContact, TetrahedraLieTogetherInTightBoxes) {
  const Model m = with_contact(make_model(jittered(kuhn_bar(14, 8, 8, 0.0625), 0.0625 / 64.0, 6, 3)));
  ASSERT_GT(m.contact_branch_count(), 1u);
  EXPECT_EQ(set_of_tetrahedra(m.contact_tetrahedron), set_of_tetrahedra(m.tetrahedron));
  Model again = m;
  finish_contact(again);
  EXPECT_EQ(m.contact_rest_box, again.contact_rest_box);
  EXPECT_EQ(m.contact_number, again.contact_number);
  EXPECT_EQ(m.contact_offset, again.contact_offset);
  EXPECT_EQ(m.contact_entry, again.contact_entry);
  // 32 tetrahedra in a compact cube have the volume of about six cells; in the mesh's order they form long
  // rows.
  again.contact_tetrahedron = again.tetrahedron;
  finish_contact(again);
  EXPECT_LT(1.25 * size_of_rest_boxes(m), size_of_rest_boxes(again));
}

TEST(WriteContact, MobilitiesAreInverseMassesAroundOne) {
  Model m = a_bar();
  for (std::uint32_t i = 0; i < m.vertex_count; i += 3) make_kinematic(m, i);
  fill_weights(m);
  m = with_contact(m);
  Model again = m;
  finish_contact(again);
  ASSERT_EQ(m.mobility.size(), again.mobility.size());
  for (std::size_t i = 0; i < m.mobility.size(); ++i) EXPECT_NEAR(m.mobility[i], again.mobility[i], 1e-5f);
}

TEST(WriteContact, APlainBarHasNoGaps) {
  EXPECT_TRUE(with_contact(a_bar()).contact_near.empty());
}

// Two fingers along x, 0.1 apart and joined at the roots; the tip of the upper one is bent down by `bent`.
Model two_fingers(double bent) {
  Mesh all = jittered(kuhn_bar(8, 5, 2, 0.1), 0.1 / 64.0, 6, 5), mesh;
  std::vector<std::uint32_t> number(all.points.size(), 0);
  std::vector<char> is_used(all.points.size(), 0);
  const Mesh grid = kuhn_bar(8, 5, 2, 0.1);
  std::vector<std::array<std::uint32_t, 4>> kept;
  for (const auto& t : all.tetrahedra) {
    Place3 middle = Place3::Zero();
    for (const std::uint32_t i : t) middle += grid.points[i] / 4.0;
    if (middle.x() > 0.1 && middle.y() > 0.2 && middle.y() < 0.3) continue;
    kept.push_back(t);
    for (const std::uint32_t i : t) is_used[i] = 1;
  }
  for (std::uint32_t i = 0; i < all.points.size(); ++i) {
    if (is_used[i] == 0) continue;
    number[i] = static_cast<std::uint32_t>(mesh.points.size());
    Place3 p = all.points[i];
    if (p.y() > 0.25) p.y() -= bent * std::clamp((p.x() - 0.2) / 0.4, 0.0, 1.0);
    mesh.points.push_back(p);
  }
  for (auto t : kept) {
    for (std::uint32_t& i : t) i = number[i];
    mesh.tetrahedra.push_back(t);
  }
  return make_model(mesh, {.alpha = 0.5f});
}

constexpr double finger_margin = 0.15;

Model fingers_in_contact(double bent) {
  scene::ContactSettings settings = self_contact();
  settings.distance = finger_margin;
  return with_contact(two_fingers(bent), settings);
}

// Path lengths along edges from one vertex to all others, by relaxing every edge until nothing changes.
std::vector<double> ways_from(const Model& m, std::uint32_t from) {
  std::vector<double> way(m.vertex_count, std::numeric_limits<double>::infinity());
  way[from] = 0.0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i)
      for (std::uint32_t e = m.ring_offset[i]; e < m.ring_offset[i + 1]; ++e) {
        const double by = way[m.ring[e]] + (rest_place_of(m, i) - rest_place_of(m, m.ring[e])).norm();
        if (by >= way[i]) continue;
        way[i] = by;
        changed = true;
      }
  }
  return way;
}

std::vector<std::uint32_t> near_of(const Model& m, const shader::ContactPoint& point) {
  std::vector<std::uint32_t> near;
  for (std::uint32_t k = 0; k < point.near_count; ++k) {
    const shader::VertexRun run = m.contact_near[point.first_near + k];
    for (std::uint32_t i = run.first; i < run.end; ++i) near.push_back(i);
  }
  return near;
}

// At most one and a half margins apart, and at least three times that along the flesh.
TEST(WriteContact, FingersFindEachOtherAcrossTheGap) {
  const Model m = fingers_in_contact(0.0);
  check_model(m);
  std::size_t across = 0;
  for (const shader::ContactPoint& point : m.contact) {
    const std::vector<double> way = ways_from(m, point.vertex);
    std::vector<std::uint32_t> expected;
    const Place3 x = rest_place_of(m, point.vertex);
    for (std::uint32_t i = 0; i < m.vertex_count; ++i)
      if ((rest_place_of(m, i) - x).norm() <= 1.5 * finger_margin && way[i] >= 4.5 * finger_margin)
        expected.push_back(i);
    EXPECT_EQ(near_of(m, point), expected) << point.vertex;
    for (const std::uint32_t i : expected) {
      EXPECT_NE(x.y() > 0.25, rest_place_of(m, i).y() > 0.25) << "neighbour on the same finger";
      ++across;
    }
    if (x.x() < 0.25) {
      EXPECT_TRUE(expected.empty()) << "at the root";
    }
    EXPECT_EQ(point.allowance, 0.0f);
  }
  EXPECT_GT(across, 100u);
}

// How deep a point rests in the first tetrahedron across a gap that contains it; 0 if there is none.
double rest_depth(const Model& m, const shader::ContactPoint& point) {
  const std::vector<std::uint32_t> near = near_of(m, point);
  for (std::size_t t = 0; t < m.contact_tetrahedron.size(); t += 4) {
    Eigen::Matrix4d corners;
    double depth = 0.0;
    bool all_near = true;
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t i = m.contact_tetrahedron[t + static_cast<std::size_t>(k)];
      corners.col(k) << rest_place_of(m, i), 1.0;
      all_near = all_near && std::find(near.begin(), near.end(), i) != near.end();
    }
    if (!all_near) continue;
    Eigen::Vector4d x;
    x << rest_place_of(m, point.vertex), 1.0;
    const Eigen::Vector4d weights = corners.fullPivLu().solve(x);
    if (weights.minCoeff() < 0.0) continue;
    for (int k = 0; k < 4; ++k)
      depth += weights[k] * double{m.contact_depth[m.contact_tetrahedron[t + static_cast<std::size_t>(k)]]};
    return depth;
  }
  return 0.0;
}

// How far the body moves in a tenth of a second without forces, in working units.
double motion_in_peace(const Model& m) {
  const auto solver = cpu_reference::make_cpu_solver(m, {}, 1);
  TestDrive quiet = quiet_drive(m, 1.0 / 480.0, 48);
  solver->submit(quiet.get(), {.positions = true});
  const model::Frame frame = solver->collect();
  float largest = 0.0f;
  for (std::size_t k = 0; k < frame.positions.size(); ++k)
    largest = std::max(largest, std::abs(frame.positions[k] - m.rest[k]));
  return double{largest};
}

// A body that overlaps itself at rest stays at rest. The control: without the allowance it bursts apart.
TEST(WriteContact, WhatOverlapsAtRestIsAllowedTo) {
  Model m = fingers_in_contact(0.17);
  check_model(m);
  std::size_t resting = 0;
  for (const shader::ContactPoint& point : m.contact) {
    EXPECT_NEAR(double{point.allowance}, rest_depth(m, point), 1e-6) << point.vertex;
    resting += point.allowance > 0.0f ? 1 : 0;
  }
  EXPECT_GT(resting, 3u);
  EXPECT_LT(motion_in_peace(m), 1e-4);
  for (shader::ContactPoint& point : m.contact) point.allowance = 0.0f;
  EXPECT_GT(motion_in_peace(m), 2e-3);
}

TEST(WriteContact, ASceneAsksForIt) {
  scene::Scene scene = bar_scene();
  EXPECT_FALSE(build_quietly(scene).has_contact());
  scene.contact.self = true;
  const Model m = build_quietly(scene);
  check_model(m);
  EXPECT_TRUE(m.has_contact());
  EXPECT_EQ(m.contact_tetrahedron_count(), m.tetrahedron_count());
}

}  // namespace
}  // namespace fascicle::tests
