// Warnings of props that have no vertex inside, on bars with known volumes and areas.
#include "host/build/thin_props.h"

#include <gtest/gtest.h>

#include "host/build/bar.h"

namespace fascicle::tests {
namespace {

using scene::Vector3d;

std::string warning_of(const scene::Bar& bar) {
  build::Body body;
  body.mesh = build::make_bar(bar, "test");
  build::Report found;
  build::warn_of_thin_prop(body, "test", found);
  return found.warnings.empty() ? "" : found.warnings[0].text;
}

TEST(ThinProps, APlateWithoutAVertexInsideIsToldHowFineItMustBe) {
  const std::string text = warning_of({.size = {0.1, 0.4, 0.4}, .vertices = {2, 5, 5}});
  EXPECT_EQ(text.find("100 % of this prop's volume has no vertex inside"), 0u) << text;
  // Volume 0.016 over area 0.48, rounded down to two digits.
  EXPECT_NE(text.find("`resolution` of 0.033 m or less"), std::string::npos) << text;
}

// The share does not depend on the size, from crumbs to houses.
TEST(ThinProps, AreNotThoseWithVerticesInside) {
  for (const double size : {0.01, 0.2, 10.0}) {
    EXPECT_EQ(warning_of({.size = Vector3d::Constant(size), .vertices = {6, 6, 6}}), "") << size;
    EXPECT_NE(warning_of({.size = Vector3d::Constant(size), .vertices = {2, 6, 6}}), "") << size;
  }
}

}  // namespace
}  // namespace fascicle::tests
