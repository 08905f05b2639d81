// Sheets, rods and blocks.
#include "host/base/flat.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

using Points = std::vector<std::array<double, 3>>;

// The corners of a box, and `more` points within its upper face, turned about two axes and moved.
Points box(double width, double depth, double height, int more = 0) {
  Points points;
  for (const double x : {0.0, width})
    for (const double y : {0.0, height})
      for (const double z : {0.0, depth}) points.push_back({x, y, z});
  for (int k = 0; k < more; ++k) points.push_back({width * k / more, height, depth * (k % 7) / 7.0});
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (auto& p : points) {
    p = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    p = {p[0] + 3.0, c * p[1] - s * p[2] + 5.0, s * p[1] + c * p[2]};
  }
  return points;
}

TEST(Flat, SheetsAreAndRodsAndBlocksAreNot) {
  EXPECT_TRUE(base::is_flat(box(4.0, 4.0, 0.0)));
  EXPECT_TRUE(base::is_flat(box(4.0, 4.0, 0.1)));
  EXPECT_TRUE(base::is_flat(box(4.0, 1.0, 0.05)));
  EXPECT_FALSE(base::is_flat(box(4.0, 4.0, 0.5)));
  EXPECT_FALSE(base::is_flat(box(4.0, 0.2, 0.02)));
  EXPECT_FALSE(base::is_flat(box(1.0, 1.0, 1.0)));
}

TEST(Flat, DoesNotDependOnHowDenselyThePointsLie) {
  for (const double height : {0.1, 0.5})
    EXPECT_EQ(base::is_flat(box(4.0, 4.0, height)), base::is_flat(box(4.0, 4.0, height, 1000))) << height;
}

TEST(Flat, DoesNotDependOnWhichPointComesFirst) {
  for (const double height : {0.1, 0.5}) {
    Points points = box(4.0, 4.0, height);
    const bool is_flat = base::is_flat(points);
    std::array<double, 3> middle{0, 0, 0};
    for (const auto& p : points)
      for (std::size_t a = 0; a < 3; ++a) middle[a] += p[a] / static_cast<double>(points.size());
    points.insert(points.begin(), middle);
    EXPECT_EQ(base::is_flat(points), is_flat) << height;
  }
}

TEST(Flat, NeitherIsWhatHasNoArea) {
  EXPECT_FALSE(base::is_flat({}));
  EXPECT_FALSE(base::is_flat(Points{{1, 2, 3}}));
  EXPECT_FALSE(base::is_flat(Points{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}));
  EXPECT_FALSE(base::is_flat(Points{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}));
  EXPECT_FALSE(base::is_flat(Points{{0, 0, 0}, {NAN, 1, 1}, {2, 2, 3}}));
}

}  // namespace
}  // namespace fascicle::tests
