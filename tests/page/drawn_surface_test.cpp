#include "host/page/drawn_surface.h"

#include <algorithm>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/model/model.h"

namespace fascicle::page {
namespace {

// Two tetrahedra of two layers that share a face.
model::Model two_tetrahedra() {
  model::Model model;
  model.vertex_count = 5;
  model.rest = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  model.tag = {0, 0, 0, 0, 1};
  model.layers.resize(2);
  model.tetrahedron = {0, 1, 2, 3, 1, 2, 3, 4};
  return model;
}

TEST(DrawnSurface, OfTetrahedraIsTheirOutside) {
  const DrawnSurface surface = drawn_surface(two_tetrahedra());
  EXPECT_TRUE(surface.is_tetrahedra);
  ASSERT_EQ(surface.triangles.size(), 6u);  // 8 faces minus the shared one, counted twice
  for (const auto& triangle : surface.triangles) {
    std::set<std::uint32_t> corners, normals;
    for (const std::uint32_t vertex : triangle) {
      corners.insert(surface.source[vertex]);
      normals.insert(surface.normal[vertex]);
    }
    EXPECT_NE(corners, (std::set<std::uint32_t>{1, 2, 3}));
    EXPECT_EQ(normals.size(), 1u) << "a flat face has one normal";
  }
}

TEST(DrawnSurface, OfNothingIsRefused) {
  EXPECT_THROW(drawn_surface(model::Model{}), base::BakeError);
}

TEST(GroupTriangles, KeepsEveryTriangleWithItsCornersAndTheirValues) {
  DrawnSurface surface = drawn_surface(two_tetrahedra());
  const auto corners = [](const DrawnSurface& of) {
    std::multiset<std::vector<std::uint32_t>> all;
    for (const auto& triangle : of.triangles) {
      std::vector<std::uint32_t> one;
      for (const std::uint32_t vertex : triangle) {
        one.push_back(of.source[vertex]);
        one.push_back(of.layer[vertex]);
      }
      all.insert(one);
    }
    return all;
  };
  const auto before = corners(surface);
  const std::vector<std::uint32_t> numbers{7, 2, 7, 0, 2, 7};
  const std::vector<TriangleGroup> groups = group_triangles(surface, numbers);
  EXPECT_EQ(corners(surface), before);
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[0].number, 0u);
  EXPECT_EQ(groups[0].count, 1u);
  EXPECT_EQ(groups[2].number, 7u);
  EXPECT_EQ(groups[2].count, 3u);
  std::uint32_t next = 0;
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t vertex : triangle) {
      EXPECT_LE(vertex, next) << "vertices are numbered in order of first use";
      next = std::max(next, vertex + 1);
    }
}

}  // namespace
}  // namespace fascicle::page
