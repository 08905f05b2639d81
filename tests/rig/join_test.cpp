#include "host/rig/join.h"

#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests::join_test {
namespace {

rig::Character triangle() {
  rig::Character one;
  one.skeleton.resize(1);
  one.surface.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  one.surface.triangles = {{0, 1, 2}};
  one.joints.resize(3);
  one.weights.resize(3, {1.0});
  return one;
}

std::vector<double> values_of(const rig::Character& character, const std::string& name) {
  for (const rig::PaintedAttribute& painted : character.painted)
    if (painted.name == name) return painted.values;
  ADD_FAILURE() << name << " is missing";
  return {};
}

// Flesh that nobody painted is as stiff as its layer, whichever character comes first.
TEST(Join, CharactersWithoutPaintHaveWhatUnpaintedFleshHas) {
  rig::Character painted = triangle();
  painted.painted = {{"_STIFFNESS", 1, {0.5, 0.25, 2.0}}, {"_LAYER", 1, {1.0, 2.0, 3.0}}};
  const rig::Character plain = triangle();
  const rig::Placed first{.name = "painted", .character = &painted},
      second{.name = "plain", .character = &plain};
  const rig::Character after = rig::joined(std::vector<rig::Placed>{first, second});
  EXPECT_EQ(values_of(after, "_STIFFNESS"), (std::vector<double>{0.5, 0.25, 2.0, 1.0, 1.0, 1.0}));
  EXPECT_EQ(values_of(after, "_LAYER"), (std::vector<double>{1.0, 2.0, 3.0, 0.0, 0.0, 0.0}));
  const rig::Character before = rig::joined(std::vector<rig::Placed>{second, first});
  EXPECT_EQ(values_of(before, "_STIFFNESS"), (std::vector<double>{1.0, 1.0, 1.0, 0.5, 0.25, 2.0}));
  EXPECT_EQ(values_of(before, "_LAYER"), (std::vector<double>{0.0, 0.0, 0.0, 1.0, 2.0, 3.0}));
}

}  // namespace
}  // namespace fascicle::tests::join_test
