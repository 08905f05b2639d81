// The surroundings of a body in a character's file, which pictures do not fit.
#include "host/render/model_surface.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/bar_and_boxes.h"

namespace fascicle::tests {
namespace {

// Per box, whether all or none of its eight vertices are of the surroundings.
std::vector<int> surroundings_of(const model::Model& model) {
  const std::vector<char> is_beside = render::is_of_surroundings(model);
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
  EXPECT_EQ(surroundings_of(bar_and_boxes({})), (std::vector<int>{0}));
  EXPECT_EQ(surroundings_of(bar_and_boxes({floor_of_4_m})), (std::vector<int>{0, 1}));
  EXPECT_EQ(surroundings_of(bar_and_boxes({wall_of_10_m, floor_of_4_m})), (std::vector<int>{0, 1, 1}));
}

TEST(Surroundings, AreNoFleshNoRodsNoBlocksAndNoSmallSheets) {
  model::Model soft = bar_and_boxes({floor_of_4_m});
  soft.tag.back() = 0;
  EXPECT_EQ(surroundings_of(soft), (std::vector<int>{0, 0}));
  const Box spear{{0, 0, 0}, {4, 0.02f, 0.02f}}, block{{-2, -1, -2}, {2, 0, 2}};
  const Box banner{{0, 0, 0}, {0.8f, 1.2f, 0.01f}};
  for (const Box& box : {spear, block, banner})
    EXPECT_EQ(surroundings_of(bar_and_boxes({box})), (std::vector<int>{0, 0}));
}

TEST(Surroundings, AreNotAllThatThereIs) {
  model::Model sheet = bar_and_boxes({floor_of_4_m});
  // Without the bar, the sheet is the body.
  sheet.surface_vertex.erase(sheet.surface_vertex.begin(), sheet.surface_vertex.begin() + 32);
  sheet.surface_weight.erase(sheet.surface_weight.begin(), sheet.surface_weight.begin() + 32);
  sheet.surface_triangle.erase(sheet.surface_triangle.begin(), sheet.surface_triangle.begin() + 18);
  for (std::uint32_t& corner : sheet.surface_triangle) corner -= 8;
  EXPECT_EQ(surroundings_of(sheet), (std::vector<int>{0}));
}

}  // namespace
}  // namespace fascicle::tests
