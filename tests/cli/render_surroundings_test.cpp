// fascicle render of bodies that travel, and beside floors and solids, as a user sees them.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/cli/nodding_body.h"
#include "tests/cli/pixels.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// A free bar of 0.3 m that is pulled sideways.
class RenderOfATraveller : public testing::Test {
 protected:
  void bake(const std::string& seconds) {
    write_text(folder_ / "scene.toml",
               "[scene]\nfps = 24\ngravity = [9.81, 0.0, 0.0]\n[bar]\nsize = [0.3, 0.3, 0.3]\n"
               "vertices = [3, 3, 3]\n[layers.flesh]\nyoungs_modulus = 50e3\ndamping = 3.0\n"
               "density = 1000.0\n[solver]\nintegrator = \"implicit\"\nsubsteps = \"auto\"\n");
    const Outcome baked = fascicle({"bake", folder_ / "scene.toml", "-o", folder_ / "bake", "--overwrite",
                                    "--end", seconds, "--device", "cpu", "-q"});
    ASSERT_EQ(baked.status, 0) << baked.err;
  }
  // The PNG's bytes; what was said goes to `said_`.
  std::string picture(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"render",  folder_ / "bake", "-o", picture_,     "--size",
                                       "160x160", "--frame",        "0",  "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = fascicle(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    said_ = outcome.err;
    return read_text(picture_);
  }
  // Share of the picture that the body covers.
  double skin() const {
    const Pixels pixels = pixels_of(picture_);
    double count = 0.0;
    for (std::size_t k = 0; k < pixels.rgb.size(); k += 3)
      count += pixels.rgb[k] > pixels.rgb[k + 2] + 25 ? 1.0 : 0.0;
    return count / (pixels.width * pixels.height);
  }

  TemporaryFolder folder_;
  std::string picture_ = folder_ / "a.png", said_;
};

TEST_F(RenderOfATraveller, IsFollowedIfItWouldBeASpeck) {
  bake("2");  // over 20 m
  const std::string whole_path = picture({"--no-follow"});
  EXPECT_LT(skin(), 0.01);
  EXPECT_FALSE(contains(said_, "follow")) << said_;
  const std::string chosen = picture({});
  EXPECT_GT(skin(), 0.2);
  EXPECT_TRUE(contains(said_, "--no-follow shows the whole path")) << said_;
  EXPECT_FALSE(chosen == whole_path);
  EXPECT_TRUE(picture({"--follow"}) == chosen);
  EXPECT_FALSE(contains(said_, "follow")) << said_;
}

TEST_F(RenderOfATraveller, IsShownWithItsPathIfThatIsShort) {
  bake("0.4");  // 0.8 m
  const std::string chosen = picture({});
  EXPECT_FALSE(contains(said_, "follow")) << said_;
  EXPECT_TRUE(picture({"--no-follow"}) == chosen);
  EXPECT_FALSE(picture({"--follow"}) == chosen);
}

// A body with and without a floor of 20 m in its file, seen from the side at its own height, where nothing of
// the floor is above the middle of the picture.
TEST(RenderOnAFloor, ShowsTheBodyAsLargeAsWithoutIt) {
  const TemporaryFolder folder;
  // The widths of the body in each row of the picture's upper half.
  const auto rows_of = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{"render",      folder / "bake",  "-o",          folder / "a.png",
                                     "--overwrite", "--size=160x160", "--view=side", "--tilt=0"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome drawn = fascicle(command);
    EXPECT_EQ(drawn.status, 0) << drawn.err;
    const Pixels pixels = pixels_of(folder / "a.png");
    std::vector<double> rows;
    for (unsigned y = 0; y < pixels.height / 2; ++y) {
      rows.push_back(0.0);
      for (unsigned x = 0; x < pixels.width; ++x) {
        const std::uint8_t* p = &pixels.rgb[3 * (std::size_t{y} * pixels.width + x)];
        rows.back() += p[0] > p[2] + 25 ? 1.0 : 0.0;
      }
    }
    EXPECT_GT(*std::max_element(rows.begin(), rows.end()), pixels.width / 8.0);
    return rows;
  };
  const std::vector<std::vector<std::string>> ways{{"--frame=0"},
                                                   {"--frame=0", "--compare"},
                                                   {"--frame=24"},
                                                   {"--frame=24", "--follow"},
                                                   {"--frame=24", "--clip", "z=50%"}};
  std::vector<std::vector<double>> without;
  for (const double floor : {0.0, 10.0}) {
    // At 5 m/s it goes 2 m.
    write_text(folder / "body.gltf", nodding_body(12, 10, floor, 5.0));
    const Outcome baked = fascicle({"bake", folder / "body.gltf", "-o", folder / "bake", "--overwrite",
                                    "--end=0.4", "--resolution=300", "--device=cpu", "-q"});
    ASSERT_EQ(baked.status, 0) << baked.err;
    for (std::size_t k = 0; k < ways.size(); ++k) {
      const std::vector<double> rows = rows_of(ways[k]);
      if (floor == 0.0) {
        without.push_back(rows);
        continue;
      }
      // The two bodies are filled apart. Their outlines may differ by a pixel on each side, and where a row
      // of the picture just misses the top of the head, by all of that.
      std::size_t others = 0;
      for (std::size_t y = 0; y < rows.size(); ++y) others += std::abs(rows[y] - without[k][y]) > 2.0 ? 1 : 0;
      EXPECT_LE(others, 2u) << k;
    }
  }
}

// A bar of 0.3 m that moves freely beside one solid: the share of a picture that shows skin, and the
// share of its second lowest row that shows the solid, a dark bluish grey.
struct Shown {
  double skin = 0.0, solid_below = 0.0;
};

class RenderBesideSolid : public testing::Test {
 protected:
  void bake_beside(const std::string& collider, const std::string& seconds) {
    write_text(folder_ / "scene.toml",
               "[scene]\nfps = 24\n[bar]\nsize = [0.3, 0.3, 0.3]\nvertices = [3, 3, 3]\n"
               "[layers.flesh]\nyoungs_modulus = 50e3\ndamping = 3.0\ndensity = 1000.0\n"
               "[solver]\nintegrator = \"implicit\"\nsubsteps = \"auto\"\n[collider.solid]\n" +
                   collider);
    const Outcome baked = fascicle(
        {"bake", folder_ / "scene.toml", "-o", folder_ / "bake", "--end", seconds, "--device", "cpu", "-q"});
    ASSERT_EQ(baked.status, 0) << baked.err;
  }
  Shown shown(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"render", folder_ / "bake", "-o",         folder_ / "a.png",
                                       "--size", "160x160",        "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = fascicle(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const Pixels pixels = pixels_of(folder_ / "a.png");
    Shown shown;
    for (unsigned k = 0; k < pixels.width * pixels.height; ++k) {
      const int red = pixels.rgb[3 * k], blue = pixels.rgb[3 * k + 2];
      shown.skin += red > blue + 25 ? 1.0 : 0.0;
      if (k / pixels.width == pixels.height - 2)
        shown.solid_below += blue > red + 5 && blue < 180 ? 1.0 : 0.0;
    }
    shown.skin /= pixels.width * pixels.height;
    shown.solid_below /= pixels.width;
    return shown;
  }

  TemporaryFolder folder_;
};

// The bar slides down by three times its length. The slope fills the foreground wherever it is, with a camera
// that follows it and with one that does not: it reaches past the camera.
TEST_F(RenderBesideSolid, ASlopeIsUnderTheBodyWhereverItGoes) {
  bake_beside("shape = \"plane\"\ncenter = [0.0, -0.16, 0.0]\nnormal = [0.0, 1.0, 0.1]\nfriction = 0.0\n",
              "3");
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--frame", "0"},
                                               {"--frame", "72"},
                                               {"--frame", "0", "--follow"},
                                               {"--frame", "72", "--follow"}}) {
    const Shown one = shown(more);
    EXPECT_EQ(one.solid_below, 1.0) << more[1] << (more.size() > 2 ? " followed" : "");
    EXPECT_GT(one.skin, 0.05) << more[1] << (more.size() > 2 ? " followed" : "");
  }
}

// On a block of 40 m the bar throws the shadow that it throws on a plane at the same height.
TEST_F(RenderBesideSolid, ALargeBlockShowsTheBodysShadow) {
  const auto foreground = [&](const std::string& collider) {
    bake_beside(collider, "0.1");
    (void)shown({"--frame", "0"});
    std::vector<std::uint8_t> rgb = pixels_of(folder_ / "a.png").rgb;
    // The lowest 50 of 160 rows: the plane and the block end at different distances.
    rgb.erase(rgb.begin(), rgb.begin() + std::ptrdiff_t{110} * 160 * 3);
    return rgb;
  };
  // Too steep for a floor, which has the backdrop's colour.
  const std::vector<std::uint8_t> plane =
      foreground("shape = \"plane\"\ncenter = [0.0, -0.16, 0.0]\nnormal = [0.0, 1.0, 0.016]\n");
  fs::remove_all(folder_ / "bake");
  const std::vector<std::uint8_t> block =
      foreground("shape = \"box\"\ncenter = [0.0, -20.16, 0.0]\nsize = [40.0, 40.0, 40.0]\n");
  std::size_t differing = 0, dark = 0;
  for (std::size_t k = 0; k < plane.size(); k += 3) {
    differing += std::abs(plane[k] - block[k]) > 12 ? 1u : 0u;
    dark += plane[k] < plane[k + 2] && plane[k] < 120 ? 1u : 0u;
  }
  // The slope, and lamps that the block does not shade, make a small difference at the shadow's rim.
  EXPECT_LT(static_cast<double>(differing), 0.01 * static_cast<double>(plane.size()) / 3.0);
  EXPECT_GT(static_cast<double>(dark), 0.03 * static_cast<double>(plane.size()) / 3.0);
}

// A roof shades the body however large it is: shadow maps do not reach all of a large one, which still casts.
TEST_F(RenderBesideSolid, ARoofShadesTheBody) {
  const auto brightness = [&](const std::string& width) {
    bake_beside("shape = \"box\"\ncenter = [0.0, 0.6, 0.0]\nsize = [" + width + ", 0.05, " + width + "]\n",
                "0.05");
    (void)shown({"--frame", "0"});
    fs::remove_all(folder_ / "bake");
    double sum = 0.0;
    const std::vector<std::uint8_t> rgb = pixels_of(folder_ / "a.png").rgb;
    for (const std::uint8_t byte : rgb) sum += byte;
    return sum / static_cast<double>(rgb.size());
  };
  // The body fills the picture. From 1.6 to 1.7 m the roof shades little more of it; a small one shades
  // nothing.
  const double small = brightness("0.1"), shaded = brightness("1.6");
  EXPECT_NEAR(brightness("1.7"), shaded, 0.25 * (small - shaded));
  EXPECT_LT(brightness("40.0"), shaded);
  EXPECT_LT(shaded, small - 5.0);
}

// A block of 40 m whose near side is between the bar and the camera, which is in the block.
TEST_F(RenderBesideSolid, ASolidAroundTheCameraDoesNotHideTheBody) {
  bake_beside("shape = \"box\"\ncenter = [0.0, 0.0, 20.5]\nsize = [40.0, 40.0, 40.0]\n", "0.5");
  EXPECT_GT(shown({"--frame", "0"}).skin, 0.005);
}

}  // namespace
}  // namespace fascicle::tests
