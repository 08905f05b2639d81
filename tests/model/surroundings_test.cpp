// The surroundings of a body in a character's file, which pictures do not fit.
#include "host/model/surroundings.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/bar_and_boxes.h"

namespace fascicle::tests {
namespace {

// Per box, whether all or none of its eight vertices are of the surroundings.
std::vector<int> boxes_beside(const model::Model& model) {
  const std::vector<char> is_beside = model::surroundings_of(model).surface;
  std::vector<int> result;
  for (std::size_t first = 0; first < is_beside.size(); first += 8) {
    const auto count = std::count(is_beside.begin() + static_cast<std::ptrdiff_t>(first),
                                  is_beside.begin() + static_cast<std::ptrdiff_t>(first) + 8, 1);
    EXPECT_TRUE(count == 0 || count == 8);
    result.push_back(count == 8 ? 1 : 0);
  }
  return result;
}

const Box floor_of_4_m{{-2, -0.01f, -2}, {2, 0, 2}}, wall_of_10_m{{-5, 0, -5}, {5, 10, -4.9f}};

TEST(Surroundings, AreFloorsAndWallsThatTheSkeletonMoves) {
  EXPECT_EQ(boxes_beside(bar_and_boxes({})), (std::vector<int>{0}));
  EXPECT_EQ(boxes_beside(bar_and_boxes({floor_of_4_m})), (std::vector<int>{0, 1}));
  EXPECT_EQ(boxes_beside(bar_and_boxes({wall_of_10_m, floor_of_4_m})), (std::vector<int>{0, 1, 1}));
  // Of a room, each is compared with the body alone.
  const Box wall_of_5_m{{-2, 0.1f, -2.1f}, {2, 3, -2.05f}}, ceiling{{-2, 3.1f, -2}, {2, 3.15f, 2}};
  EXPECT_EQ(boxes_beside(bar_and_boxes({floor_of_4_m, wall_of_5_m, ceiling})),
            (std::vector<int>{0, 1, 1, 1}));
}

TEST(Surroundings, AreCarriedByVerticesOfTheModel) {
  const model::Model model = bar_and_boxes({floor_of_4_m});
  const model::Surroundings beside = model::surroundings_of(model);
  ASSERT_EQ(beside.vertices.size(), model.vertex_count);
  EXPECT_EQ(std::count(beside.vertices.begin(), beside.vertices.end(), 1), 8);
  EXPECT_EQ(std::count(beside.vertices.end() - 8, beside.vertices.end(), 1), 8);
}

TEST(Surroundings, DoNotDependOnVerticesThatNoTriangleHas) {
  model::Model stray = bar_and_boxes({floor_of_4_m});
  const std::vector<char> before = model::surroundings_of(stray).surface;
  const std::uint32_t vertex = stray.vertex_count++;
  stray.rest.insert(stray.rest.end(), {1000.0f, 0.0f, 0.0f});
  stray.tag.push_back(0U);
  stray.surface_vertex.insert(stray.surface_vertex.end(), 4, vertex);
  stray.surface_weight.insert(stray.surface_weight.end(), {1.0f, 0.0f, 0.0f, 0.0f});
  std::vector<char> after = model::surroundings_of(stray).surface;
  EXPECT_EQ(after.back(), 0);
  after.pop_back();
  EXPECT_EQ(after, before);
}

TEST(Surroundings, AreNoFleshNoRodsNoBlocksAndNoSmallSheets) {
  model::Model soft = bar_and_boxes({floor_of_4_m});
  soft.tag.back() = 0;
  EXPECT_EQ(boxes_beside(soft), (std::vector<int>{0, 0}));
  const Box spear{{0, 0, 0}, {4, 0.02f, 0.02f}}, block{{-2, -1, -2}, {2, 0, 2}};
  const Box banner{{0, 0, 0}, {0.8f, 2.0f, 0.01f}};
  for (const Box& box : {spear, block, banner})
    EXPECT_EQ(boxes_beside(bar_and_boxes({box})), (std::vector<int>{0, 0}));
}

// Wings are beside the body, however large, and a floor below it.
TEST(Surroundings, AreNoWings) {
  const Box left{{-4, 0.25f, 0}, {-0.1f, 0.26f, 3}}, right{{1.1f, 0.25f, 0}, {5, 0.26f, 3}};
  EXPECT_EQ(boxes_beside(bar_and_boxes({left, right})), (std::vector<int>{0, 0, 0}));
}

TEST(Surroundings, AreNoPartOfTheExtent) {
  EXPECT_DOUBLE_EQ(model::extent(bar_and_boxes({floor_of_4_m})), 1.0);
  // The control: a block is.
  EXPECT_NEAR(model::extent(bar_and_boxes({{{-2, -1, -2}, {2, 0, 2}}})), 4.0, 1e-5);
}

// A character without flesh, such as a robot, may consist of sheets.
TEST(Surroundings, AreBesideFlesh) {
  model::Model robot = bar_and_boxes({floor_of_4_m});
  std::fill(robot.tag.begin(), robot.tag.end(), shader::tag_kinematic);
  EXPECT_EQ(boxes_beside(robot), (std::vector<int>{0, 0}));
}

}  // namespace
}  // namespace fascicle::tests
