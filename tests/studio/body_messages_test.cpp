// Messages that describe a body, of a model made for the purpose.
#include "host/studio/body_messages.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/studio/decoded.h"
#include "tests/support/bar_and_boxes.h"

namespace fascicle::tests {
namespace {

TEST(BodyMessages, BoundsAndCameraLeaveOutFloors) {
  const model::Model plain = bar_and_boxes({});
  const model::Model beside = bar_and_boxes({{{-4.0f, -0.02f, -4.0f}, {4.0f, 0.0f, 4.0f}}});
  const auto arrays = [](const model::Model& model) { return studio::array_messages({model}, {}, 1, {}); };
  const auto surroundings = [&](const model::Model& model) {
    std::vector<std::uint32_t> found;
    for (const studio::ArrayMessage& array : arrays(model))
      if (array.name == "surface.surroundings") found = decode_array(*array.bytes).numbers;
    return found;
  };
  EXPECT_EQ(surroundings(plain), std::vector<std::uint32_t>());
  EXPECT_EQ(surroundings(beside),
            (std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1}));
  const auto bounds = [&](const model::Model& model) {
    return studio::body_json({model}, {}, 1, arrays(model))["bounds"];
  };
  EXPECT_EQ(bounds(beside), bounds(plain));
  EXPECT_EQ(bounds(plain), studio::Json::parse("[[0, 0, 0], [1, 0.5, 0.5]]"));
}

}  // namespace
}  // namespace fascicle::tests
