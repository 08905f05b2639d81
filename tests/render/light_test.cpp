// Light and shadow in known configurations.
#include "host/render/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "host/render/render.h"
#include "tests/render/shapes.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3f;

const Vector3f white(1, 1, 1);

// Lit from directly above, a square shadows what is below it, and neither what is beside it nor itself.
TEST(ShadowMap, SquareShadesWhatLiesBelowIt) {
  const std::vector<render::Shape> shapes{square({0, 1, 0}, {0.5f, 0, 0}, {0, 0, -0.5f}, white)};
  const unsigned size = 512;
  const float radius = 1.5f, texel = 2.0f * radius / size;
  const render::ShadowMap map(shapes, Vector3f::UnitY(), {0, 0.5f, 0}, radius, size);
  for (float x = -1.2f; x <= 1.2f; x += 0.05f)
    for (float z = -1.2f; z <= 1.2f; z += 0.05f) {
      const float outside = std::max(std::fabs(x), std::fabs(z)) - 0.5f;
      if (std::fabs(outside) < 2.0f * texel) continue;  // the smoothed border
      EXPECT_EQ(map.visibility({x, 0, z}, Vector3f::UnitY()), outside > 0.0f ? 1.0f : 0.0f) << x << " " << z;
      if (outside < 0.0f) {
        EXPECT_EQ(map.visibility({x, 1, z}, Vector3f::UnitY()), 1.0f) << x << " " << z;
      }
    }
}

// A convex body never shadows a point that faces the lamp.
TEST(ShadowMap, SphereDoesNotShadeItsLitSide) {
  const render::Shape ball = sphere({0, 0, 0}, 1.0f, white);
  const std::vector<render::Shape> shapes{ball};
  const Vector3f towards = Vector3f(0.3f, 0.8f, 0.5f).normalized();
  const render::ShadowMap map(shapes, towards, Vector3f::Zero(), 1.02f, 1024);
  for (std::size_t k = 0; k < ball.positions.size(); k += 7) {
    const float cosine = ball.normals[k].dot(towards);
    // Near the terminator, texel size and bias matter.
    if (cosine > 0.1f) {
      EXPECT_EQ(map.visibility(ball.positions[k], ball.normals[k]), 1.0f) << k;
    }
    if (cosine < -0.2f) {
      EXPECT_EQ(map.visibility(ball.positions[k], ball.normals[k]), 0.0f) << k;
    }
  }
}

// A lamp above a map of one texel a metre, whose texel (i, j) has a plate above it: only points around its
// centre are in shadow, by their share of the texel, wherever it lies in the blocks of texels that the map
// groups.
TEST(ShadowMap, OneTexelShadesWhatIsNextToIt) {
  const unsigned size = 32;
  const float half = 0.5f * size;
  // The map's axes for a lamp above: columns along -z, rows along -x.
  const auto place = [&](float column, float row, float height) {
    return Vector3f(half - row - 0.5f, height, half - column - 0.5f);
  };
  for (const float i : {1.0f, 7.0f, 8.0f, 9.0f, 15.0f, 16.0f, 23.0f})
    for (const float j : {1.0f, 7.0f, 8.0f, 9.0f, 15.0f, 16.0f, 23.0f}) {
      const std::vector<render::Shape> shapes{square(place(i, j, 5.0f), {0.6f, 0, 0}, {0, 0, -0.6f}, white)};
      const render::ShadowMap map(shapes, Vector3f::UnitY(), Vector3f::Zero(), half, size);
      for (const float u : {-1.0f, -0.75f, -0.5f, 0.0f, 0.5f, 0.75f, 1.0f})
        for (const float v : {-1.0f, -0.75f, -0.5f, 0.0f, 0.5f, 0.75f, 1.0f})
          EXPECT_NEAR(map.visibility(place(i + u, j + v, 0.0f), Vector3f::UnitY()),
                      1.0f - (1.0f - std::fabs(u)) * (1.0f - std::fabs(v)), 1e-5f)  // float rounding
              << i << " " << j << " " << u << " " << v;
    }
}

// What is said of a patch of the floor holds at each of its points, and the sum over the lamps is the same.
TEST(ShadowMap, WhatIsSaidOfAPatchHoldsAtItsPoints) {
  const std::vector<render::Shape> shapes{sphere({0, 1, 0}, 0.6f, white),
                                          square({0.5f, 0.3f, 0}, {0.4f, 0, 0}, {0, 0, -0.4f}, white)};
  const auto lamps = render::studio_lamps(shapes, camera_on_z(5.0, 900.0, 960, 960), 1);
  const Vector3f up = Vector3f::UnitY();
  std::mt19937 random(7);
  const auto between = [&](float least, float most) {
    return std::uniform_real_distribution<float>(least, most)(random);
  };
  std::size_t whole = 0, none = 0, unknown = 0;
  for (int n = 0; n < 300; ++n) {
    // Small ones, as in a picture, and some that cover the body's shadow.
    const float side = n % 10 == 0 ? between(0.1f, 20.0f) : between(0.002f, 0.1f),
                skew = between(-side, side);
    const Vector3f corner(between(-2.0f, 2.0f), 0.0f, between(-2.0f, 2.0f)), u(side, 0, skew),
        v(-skew, 0, side);
    const std::array<Vector3f, 4> corners{corner, corner + u, corner + v, corner + u + v};
    const render::PatchLight patch = render::light_of_patch(lamps, corners, up);
    for (int p = 0; p < 20; ++p) {
      const Vector3f point = corner + between(0.0f, 1.0f) * u + between(0.0f, 1.0f) * v;
      // Sums of 92 floats in another order.
      EXPECT_NEAR(render::irradiance(lamps, patch, point, up).x(), render::irradiance(lamps, point, up).x(),
                  1e-5f);
    }
    for (const render::Lamp& lamp : lamps) {
      const render::ShadowMap::Seen seen = lamp.shadow.seen_of_patch(corners, up);
      whole += seen == render::ShadowMap::Seen::whole ? 1 : 0;
      none += seen == render::ShadowMap::Seen::none ? 1 : 0;
      unknown += seen == render::ShadowMap::Seen::unknown ? 1 : 0;
    }
  }
  // Each answer is given, and most of the lamps need not be asked again.
  EXPECT_GT(none, 500u);
  EXPECT_GT(whole, 10000u);
  EXPECT_LT(unknown, (whole + none) / 2);
  // Past the horizon nothing is known.
  const std::array<Vector3f, 4> endless{Vector3f::Zero(), Vector3f::UnitX(), Vector3f::UnitZ(),
                                        Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())};
  EXPECT_EQ(lamps[0].shadow.seen_of_patch(endless, up), render::ShadowMap::Seen::unknown);
}

TEST(StudioLamps, KeyComesFromTheUpperLeftOfTheCamera) {
  const std::vector<render::Shape> shapes{sphere({0, 0, 0}, 1.0f, white, 24)};
  for (const double azimuth : {0.0, 90.0, 215.0}) {
    render::Camera camera = camera_on_z(5.0, 100.0, 10, 10);
    camera.axes = render::camera_axes({azimuth, 10.0});
    const auto lamps = render::studio_lamps(shapes, camera, 1);
    const Vector3f right = camera.axes.row(0).cast<float>(), front = camera.axes.row(2).cast<float>();
    const auto light = [&](const Vector3f& normal) {
      return render::irradiance(lamps, normal.normalized(), normal.normalized()).x();
    };
    EXPECT_GT(light(front - right + Vector3f::UnitY()), 1.2f * light(front + right + Vector3f::UnitY()));
    EXPECT_GT(light(front + Vector3f::UnitY()), 1.5f * light(front - Vector3f::UnitY()));
    for (const render::Lamp& lamp : lamps) EXPECT_NEAR(lamp.towards.norm(), 1.0f, 1e-5f);  // float rounding
  }
}

// Shading uses the given normals, not just the triangles: with normals turned away from the key light, a
// plate is darker.
// A floor of 20 m in the body's shape, which shadow maps need not reach: the shadows are those of the body
// alone.
TEST(StudioLamps, HaveTheirTexelsForTheBody) {
  const render::Shape ball = sphere({0, 0, 0}, 1.0f, white, 32);
  render::Shape both = ball;
  const render::Shape floor = square({0, -3, 0}, {10, 0, 0}, {0, 0, -10}, white);
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  both.is_beside.assign(first, 0);
  for (std::size_t k = 0; k < floor.positions.size(); ++k) {
    both.positions.push_back(floor.positions[k]);
    both.normals.push_back(floor.normals[k]);
    both.colours.push_back(floor.colours[k]);
    both.is_beside.push_back(1);
  }
  for (const auto& t : floor.triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  const auto shades_of = [](const render::Shape& shape) {
    std::vector<float> shades;
    for (const render::Lamp& lamp : render::studio_lamps({&shape, 1}, camera_on_z(5.0, 2.0, 320, 240), 1))
      for (float x = -4.0f; x <= 4.0f; x += 0.05f)
        for (float z = -4.0f; z <= 4.0f; z += 0.05f)
          shades.push_back(lamp.shadow.visibility({x, -1.5f, z}, Vector3f::UnitY()));
    return shades;
  };
  const std::vector<float> alone = shades_of(ball);
  EXPECT_NE(std::count(alone.begin(), alone.end(), 0.0f), 0);
  EXPECT_TRUE(shades_of(both) == alone);
  // The control: a shape that says nothing of its floor has coarser shadows.
  both.is_beside.clear();
  EXPECT_FALSE(shades_of(both) == alone);
}

TEST(Render, BrightnessFollowsTheNormal) {
  const auto brightness = [](const Vector3f& normal) {
    render::Shape plate = square({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, {0.5f, 0.5f, 0.5f});
    plate.normals.assign(4, normal.normalized());
    const std::vector<render::Shape> shapes{plate};
    return int{render::render(shapes, camera_on_z(3.0, 40.0, 20, 20)).at(10, 10)[0]};
  };
  const int towards = brightness({-0.7f, 0.7f, 1}), straight = brightness({0, 0, 1}),
            away = brightness({0.7f, -0.7f, 1});
  EXPECT_GT(towards, straight + 5);
  EXPECT_GT(straight, away + 20);
}

// On a plain finish, white light scales a colour without tinting it, so that a legend's colour can be
// recognised.
TEST(Render, PlainFinishKeepsTheHue) {
  const Vector3f paint(0.6f, 0.3f, 0.15f);
  const std::vector<render::Shape> shapes{sphere({0, 0, 0}, 0.5f, paint, 32)};
  const render::Image image = render::render(shapes, camera_on_z(3.0, 150.0, 80, 80));
  const render::DepthImage depth = render::render_depth(shapes, camera_on_z(3.0, 150.0, 80, 80));
  const auto linear = [](std::uint8_t byte) {
    const double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  };
  std::size_t seen = 0;
  for (unsigned y = 20; y < 60; ++y)
    for (unsigned x = 20; x < 60; ++x) {
      if (depth.triangle[y * 80 + x] == render::no_triangle || std::hypot(x - 39.5, y - 39.5) > 20.0)
        continue;
      const std::uint8_t* pixel = image.at(x, y);
      const double light = linear(pixel[0]) / 0.6;
      EXPECT_LE(light, 1.0);
      // Half a byte's step is at most 1 % of these values.
      EXPECT_NEAR(linear(pixel[1]) / 0.3, light, 0.04 * light + 0.002);
      EXPECT_NEAR(linear(pixel[2]) / 0.15, light, 0.04 * light + 0.004);
      ++seen;
    }
  EXPECT_GT(seen, 1000u);
}

// The floor is paper except for shadow: dark under a ball that touches it, unchanged far away. Without a
// floor there is no shadow.
TEST(Render, FloorTakesShadowOnlyNearTheBody) {
  const std::vector<render::Shape> shapes{sphere({0, 0, 0}, 0.5f, white, 32)};
  render::Camera camera = camera_on_z(0.0, 120.0, 160, 120);
  camera.axes = render::camera_axes({0.0, 25.0});
  camera.eye = 6.0 * camera.axes.row(2).transpose();
  render::Backdrop floor, none;
  floor.ground = -0.5;
  const render::Image with = render::render(shapes, camera, floor),
                      without = render::render(shapes, camera, none);
  const Eigen::Vector3d under = camera.project({0.12, -0.5, 0.3});
  const auto x = static_cast<unsigned>(under.x()), y = static_cast<unsigned>(under.y());
  const render::DepthImage depth = render::render_depth(shapes, camera);
  unsigned below = y;
  while (depth.triangle[below * 160 + x] != render::no_triangle) ++below;
  EXPECT_LT(with.at(x, below + 1)[0] + 30, without.at(x, below + 1)[0]);
  EXPECT_NEAR(with.at(2, 110)[0], without.at(2, 110)[0],
              3);  // far from the ball, which still hides a little of the dome
}

}  // namespace
}  // namespace fascicle::tests
