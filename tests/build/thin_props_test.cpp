// Warnings of props that have no vertex inside, on bars with known volumes and areas.
#include "host/build/thin_props.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
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

// The share of a bar's volume in tetrahedra with all corners on one of its sides.
double share_without_inside(const scene::Bar& bar) {
  const mesh::TetMesh mesh = build::make_bar(bar, "test");
  const auto is_outside = [&](std::uint32_t i) {
    for (int axis = 0; axis < 3; ++axis)
      if (mesh.vertices[i][axis] < 1e-9 || mesh.vertices[i][axis] > bar.size[axis] - 1e-9) return true;
    return false;
  };
  double thin = 0.0, whole = 0.0;
  for (const auto& t : mesh.tetrahedra) {
    const Vector3d& a = mesh.vertices[t[0]];
    const double volume =
        std::abs((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).dot(mesh.vertices[t[3]] - a));
    whole += volume;
    if (std::all_of(t.begin(), t.end(), is_outside)) thin += volume;
  }
  return thin / whole;
}

// A plate that is thin throughout beside a cube of 1 m3: a little more or less of the plate decides.
TEST(ThinProps, AreThoseWithMostOfTheirVolumeOutside) {
  const scene::Bar cube{.size = {1.0, 1.0, 1.0}, .vertices = {6, 6, 6}};
  const double of_cube = share_without_inside(cube);
  ASSERT_LT(of_cube, 0.45);
  for (const double share : {0.48, 0.52}) {
    // share = (plate + of_cube) / (plate + 1)
    const double plate = (share - of_cube) / (1.0 - share);
    build::Body body;
    body.mesh = build::make_bar(cube, "test");
    const mesh::TetMesh other = build::make_bar({.size = {plate, 1.0, 1.0}, .vertices = {2, 6, 6}}, "test");
    const auto first = static_cast<std::uint32_t>(body.mesh.vertices.size());
    for (const Vector3d& p : other.vertices) body.mesh.vertices.push_back(p + Vector3d(2.0, 0.0, 0.0));
    for (const auto& t : other.tetrahedra)
      body.mesh.tetrahedra.push_back({first + t[0], first + t[1], first + t[2], first + t[3]});
    build::Report found;
    build::warn_of_thin_prop(body, "test", found);
    ASSERT_EQ(!found.warnings.empty(), share > 0.5) << share;
    if (found.warnings.empty()) continue;
    EXPECT_EQ(found.warnings[0].text.find("52 % of this prop's volume"), 0u) << found.warnings[0].text;
  }
}

}  // namespace
}  // namespace fascicle::tests
