// Which vertices a brush reaches, and what it paints.
#include "host/studio/brush.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "host/scene/paint_file.h"

namespace fascicle::tests {
namespace {

using rig::find_paint_kind;
using rig::Vector3d;
using studio::Brush;
using studio::Falloff;
using studio::PaintGround;
using studio::Painting;

constexpr int cells = 20;
constexpr double edge = 0.01;

// A sheet of 20 x 20 cells of 1 cm in the x-y plane, centred at x = 0; triangles share no vertices.
void add_sheet(double z, mesh::SurfaceMesh& surface) {
  const auto corner = [&](int i, int k) {
    surface.vertices.emplace_back(edge * (i - cells / 2), edge * k, z);
    return static_cast<std::uint32_t>(surface.vertices.size() - 1);
  };
  for (int i = 0; i < cells; ++i)
    for (int k = 0; k < cells; ++k) {
      surface.triangles.push_back({corner(i, k), corner(i + 1, k), corner(i + 1, k + 1)});
      surface.triangles.push_back({corner(i, k), corner(i + 1, k + 1), corner(i, k + 1)});
    }
}

std::shared_ptr<const PaintGround> ground_of(const std::vector<double>& sheets,
                                             std::vector<rig::PaintedAttribute> own = {}) {
  mesh::SurfaceMesh surface;
  for (const double z : sheets) add_sheet(z, surface);
  return std::make_shared<const PaintGround>(surface, std::move(own));
}

Painting blank(const std::shared_ptr<const PaintGround>& ground) {
  return {ground, {ground->hash(), ground->surface().vertices.size(), {}}};
}

Brush brush_of(const char* kind, float value, double radius) {
  Brush brush;
  brush.kind = find_paint_kind(kind);
  brush.value = value;
  brush.radius = radius;
  return brush;
}

// Visits every vertex with its position.
template <class Use>
void for_each(const PaintGround& ground, const Use& use) {
  const std::vector<Vector3d>& vertices = ground.surface().vertices;
  for (std::size_t v = 0; v < vertices.size(); ++v) use(v, vertices[v]);
}

// 256 places, mirrored, on a mesh of 67,200 vertices: 34 million if the brush reaches everything.
TEST(Brush, ReachesOnlySoMuchAtOnce) {
  const std::vector<studio::PaintPlace> grounds{
      {.key = "character.paint", .name = {}, .ground = ground_of(std::vector<double>(28, 0.0))}};
  ASSERT_EQ(grounds[0].ground->surface().vertices.size(), 67200u);
  const std::vector<std::array<double, 3>> places(256, {0.05, 0.1, 0.0});
  Brush brush = brush_of("_LAYER", 3.0f, 1000.0);
  EXPECT_FALSE(reaches_too_many(brush, grounds, places));
  brush.is_mirrored = true;
  EXPECT_TRUE(reaches_too_many(brush, grounds, places));
  EXPECT_FALSE(reaches_too_many(brush, grounds, std::span(places).first(128)));
  brush.radius = 0.05;
  EXPECT_FALSE(reaches_too_many(brush, grounds, places)) << "a small brush reaches little";
  std::vector<studio::PaintPlace> rigid = grounds;
  rigid[0].is_rigid = true;
  brush.radius = 1000.0;
  EXPECT_FALSE(reaches_too_many(brush, rigid, places)) << "nothing is painted there";
}

// Triangles without shared vertices are connected if they coincide; a sheet 5 mm away is not.
TEST(Brush, ReachesWhatHangsTogether) {
  const auto ground = ground_of({0.0, 0.005});
  Painting painting = blank(ground);
  const Vector3d place(0.003, 0.1, 0.0);
  painting.stamp(brush_of("_LAYER", 3.0f, 0.035), place, Vector3d::Zero());
  const std::vector<float> layer = painting.shown(*find_paint_kind("_LAYER"));
  std::size_t painted = 0;
  for_each(*ground, [&](std::size_t v, const Vector3d& p) {
    const bool is_near = p[2] == 0.0 && (p - place).norm() <= 0.035;
    EXPECT_EQ(layer[v], is_near ? 3.0f : 0.0f) << p.transpose();
    painted += is_near;
  });
  EXPECT_GT(painted, 100u);
}

TEST(Brush, ASmallOneReachesOnePlace) {
  const auto ground = ground_of({0.0});
  Painting painting = blank(ground);
  painting.stamp(brush_of("_RIGID", 1.0f, 0.0001), {0.0341, 0.1, 0.0}, Vector3d::Zero());
  const std::vector<float> rigid = painting.shown(*find_paint_kind("_RIGID"));
  for_each(*ground, [&](std::size_t v, const Vector3d& p) {
    EXPECT_EQ(rigid[v], (p - Vector3d(0.03, 0.1, 0.0)).norm() < 1e-9 ? 1.0f : 0.0f) << p.transpose();
  });
}

TEST(Brush, ObeysSymmetry) {
  const auto ground = ground_of({0.0});
  Painting painting = blank(ground);
  Brush brush = brush_of("_LAYER", 2.0f, 0.02);
  brush.is_mirrored = true;
  painting.stamp(brush, {0.05, 0.1, 0.0}, Vector3d::Zero());
  const std::vector<float> layer = painting.shown(*find_paint_kind("_LAYER"));
  std::set<std::pair<long, long>> left, right;
  for_each(*ground, [&](std::size_t v, const Vector3d& p) {
    if (layer[v] != 2.0f) return;
    (p[0] < 0.0 ? left : right).emplace(std::lround(std::abs(p[0]) / edge), std::lround(p[1] / edge));
  });
  EXPECT_EQ(left, right);
  EXPECT_GT(right.size(), 9u);
  // Nothing is painted if the other side has no surface.
  const auto far = ground_of({0.0});
  Painting beside = blank(far);
  beside.stamp(brush, {3.0, 0.1, 0.0}, Vector3d::Zero());
  EXPECT_LE(beside.paint().attributes.at(0).vertex.size(), 12u) << "at most one place on either edge";
}

// Moves values part of the way, less towards the rim, and closer with each stamp.
TEST(Brush, ObeysStrengthAndFalloff) {
  const auto ground = ground_of({0.0});
  const Vector3d place(0.0, 0.1, 0.0);
  const double radius = 0.045;
  for (const Falloff falloff : {Falloff::smooth, Falloff::linear, Falloff::constant}) {
    Painting painting = blank(ground);
    Brush brush = brush_of("_STIFFNESS", 0.2f, radius);
    brush.strength = 0.5;
    brush.falloff = falloff;
    painting.stamp(brush, place, Vector3d::Zero());
    const auto expected = [&](double way, double before) {
      const double left = 1.0 - way;
      const double share = falloff == Falloff::constant ? 1.0
                           : falloff == Falloff::linear ? left
                                                        : 3.0 * left * left - 2.0 * left * left * left;
      return before + 0.5 * share * (0.2 - before);
    };
    const std::vector<float> once = painting.shown(*brush.kind);
    painting.stamp(brush, place, Vector3d::Zero());
    const std::vector<float> twice = painting.shown(*brush.kind);
    for_each(*ground, [&](std::size_t v, const Vector3d& p) {
      const double way = (p - place).norm() / radius;
      if (std::abs(way - 1.0) < 1e-9) return;
      const double first = way < 1.0 ? expected(way, 1.0) : 1.0;
      EXPECT_NEAR(once[v], first, 1e-6) << p.transpose();  // float
      EXPECT_NEAR(twice[v], way < 1.0 ? expected(way, first) : 1.0, 1e-6) << p.transpose();
    });
  }
}

TEST(Brush, FibresRunAlongTheStrokeInTheSkin) {
  const auto ground = ground_of({0.0});
  Painting painting = blank(ground);
  Brush brush = brush_of("_FIBER", 0.0f, 0.02);
  brush.is_mirrored = true;
  brush.falloff = Falloff::constant;
  // A stroke direction that leaves the skin is projected onto it.
  painting.stamp(brush, {0.05, 0.1, 0.0}, {0.006, 0.008, 0.5});
  const std::vector<float> fibre = painting.shown(*brush.kind);
  std::size_t painted = 0;
  for_each(*ground, [&](std::size_t v, const Vector3d& p) {
    const Vector3d f(double{fibre[3 * v]}, double{fibre[3 * v + 1]}, double{fibre[3 * v + 2]});
    if (f.norm() == 0.0) return;
    ++painted;
    EXPECT_LT((f - Vector3d(p[0] > 0.0 ? 0.6 : -0.6, 0.8, 0.0)).norm(), 1e-6) << p.transpose();
  });
  EXPECT_GT(painted, 100u);
  // Fibres are undirected: the opposite stroke changes nothing.
  brush.is_mirrored = false;
  painting.stamp(brush, {0.05, 0.1, 0.0}, {-0.6, -0.8, 0.0});
  const std::vector<float> again = painting.shown(*brush.kind);
  for (std::size_t k = 0; k < fibre.size(); ++k) EXPECT_NEAR(again[k], fibre[k], 1e-6);
  // A stamp without direction, and one straight into the skin, change nothing.
  painting.stamp(brush, {0.05, 0.1, 0.0}, Vector3d::Zero());
  painting.stamp(brush, {0.05, 0.1, 0.0}, {0.0, 0.0, 1.0});
  EXPECT_EQ(painting.shown(*brush.kind), again);
}

// Erasing restores what the character's file has.
TEST(Brush, Erases) {
  std::vector<rig::PaintedAttribute> own{{"_LAYER", 1, {}}};
  own[0].values.assign(ground_of({0.0})->surface().vertices.size(), 2.0);
  const auto ground = ground_of({0.0}, own);
  Painting painting = blank(ground);
  const rig::PaintKind& kind = *find_paint_kind("_LAYER");
  EXPECT_TRUE(painting.has(kind));
  EXPECT_FALSE(painting.has(*find_paint_kind("_RIGID")));
  const std::vector<float> before = painting.shown(kind);
  EXPECT_EQ(before[0], 2.0f);
  Brush brush = brush_of("_LAYER", 0.0f, 0.05);
  painting.stamp(brush, {0.0, 0.1, 0.0}, Vector3d::Zero());
  EXPECT_NE(painting.shown(kind), before) << "0 means layers by depth, whatever the file has";
  EXPECT_FALSE(painting.paint().attributes.empty());
  brush.erases = true;
  brush.radius = 0.06;
  painting.stamp(brush, {0.0, 0.1, 0.0}, Vector3d::Zero());
  EXPECT_EQ(painting.shown(kind), before);
  EXPECT_TRUE(painting.paint().attributes.empty());
}

// Any result of strokes can be stored in a paint file, bit-exact.
TEST(Brush, WhatItLeavesIsAPaintFile) {
  const auto ground = ground_of({0.0});
  Painting painting = blank(ground);
  Brush fibre = brush_of("_FIBER", 0.0f, 0.05);
  fibre.strength = 0.3;
  Brush stiffness = brush_of("_STIFFNESS", 0.13f, 0.07);
  stiffness.strength = 0.7;
  for (int k = 0; k < 30; ++k) {
    const Vector3d place(0.003 * k - 0.04, 0.06 + 0.002 * k, 0.0);
    painting.stamp(fibre, place, {std::cos(0.3 * k), std::sin(0.3 * k), 0.1});
    painting.stamp(stiffness, place, Vector3d::Zero());
  }
  painting.stamp(brush_of("_RIGID", 1.0f, 0.02), {0.0, 0.1, 0.0}, Vector3d::Zero());
  painting.stamp(brush_of("_LAYER", 3.0f, 0.02), {0.0, 0.12, 0.0}, Vector3d::Zero());
  const std::string text = scene::paint_text(painting.paint());
  const Painting again(ground, scene::parse_paint(text, "paint", ground->surface()));
  for (const rig::PaintKind& kind : rig::paint_kinds()) {
    EXPECT_EQ(again.shown(kind), painting.shown(kind)) << kind.name;
    EXPECT_TRUE(again.has(kind)) << kind.name;
  }
  EXPECT_EQ(scene::paint_text(again.paint()), text);
}

}  // namespace
}  // namespace fascicle::tests
