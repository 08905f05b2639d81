// Pixels compared with closed forms: silhouettes, depths, cameras, colours, and the PNG as libpng reads it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "host/render/annotate.h"
#include "host/render/colour.h"
#include "host/render/png.h"
#include "host/render/render.h"
#include "tests/render/shapes.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using render::Camera;
using render::Image;

const Vector3f red = render::colour(0xb8433f);

std::size_t covered(const render::DepthImage& image) {
  return static_cast<std::size_t>(std::count_if(image.triangle.begin(), image.triangle.end(),
                                                [](std::uint32_t t) { return t != render::no_triangle; }));
}

// A sphere's outline from distance d is a circle of radius f R / sqrt(d^2 - R^2).
TEST(Picture, SpheresSilhouetteHasTheAreaOfItsCircle) {
  const double radius = 0.5, distance = 3.0, focal = 400.0;
  const std::vector<render::Shape> shapes{sphere(Vector3f::Zero(), 0.5f, red)};
  const render::DepthImage image = render::render_depth(shapes, camera_on_z(distance, focal, 321, 241));
  const double circle = focal * radius / std::sqrt(distance * distance - radius * radius);
  // Pixel centres inside a convex outline: off by at most the pixels that the outline touches. Its length
  // bounds their number, and that bound is seldom half reached.
  EXPECT_NEAR(static_cast<double>(covered(image)), std::numbers::pi * circle * circle,
              2.0 * std::numbers::pi * circle);
  for (unsigned y = 0; y < image.height; ++y)
    for (unsigned x = 0; x < image.width; ++x) {
      const double from_center = std::hypot(x + 0.5 - 160.5, y + 0.5 - 120.5);
      if (std::fabs(from_center - circle) < 1.0) continue;  // one pixel's border
      EXPECT_EQ(image.triangle[y * image.width + x] != render::no_triangle, from_center < circle)
          << x << " " << y;
    }
}

TEST(Picture, SpheresDepthIsWhereTheRayMeetsIt) {
  const double radius = 0.5, distance = 3.0, focal = 400.0;
  const std::vector<render::Shape> shapes{sphere(Vector3f::Zero(), 0.5f, red)};
  const Camera camera = camera_on_z(distance, focal, 321, 241);
  const render::DepthImage image = render::render_depth(shapes, camera);
  std::size_t seen = 0;
  for (unsigned y = 0; y < image.height; ++y)
    for (unsigned x = 0; x < image.width; ++x) {
      const Vector3d ray = camera.ray(x + 0.5, y + 0.5);  // its third component is -1
      const double a = ray.squaredNorm(), b = distance * ray.z(), c = distance * distance - radius * radius;
      const double root = b * b - a * c;
      // Flat patches are up to 1.5e-4 radius inside. At half the outline's radius that is twice as much along
      // the ray, and unbounded at the rim, so skip steep places.
      if (root < 0.3 * radius * radius) continue;
      EXPECT_NEAR(image.depth[y * image.width + x], (-b - std::sqrt(root)) / a, 4e-4 * radius)
          << x << " " << y;
      ++seen;
    }
  EXPECT_GT(seen, 5000u);
}

// Two triangles with a common side leave no gap, and the nearer square hides the farther one.
TEST(Picture, SquaresCoverEachPixelCentreWithinOnceAndTheNearerWins) {
  const Camera camera = camera_on_z(2.0, 100.0, 120, 100);
  const std::vector<render::Shape> shapes{
      square({0, 0, 0}, {0.5f, 0, 0}, {0, 0.4f, 0}, red),
      square({0, 0, 0.4f}, {0.2f, 0, 0}, {0, 0.2f, 0}, red),
      square({0, 0, -1.0f}, {0.2f, 0, 0}, {0, 0.2f, 0}, red),  // hidden
  };
  const render::DepthImage image = render::render_depth(shapes, camera);
  // 100 / 2 x 1 m by 0.8 m: 50 x 40 pixels, with sides on pixel borders.
  EXPECT_EQ(covered(image), 2000u);
  // 100 / 1.6 x 0.4 m: 25 x 25, from 47.5 to 72.5 across and from 37.5 to 62.5 down. A pixel centre on a side
  // belongs to one of the two neighbours.
  std::size_t front = 0;
  for (std::size_t k = 0; k < image.depth.size(); ++k) {
    if (image.triangle[k] == 2 || image.triangle[k] == 3) {
      ++front;
      EXPECT_NEAR(image.depth[k], 1.6f, 1e-6f);  // a float's rounding
    } else if (image.triangle[k] != render::no_triangle) {
      EXPECT_LT(image.triangle[k], 2u);
      EXPECT_NEAR(image.depth[k], 2.0f, 1e-6f);
    }
  }
  EXPECT_EQ(front, 625u);
}

// A vertical edge k/16 into a pixel covers 1 - k/16 of it: the samples are in sixteen columns and rows.
TEST(Picture, EdgesAreMixedByArea) {
  for (int k = 0; k <= 16; ++k) {
    const float shift = static_cast<float>(k) / 16.0f;
    // In pixels of 1 cm: from 22 + shift to 42 + shift, both across and up.
    render::Shape panel = square({0.01f * shift, 0.01f * shift, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {1, 1, 1});
    panel.finish = render::Finish::ink;
    const std::vector<render::Shape> shapes{panel};
    render::Backdrop black;
    black.top = black.bottom = Vector3f::Zero();
    const Image image = render::render(shapes, camera_on_z(1.0, 100.0, 64, 64), black, 1);
    const auto light = [&](unsigned x, unsigned y) {
      return render::linear_of_srgb(image.at(x, y)[1] / 255.0f);
    };
    // Half a byte's step is at most 0.0045 in linear light.
    EXPECT_NEAR(light(22, 32), 1.0f - shift, 0.005f) << k;
    EXPECT_NEAR(light(42, 32), shift, 0.005f) << k;
    EXPECT_NEAR(light(32, 41), 1.0f - shift, 0.005f) << k;
    EXPECT_NEAR(light(32, 21), shift, 0.005f) << k;
    EXPECT_EQ(light(32, 32), 1.0f);
    EXPECT_EQ(light(20, 32), 0.0f);
  }
}

TEST(Picture, ThreadsAndRepetitionChangeNoByte) {
  const std::vector<render::Shape> shapes{sphere({0, 0, 0}, 0.5f, red, 32),
                                          square({0, -0.6f, 0}, {0.8f, 0, 0}, {0, 0, -0.8f}, red)};
  // The last band and the last patch of each are only partly in the picture.
  const Camera camera = camera_on_z(4.0, 150.0, 123, 90);
  render::Backdrop backdrop;
  backdrop.ground = -0.6;
  const Image one = render::render(shapes, camera, backdrop, 1);
  EXPECT_EQ(render::render(shapes, camera, backdrop, 8).pixels, one.pixels);
  EXPECT_EQ(render::render(shapes, camera, backdrop, 3).pixels, one.pixels);
  EXPECT_EQ(render::encode_png(one), render::encode_png(one));
}

// Triangles that lie behind the camera, are not finite or are degenerate are left out; the rest is drawn.
TEST(Picture, TrianglesThatCannotBeDrawnAreLeftOut) {
  render::Shape shape = square({0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, red);
  shape.positions.insert(shape.positions.end(),
                         {{0, 0, 5}, {1e30f, 0, 0}, {std::nanf(""), 0, 0}, {0, 0, 0}, {1, 0, 3}, {0, 1, 2}});
  shape.normals.resize(10, Vector3f::UnitZ());
  shape.colours.resize(10, red);
  shape.triangles.insert(shape.triangles.end(), {{4, 8, 9}, {0, 1, 5}, {0, 1, 6}, {0, 2, 7}});
  const std::vector<render::Shape> shapes{shape};
  const render::DepthImage image = render::render_depth(shapes, camera_on_z(2.0, 100.0, 40, 40));
  EXPECT_EQ(covered(image), 100u);
  EXPECT_NO_THROW(render::render(shapes, camera_on_z(2.0, 100.0, 40, 40)));
}

// A floor that reaches far past the camera on all sides, seen from 1 m above it, level and sloping: each
// pixel whose ray meets it shows it at that depth, and no other does.
TEST(Picture, AFloorThatReachesBehindTheCameraIsDrawnWhereRaysMeetIt) {
  const Camera camera = camera_on_z(0.0, 100.0, 121, 91);
  for (const float slope : {0.0f, 0.1f, -0.2f})
    for (const float reach : {4.0f, 1000.0f, 3e6f}) {
      const Vector3f across(reach, 0, 0), along(0, -slope * reach, -reach);
      const std::vector<render::Shape> shapes{square({0, -1, 0}, across, along, red)};
      const render::DepthImage image = render::render_depth(shapes, camera);
      std::size_t seen = 0;
      for (unsigned y = 0; y < image.height; ++y)
        for (unsigned x = 0; x < image.width; ++x) {
          const Vector3d ray = camera.ray(x + 0.5, y + 0.5);  // its third component is -1
          // y = -1 + slope z on the floor
          const double depth = -1.0 / (ray.y() + double{slope});
          const double across_share = std::fabs(ray.x()) * depth / double{reach},
                       along_share = depth / double{reach};
          const std::size_t pixel = y * image.width + x;
          const bool is_drawn = image.triangle[pixel] != render::no_triangle;
          // Skip the pixels of its border and of the horizon.
          if (std::fabs(ray.y() + double{slope}) < 0.02 || std::fabs(across_share - 1.0) < 0.05 ||
              std::fabs(along_share - 1.0) < 0.05)
            continue;
          const bool is_met = depth > 0.0 && across_share < 1.0 && along_share < 1.0;
          EXPECT_EQ(is_drawn, is_met) << slope << " " << reach << ": " << x << " " << y;
          if (!is_drawn || !is_met) continue;
          // Corners are rounded to 1/256 pixel. At 0.02 below the horizon, 2 pixels, that is a 500th.
          EXPECT_NEAR(image.depth[pixel] / depth, 1.0, 0.004)
              << slope << " " << reach << ": " << x << " " << y;
          ++seen;
        }
      EXPECT_GT(seen, 1000u) << slope << " " << reach;
    }
}

// The colour at a place of the floor is the same whether a corner lies behind the camera or not.
TEST(Picture, APieceOfATriangleKeepsItsColours) {
  const auto picture = [](float behind) {
    render::Shape floor;
    floor.finish = render::Finish::ink;
    // Red grows with z, green with x.
    for (const auto& [x, z] : {std::pair{-6.0f, behind}, {6.0f, behind}, {6.0f, -9.0f}, {-6.0f, -9.0f}}) {
      floor.positions.emplace_back(x, -1.0f, z);
      floor.colours.emplace_back((z + 9.0f) / 20.0f, (x + 6.0f) / 12.0f, 0.2f);
    }
    floor.normals.assign(4, Vector3f::UnitY());
    floor.triangles = {{0, 1, 2}, {0, 2, 3}};
    const std::vector<render::Shape> shapes{floor};
    return render::render(shapes, camera_on_z(0.0, 100.0, 80, 60), {}, 1);
  };
  // In front of the camera, and 9 m behind it.
  const Image whole = picture(-0.05f), cut = picture(9.0f);
  std::size_t floor = 0;
  for (std::size_t k = 0; k < whole.pixels.size(); ++k) {
    // Rounding of places and of weights to float.
    EXPECT_NEAR(whole.pixels[k], cut.pixels[k], 2) << k;
    floor += k % 3 == 2 && whole.pixels[k] == render::byte_of_linear(0.2f) ? 1u : 0u;
  }
  EXPECT_GT(floor, 80u * 15u);
}

TEST(CameraFit, HoldsEveryPointAndTouchesTheMargin) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (const render::View view : {render::View{0, 0}, {35, 10}, {90, 6}, {200, -40}, {-75, 80}}) {
    render::CameraFit fit(view, 300, 200);
    std::vector<Vector3d> points;
    for (int k = 0; k < 50; ++k) {
      points.emplace_back(3.0 * place(random) + 10.0, place(random), 2.0 * place(random));
      fit.include(points.back());
    }
    const Camera camera = fit.camera();
    double most = 0.0;
    for (const Vector3d& p : points) {
      const Vector3d q = camera.project(p);
      EXPECT_GT(q.z(), 0.0);
      most = std::max({most, std::fabs(q.x() - 150.0) / 150.0, std::fabs(q.y() - 100.0) / 100.0});
    }
    EXPECT_NEAR(most, 0.9, 1e-9);  // with a margin of a tenth; double rounding
    // The ray through a projected point leads to the point.
    const Vector3d q = camera.project(points[0]);
    EXPECT_NEAR((camera.eye + q.z() * camera.ray(q.x(), q.y()) - points[0]).norm(), 0.0, 1e-9);
  }
}

TEST(CameraFit, ViewsLookFromWhereTheySay) {
  const auto from = [](const render::View& view) { return Vector3d(render::camera_axes(view).row(2)); };
  EXPECT_NEAR((from({0, 0}) - Vector3d::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((from({90, 0}) - Vector3d::UnitX()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((from({180, 0}) + Vector3d::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_GT(from({0, 30}).y(), 0.0);
  const Eigen::Matrix3d axes = render::camera_axes({35, 10});
  EXPECT_NEAR((axes * axes.transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);  // not mirrored
}

TEST(Colour, BytesGoThereAndBack) {
  for (unsigned byte = 0; byte < 256; ++byte)
    EXPECT_EQ(render::byte_of_linear(render::linear_of_srgb(static_cast<float>(byte) / 255.0f)), byte);
  EXPECT_EQ(render::byte_of_linear(-1.0f), 0);
  EXPECT_EQ(render::byte_of_linear(2.0f), 255);
}

TEST(Colour, ScaleGrowsBrighterAllTheWay) {
  const auto brightness = [](float value) {
    return render::scale_colour(value).dot(Vector3f(0.2126f, 0.7152f, 0.0722f));
  };
  for (int k = 1; k <= 200; ++k)
    EXPECT_GT(brightness(static_cast<float>(k) / 200.0f), brightness(static_cast<float>(k - 1) / 200.0f))
        << k;
  EXPECT_EQ(render::scale_colour(7.0f), render::scale_colour(1.0f));
  EXPECT_EQ(render::scale_colour(-1.0f), render::scale_colour(0.0f));
}

TEST(Colour, LinesHaveNoSign) {
  const Vector3f d = Vector3f(0.3f, -0.5f, 0.8f);
  EXPECT_EQ(render::direction_colour(d), render::direction_colour(-d));
  EXPECT_EQ(render::direction_colour(2.0f * Vector3f::UnitY()), render::direction_colour(Vector3f::UnitY()));
}

TEST(Png, ReadsBackAsItWas) {
  Image image(37, 21);
  std::mt19937 random(3);
  for (std::uint8_t& value : image.pixels) value = static_cast<std::uint8_t>(random() & 255u);
  const std::string bytes = render::encode_png(image);
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&read, bytes.data(), bytes.size()), 0) << read.message;
  EXPECT_EQ(read.width, 37u);
  EXPECT_EQ(read.height, 21u);
  read.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(read));
  ASSERT_NE(png_image_finish_read(&read, nullptr, pixels.data(), 0, nullptr), 0) << read.message;
  EXPECT_EQ(pixels, image.pixels);
}

TEST(Annotate, TextStaysInItsBoxAndUnknownLettersAreBlank) {
  Image image(200, 60);
  const std::string text = "Frame 12.5%";
  render::draw_text(image, 10, 20, 14, text, Vector3f::Ones());
  std::size_t inked = 0;
  for (unsigned y = 0; y < 60; ++y)
    for (unsigned x = 0; x < 200; ++x) {
      if (image.at(x, y)[0] == 0) continue;
      ++inked;
      EXPECT_TRUE(x >= 10 && x < 10 + render::text_width(14, text) && y >= 20 && y <= 34) << x << " " << y;
    }
  EXPECT_GT(inked, 200u);
  Image blank(200, 60);
  render::draw_text(blank, 10, 20, 14, " ~\xc3\xa9\n", Vector3f::Ones());
  EXPECT_EQ(blank.pixels, Image(200, 60).pixels);
  render::draw_text(blank, 190, 55, 14, "CUT OFF", Vector3f::Ones());  // clipped at the edge
}

TEST(Annotate, LegendShowsEachColourUnchanged) {
  Image image(400, 300);
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{200});
  const render::Legend legend{{{"bone", render::colour(0xede4cf)}, {"muscle", render::colour(0xb8433f)}},
                              false};
  render::draw_legend(image, legend);
  for (const std::array<int, 3> wanted : {std::array{0xed, 0xe4, 0xcf}, std::array{0xb8, 0x43, 0x3f}}) {
    std::size_t found = 0;
    for (std::size_t k = 0; k < image.pixels.size(); k += 3)
      found += std::equal(wanted.begin(), wanted.end(), &image.pixels[k]) ? 1u : 0u;
    EXPECT_GT(found, 100u);
  }
}

TEST(Annotate, SheetKeepsEveryPixelInItsCell) {
  std::vector<Image> images(3, Image(4, 5));
  for (std::size_t k = 0; k < 3; ++k)
    std::fill(images[k].pixels.begin(), images[k].pixels.end(), static_cast<std::uint8_t>(50 * (k + 1)));
  const Image sheet = render::sheet_of(images, 2);
  ASSERT_EQ(sheet.width, 8u);
  ASSERT_EQ(sheet.height, 10u);
  for (unsigned y = 0; y < 10; ++y)
    for (unsigned x = 0; x < 8; ++x) {
      const unsigned cell = y / 5 * 2 + x / 4;
      EXPECT_EQ(sheet.at(x, y)[1], cell < 3 ? 50 * (cell + 1) : 235u);
    }
}

}  // namespace
}  // namespace fascicle::tests
