// Which flesh a scene excludes from contact: by names, layers and paint, and the resulting model arrays.
#include "host/build/contact_groups.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/contacts.h"
#include "host/model/contact_depth.h"
#include "tests/build/scenes.h"
#include "tests/support/sliding_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {
namespace {

using model::Model;
using scene::Vector3d;

// A bar of 0.4 m: an arm up to x = 0.2, a hand up to 0.3, then a finger. At 0.2 half of the weight is the
// hand's. The skin is one object with one material, painted with x / 0.4.
struct ArmBar {
  build::Body body;
  std::vector<std::uint32_t> layer;  // 1 in the upper half

  ArmBar() {
    body.mesh = build::make_bar(scene::Bar{}, "test");
    body.joints = {{"arm", -1, 0, false}, {"hand", 0, 1, false}, {"finger", 1, 1, false}};
    body.joint_count = 3;
    body.skin.offset = {0};
    body.skin_surface = {body.mesh.vertices, build::boundary_triangles(body.mesh, "test")};
    body.painted = {{"_CONTACT", 1, {}}};
    for (const Vector3d& p : body.mesh.vertices) {
      const bool is_between = std::abs(p[0] - 0.2) < 1e-9;
      body.skin.joint.push_back(p[0] < 0.19 || is_between ? 0u : p[0] < 0.29 ? 1u : 2u);
      body.skin.weight.push_back(is_between ? 0.5 : 1.0);
      if (is_between) {
        body.skin.joint.push_back(1);
        body.skin.weight.push_back(0.5);
      }
      body.skin.offset.push_back(static_cast<std::uint32_t>(body.skin.joint.size()));
      body.painted[0].values.push_back(p[0] / 0.4);
      layer.push_back(p[1] > 0.041 ? 1u : 0u);
    }
    const auto triangles = static_cast<std::uint32_t>(body.skin_surface.triangles.size());
    const auto vertices = static_cast<std::uint32_t>(body.mesh.vertices.size());
    body.parts = {{"Body", "Wool", 0, 0, vertices, 0, triangles}};
  }

  build::ContactGroups groups(const scene::NameLists& ignore, const std::string& attribute = "",
                              bool top_meets = true) {
    scene::Scene scene = bar_scene();
    scene.layers = {scene::Layer{}, scene::Layer{}};
    scene.layers[0].name = "bottom";
    scene.layers[1].name = "top";
    scene.layers[1].contact = top_meets;
    scene.contact.ignore = ignore;
    scene.contact.attribute = attribute;
    build::Measures measures(body);
    return build::contact_groups(scene, layer, measures, report);
  }
  double x(std::size_t i) const { return body.mesh.vertices[i][0]; }

  build::Report report;
};

TEST(ContactGroups, AreEmptyWhereNothingIsSaid) {
  ArmBar bar;
  const build::ContactGroups groups = bar.groups({});
  EXPECT_TRUE(groups.meets_nothing.empty());
  EXPECT_TRUE(groups.groups.empty());
}

// A joint's flesh includes that of its descendants, and vertices where it has half of the weight.
TEST(ContactGroups, NamesAreJointsLayersObjectsAndMaterials) {
  ArmBar bar;
  const build::ContactGroups groups =
      bar.groups({{"hand", "top"}, {"finger", "finger"}, {"Body", "hand"}, {"Wool", "arm"}});
  // hand, top, finger, Body, Wool, arm
  const std::vector<std::uint32_t> ignored{0b001010, 0b000001, 0b000100, 0b000001, 0b100000, 0b010000};
  for (std::size_t g = 0; g < groups.ignored.size(); ++g)
    EXPECT_EQ(groups.ignored[g], g < ignored.size() ? ignored[g] : 0u) << g;
  ASSERT_EQ(groups.groups.size(), bar.layer.size());
  for (std::size_t i = 0; i < bar.layer.size(); ++i) {
    const std::uint32_t of = (bar.x(i) > 0.199 ? 1u : 0u) | (bar.layer[i] == 1 ? 2u : 0u) |
                             (bar.x(i) > 0.299 ? 4u : 0u) | 0b111000u;
    EXPECT_EQ(groups.groups[i], of) << bar.x(i);
  }
  EXPECT_TRUE(groups.meets_nothing.empty());
  EXPECT_TRUE(bar.report.warnings.empty());
}

TEST(ContactGroups, NamesAloneLayersAndPaintMeetNothing) {
  const auto expect = [](const build::ContactGroups& groups, const ArmBar& bar, const auto& is_there) {
    ASSERT_EQ(groups.meets_nothing.size(), bar.layer.size());
    for (std::size_t i = 0; i < bar.layer.size(); ++i)
      EXPECT_EQ(groups.meets_nothing[i] != 0, is_there(i)) << bar.x(i);
    EXPECT_TRUE(groups.groups.empty());
  };
  ArmBar bar;
  expect(bar.groups({{"hand"}}), bar, [&](std::size_t i) { return bar.x(i) > 0.199; });
  expect(bar.groups({}, "", false), bar, [&](std::size_t i) { return bar.layer[i] == 1; });
  expect(bar.groups({{"finger"}}, "", false), bar,
         [&](std::size_t i) { return bar.layer[i] == 1 || bar.x(i) > 0.299; });
  // Paint of one half counts as painted. Skips x = 0.2, where rounding decides.
  const build::ContactGroups painted = bar.groups({}, "_CONTACT");
  ASSERT_EQ(painted.meets_nothing.size(), bar.layer.size());
  for (std::size_t i = 0; i < bar.layer.size(); ++i) {
    if (std::abs(bar.x(i) - 0.2) < 1e-3) continue;
    // Inside, the nearest skin may be on an end face, which has the paint of that end.
    EXPECT_EQ(painted.meets_nothing[i] != 0, bar.x(i) < 0.2) << bar.x(i);
  }
}

TEST(ContactGroups, RefuseWhatNobodyIsCalled) {
  ArmBar bar;
  expect_refusal(
      [&] {
        bar.groups({{"hand", "botom"}});
      },
      "contact.ignore: no joint, layer, object or material is called \"botom\"; did you mean bottom?");
  expect_refusal([&] { bar.groups({{"fingr"}}); }, "did you mean finger?");
  expect_refusal([&] { bar.groups({}, "_CONTCT"); }, "contact.attribute");
}

TEST(ContactGroups, WarnOfNamesWithoutFlesh) {
  ArmBar bar;
  bar.body.joints.push_back({"helper", 0, 1, false});
  bar.body.joint_count = 4;
  bar.groups({{"helper", "arm"}});
  ASSERT_EQ(bar.report.warnings.size(), 1u);
  EXPECT_NE(bar.report.warnings[0].text.find("\"helper\" has no flesh"), std::string::npos);
}

TEST(ContactGroups, HaveABitForEachOf32Names) {
  ArmBar bar;
  scene::NameLists ignore;
  for (std::size_t k = 3; k < 33; ++k) {
    bar.body.joints.push_back({"j" + std::to_string(k), 0, 1, false});
    ignore.push_back({"hand", "j" + std::to_string(k)});
  }
  bar.body.joint_count = 33;
  ignore.push_back({"arm", "hand"});
  EXPECT_EQ(std::popcount(bar.groups(ignore).ignored[0]), 31);
  ignore.push_back({"finger", "hand"});
  expect_refusal([&] { bar.groups(ignore); }, "contact.ignore: its pairs have more than 32 names");
}

// With contact.self false, in addition to the bits for named pairs.
TEST(ContactGroups, CharactersThatDoNotMeetThemselvesHaveABitEach) {
  ArmBar bar;
  bar.body.members = {{0, Vector3d::Zero(), false}, {1, Vector3d::Zero(), false}};
  const build::ContactGroups groups = bar.groups({{"top", "bottom"}});
  EXPECT_TRUE(groups.meets_others_only);
  const std::vector<std::uint32_t> ignored{0b0010, 0b0001, 0b0100, 0b1000};
  for (std::size_t g = 0; g < groups.ignored.size(); ++g)
    EXPECT_EQ(groups.ignored[g], g < ignored.size() ? ignored[g] : 0u) << g;
  for (std::size_t i = 0; i < bar.layer.size(); ++i)
    EXPECT_EQ(groups.groups[i] >> 2, build::member_of(bar.body, i) == 0 ? 0b01u : 0b10u);
  for (std::uint32_t k = 2; k < 31; ++k) bar.body.members.push_back({3 + k, Vector3d::Zero(), false});
  expect_refusal([&] { bar.groups({{"top", "bottom"}}); }, "set contact.self = true");
}

scene::ContactSettings on() {
  scene::ContactSettings settings;
  settings.self = true;
  return settings;
}

Model grouped_bar() {
  return make_model(jittered(kuhn_bar(7, 4, 4, 0.125), 0.125 / 64.0, 6, 3));
}

double rest_x(const Model& m, std::uint32_t i) {
  return double{m.rest[3 * std::size_t{i}]};
}

int corners_where(const Model& m, std::size_t t, const auto& is_there) {
  int count = 0;
  for (std::size_t k = 0; k < 4; ++k) count += is_there(m.contact_tetrahedron[4 * t + k]) ? 1 : 0;
  return count;
}

// Excluded flesh is in no array; the rest keeps its order.
TEST(WriteContactGroups, FleshThatMeetsNothingIsLeftOut) {
  Model all = grouped_bar(), m = all;
  build::write_contact(on(), "test", all);
  const auto is_out = [&](std::uint32_t i) { return rest_x(m, i) > 0.5; };
  build::ContactGroups groups;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) groups.meets_nothing.push_back(is_out(i) ? 1 : 0);
  build::write_contact(on(), "test", m, groups);
  check_model(m);
  std::vector<std::uint32_t> points, tetrahedra;
  for (const shader::ContactPoint& point : all.contact)
    if (!is_out(point.vertex)) points.push_back(point.vertex);
  for (std::size_t t = 0; t < all.contact_tetrahedron_count(); ++t)
    if (corners_where(all, t, is_out) < 2)
      tetrahedra.insert(tetrahedra.end(), &all.contact_tetrahedron[4 * t],
                        &all.contact_tetrahedron[4 * t] + 4);
  ASSERT_EQ(m.contact.size(), points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    EXPECT_EQ(m.contact[p].vertex, points[p]);
    EXPECT_EQ(m.contact[p].margin, all.contact[0].margin);
  }
  EXPECT_EQ(m.contact_tetrahedron, tetrahedra);
  EXPECT_LT(points.size(), all.contact.size());
  // The cut is a boundary for the depth too: depths only shrink, and each is the distance to the nearest face
  // that only one remaining tetrahedron has.
  std::map<std::array<std::uint32_t, 3>, int> sides;
  for (std::size_t t = 0; t < tetrahedra.size(); t += 4)
    for (std::size_t without = 0; without < 4; ++without) {
      std::array<std::uint32_t, 3> side{};
      for (std::size_t k = 0, at = 0; k < 4; ++k)
        if (k != without) side[at++] = tetrahedra[t + k];
      std::sort(side.begin(), side.end());
      ++sides[side];
    }
  const auto place = [&](std::uint32_t i) {
    return Vector3d(rest_x(m, i), double{m.rest[3 * std::size_t{i} + 1]},
                    double{m.rest[3 * std::size_t{i} + 2]});
  };
  std::size_t shallower = 0;
  for (const std::uint32_t i : std::set<std::uint32_t>(tetrahedra.begin(), tetrahedra.end())) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [side, count] : sides) {
      if (count != 1) continue;
      const Vector3d a = place(side[0]), b = place(side[1]), c = place(side[2]),
                     w = nearest_weights(place(i), a, b, c);
      least = std::min(least, (w[0] * a + w[1] * b + w[2] * c - place(i)).norm());
    }
    EXPECT_NEAR(double{m.contact_depth[i]}, least, 1e-6) << i;
    EXPECT_LE(m.contact_depth[i], all.contact_depth[i]);
    shallower += m.contact_depth[i] < all.contact_depth[i] ? 1 : 0;
  }
  EXPECT_GT(shallower, 3u);
  EXPECT_TRUE(m.contact_ignored.empty());
  EXPECT_TRUE(m.contact_group.empty());
}

TEST(WriteContactGroups, SomethingMustBeLeft) {
  Model m = grouped_bar();
  build::ContactGroups groups;
  groups.meets_nothing.assign(m.vertex_count, 1);
  expect_refusal([&] { build::write_contact(on(), "test", m, groups); }, "contact: no flesh is left");
  build::write_contact({}, "test", m, groups);
  EXPECT_FALSE(m.has_contact());
}

// The two ends ignore each other; the left end also ignores itself.
TEST(WriteContactGroups, PairsAreMasksOfPointsAndTetrahedra) {
  Model m = grouped_bar();
  const auto is_left = [&](std::uint32_t i) { return rest_x(m, i) < 0.3; };
  const auto is_right = [&](std::uint32_t i) { return rest_x(m, i) > 0.6; };
  build::ContactGroups groups;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    groups.groups.push_back((is_left(i) ? 1u : 0u) | (is_right(i) ? 2u : 0u) | 8u);
  groups.ignored = {3, 1};
  build::write_contact(on(), "test", m, groups);
  check_model(m);
  ASSERT_TRUE(m.has_ignored_contact());
  std::size_t ignored = 0;
  for (std::uint32_t p = 0; p < m.contact.size(); ++p)
    for (std::uint32_t t = 0; t < m.contact_tetrahedron_count(); ++t) {
      const std::uint32_t i = m.contact[p].vertex;
      const bool of_left = corners_where(m, t, is_left) >= 2, of_right = corners_where(m, t, is_right) >= 2;
      const bool expected = (is_left(i) && (of_left || of_right)) || (is_right(i) && of_left);
      ASSERT_EQ(m.is_ignored_contact(p, t), expected);
      ignored += expected ? 1 : 0;
    }
  EXPECT_GT(ignored, 1000u);
  // For points that ignore an end, the depth starts at that end's boundary. Depths inside the ignored end are
  // never used.
  for (std::uint32_t p = 0; p < m.contact.size(); ++p) {
    std::size_t begins = 0;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      EXPECT_LE(model::contact_depth_of(m, p, i), m.contact_depth[i]);
      begins += model::contact_depth_of(m, p, i) == 0.0f && m.contact_depth[i] > 0.0f ? 1 : 0;
    }
    EXPECT_EQ(begins > 0, m.contact_ignored[p] != 0);
  }
  for (const std::uint32_t of : m.contact_group) EXPECT_LT(of, 4u) << "no group ignores the fourth";
}

// Groups that nothing ignores leave no trace.
TEST(WriteContactGroups, CostNothingWhereNothingIsIgnored) {
  Model all = grouped_bar(), m = all;
  build::write_contact(on(), "test", all);
  build::ContactGroups groups;
  groups.groups.assign(m.vertex_count, 1);
  groups.ignored[1] = 1;
  build::write_contact(on(), "test", m, groups);
  EXPECT_TRUE(m.contact_ignored.empty());
  EXPECT_TRUE(m.contact_group.empty());
  EXPECT_EQ(m.contact_tetrahedron, all.contact_tetrahedron);
}

TEST(WriteContactGroups, ASceneAsksForThem) {
  scene::Scene scene = bar_scene();
  scene.contact.self = true;
  scene.layers.push_back(scene.layers[0]);
  scene.layers[1].name = "end";
  scene.layers[1].where = {scene::HalfSpace{scene::Axis::x, false, true, 0.5}};
  scene.contact.ignore = {{"end", "body"}};
  Model m = build_quietly(scene);
  check_model(m);
  EXPECT_TRUE(m.has_ignored_contact());
  scene.contact.ignore = {{"end", "bode"}};
  expect_refusal([&] { build_quietly(scene); }, "did you mean body?");
  scene.contact.ignore.clear();
  scene.layers[1].contact = false;
  m = build_quietly(scene);
  check_model(m);
  EXPECT_FALSE(m.has_ignored_contact());
  EXPECT_LT(m.contact_tetrahedron_count(), m.tetrahedron_count());
  scene.layers[0].contact = false;
  expect_refusal([&] { build_quietly(scene); }, "no flesh is left");
}

}  // namespace
}  // namespace fascicle::tests
