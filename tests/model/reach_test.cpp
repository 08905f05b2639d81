#include "host/model/reach.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();

// A number just within the bound and the next float, for a unit that shortens the reach and one that does
// not.
TEST(Reach, IsTheShorterOfMetresAndUnits) {
  for (const auto& [unit, most] : {std::pair(1.0, 1e9f), std::pair(0.25, 1e9f), std::pair(4.0, 2.5e8f)}) {
    SCOPED_TRACE(unit);
    EXPECT_TRUE(model::is_in_reach(std::vector<float>{0.0f, most, -most}, unit));
    EXPECT_FALSE(model::is_in_reach(std::vector<float>{0.0f, std::nextafter(most, infinity)}, unit));
    EXPECT_FALSE(model::is_in_reach(std::vector<float>{std::nextafter(-most, -infinity)}, unit));
  }
}

TEST(Reach, EndsBeforeWhatIsNotFinite) {
  for (const float x : {nan, infinity, -infinity})
    EXPECT_FALSE(model::is_in_reach(std::vector<float>{1.0f, x, 1.0f}, 1.0)) << x;
  EXPECT_TRUE(model::is_in_reach(std::vector<float>{}, 1.0));
}

TEST(Reach, OfOrigins) {
  EXPECT_TRUE(model::is_in_reach(std::array<double, 3>{1e9, -1e9, 0.0}));
  for (const double x : {1.0000001e9, -1.0000001e9, double{nan}, double{infinity}})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<double, 3> origin{};
      origin[axis] = x;
      EXPECT_FALSE(model::is_in_reach(origin)) << x;
    }
}

}  // namespace
}  // namespace fascicle::tests
