// Textures: the colour of a texel in a picture, wrapping, minification, and untrusted images.
#include "host/render/looks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>

#include "host/render/annotate.h"
#include "host/render/colour.h"
#include "host/render/decode_image.h"
#include "host/render/light.h"
#include "host/render/png.h"
#include "host/render/render.h"
#include "tests/render/shapes.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3f;
using render::Image;
using render::Texels;
using render::Texture;
using render::Vector2f;
using render::Vector4f;
using render::Wrap;

using Colour = std::array<std::uint8_t, 4>;

constexpr Colour red{200, 30, 40, 255}, green{10, 180, 60, 255}, blue{20, 40, 220, 255},
    white{250, 250, 240, 255};

Texels texels_of(unsigned width, const std::vector<Colour>& colours) {
  Texels texels{width, static_cast<unsigned>(colours.size()) / width, {}};
  for (const Colour& colour : colours)
    texels.values.insert(texels.values.end(), colour.begin(), colour.end());
  return texels;
}

Texels four() {
  return texels_of(2, {red, green, blue, white});
}

std::array<std::uint8_t, 3> bytes_of(const Vector4f& colour) {
  return {render::byte_of_linear(colour[0]), render::byte_of_linear(colour[1]),
          render::byte_of_linear(colour[2])};
}

std::array<std::uint8_t, 3> opaque(const Colour& colour) {
  return {colour[0], colour[1], colour[2]};
}

TEST(Texture, MiddlesOfTexelsHaveTheirColoursAndBetweenIsTheMean) {
  const Texture texture(four(), Wrap::clamp, Wrap::clamp);
  EXPECT_EQ(bytes_of(texture.at({0.25f, 0.25f}, 0)), opaque(red));
  EXPECT_EQ(bytes_of(texture.at({0.75f, 0.25f}, 0)), opaque(green));
  EXPECT_EQ(bytes_of(texture.at({0.25f, 0.75f}, 0)), opaque(blue));
  EXPECT_EQ(bytes_of(texture.at({0.75f, 0.75f}, 0)), opaque(white));
  const Vector4f middle = texture.at({0.5f, 0.5f}, 0);
  for (std::size_t c = 0; c < 3; ++c) {
    float mean = 0.0f;
    for (const Colour& colour : {red, green, blue, white})
      mean += 0.25f * render::linear_of_srgb(static_cast<float>(colour[c]) / 255.0f);
    // Texels are stored as multiples of 1/65535.
    EXPECT_NEAR(middle[static_cast<Eigen::Index>(c)], mean, 1e-5f);
  }
  // The mip level is the same mean.
  EXPECT_LT((texture.at({0.1f, 0.9f}, 1) - middle).cwiseAbs().maxCoeff(), 3e-5f);
}

TEST(Texture, WrapsAsAsked) {
  const auto at = [](Wrap wrap, float u) {
    return bytes_of(Texture(four(), wrap, Wrap::clamp).at({u, 0.25f}, 0));
  };
  EXPECT_EQ(at(Wrap::repeat, 1.25f), opaque(red));
  EXPECT_EQ(at(Wrap::repeat, -0.25f), opaque(green));
  EXPECT_EQ(at(Wrap::mirror, 1.25f), opaque(green));
  EXPECT_EQ(at(Wrap::mirror, -0.25f), opaque(red));
  EXPECT_EQ(at(Wrap::mirror, 2.25f), opaque(red));
  EXPECT_EQ(at(Wrap::clamp, 7.0f), opaque(green));
  EXPECT_EQ(at(Wrap::clamp, -7.0f), opaque(red));
  for (const float u : {1e30f, -1e30f, INFINITY, NAN})
    EXPECT_TRUE(std::isfinite(Texture(four(), Wrap::repeat, Wrap::mirror).at({u, u}, 0).sum()));
}

TEST(Texture, LargeOnesAreKeptSmaller) {
  const Texture texture(texels_of(8, std::vector<Colour>(8 * 4, blue)), Wrap::repeat, Wrap::repeat, 4);
  EXPECT_EQ(texture.width(), 4u);
  EXPECT_EQ(texture.height(), 2u);
  EXPECT_EQ(texture.level_count(), 3u);
  EXPECT_EQ(bytes_of(texture.at({0.3f, 0.7f}, 2)), opaque(blue));
  EXPECT_EQ(texture.level_for(1.0f), 0u);
  EXPECT_EQ(texture.level_for(8.0f), 1u);
  EXPECT_EQ(texture.level_for(1e9f), 2u);
}

// A square of 20 x 20 cm, 40 x 40 pixels, with its texture upright; in ink, so that a pixel is the unshaded
// paint.
render::Shape textured(const render::Looks& looks) {
  render::Shape shape = square({0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, Vector3f::Ones());
  shape.finish = render::Finish::ink;
  shape.looks = &looks;
  shape.paints.assign(shape.triangles.size(), 0);
  shape.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  return shape;
}

Image drawn(const render::Shape& shape, unsigned threads = 1) {
  render::Backdrop black;
  black.top = black.bottom = Vector3f::Zero();
  return render::render(std::vector<render::Shape>{shape}, camera_on_z(1.0, 200.0, 60, 60), black, threads);
}

std::array<std::uint8_t, 3> pixel(const Image& image, unsigned x, unsigned y) {
  return {image.at(x, y)[0], image.at(x, y)[1], image.at(x, y)[2]};
}

// Equal within `most`.
void expect_near(const std::array<std::uint8_t, 3>& a, const std::array<std::uint8_t, 3>& b, int most) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(int{a[c]}, int{b[c]}, most);
}

TEST(Looks, TexturedSquareShowsItsTexels) {
  render::Looks looks;
  looks.textures.emplace_back(four(), Wrap::clamp, Wrap::clamp);
  looks.paints.push_back({.texture = 0});
  const Image image = drawn(textured(looks));
  // Near the corners, clamping leaves a single texel.
  expect_near(pixel(image, 12, 12), opaque(red), 1);
  expect_near(pixel(image, 47, 12), opaque(green), 1);
  expect_near(pixel(image, 12, 47), opaque(blue), 1);
  expect_near(pixel(image, 47, 47), opaque(white), 1);
  EXPECT_EQ(drawn(textured(looks), 7).pixels, image.pixels);

  // The base colour and the vertex colours multiply it, in linear light.
  looks.paints[0].colour = {0.5f, 1.0f, 0.25f};
  render::Shape half = textured(looks);
  half.colours.assign(4, Vector3f(1.0f, 0.5f, 1.0f));
  const auto times = [](std::uint8_t byte, float factor) {
    return render::byte_of_linear(factor * render::linear_of_srgb(static_cast<float>(byte) / 255.0f));
  };
  expect_near(pixel(drawn(half), 12, 12), {times(red[0], 0.5f), times(red[1], 0.5f), times(red[2], 0.25f)},
              1);
}

// Half of the texels are holes, so half of the square's pixels show the backdrop. Without a cutoff none do.
TEST(Looks, MaskedTexelsAreHoles) {
  Colour hole = green;
  hole[3] = 0;
  render::Looks looks;
  looks.textures.emplace_back(texels_of(2, {red, hole, red, hole}), Wrap::clamp, Wrap::clamp);
  looks.paints.push_back({.cutoff = 0.5f, .texture = 0});
  const auto lit = [&] {
    const Image image = drawn(textured(looks));
    std::size_t count = 0;
    for (std::size_t k = 0; k < image.pixels.size(); k += 3) count += image.pixels[k] > 0 ? 1u : 0u;
    return count;
  };
  // 40 x 40 pixels; alpha is 0.5 in the middle column.
  EXPECT_NEAR(static_cast<double>(lit()), 800.0, 40.0);
  looks.paints[0].cutoff = 0.0f;
  EXPECT_EQ(lit(), 1600u);
}

// The light that falls through the holes is on what lies behind them.
TEST(Looks, HolesCastNoShadow) {
  Colour hole = green;
  hole[3] = 0;
  render::Looks looks;
  looks.textures.emplace_back(texels_of(2, {red, hole, red, hole}), Wrap::clamp, Wrap::clamp);
  looks.paints.push_back({.cutoff = 0.5f, .texture = 0});
  const std::vector<render::Shape> shapes{textured(looks)};
  // From -x, where it is red, to x, 1 cm behind the square.
  const auto light = [&](float x, float y) {
    return render::ShadowMap(shapes, Vector3f::UnitZ(), Vector3f::Zero(), 0.2f, 256)
        .visibility({x, y, -0.01f}, Vector3f::UnitZ());
  };
  // The hole begins in the middle, within a texel of the map, 1.6 mm.
  for (const float y : {-0.08f, 0.03f, 0.09f})
    for (const float x : {0.004f, 0.05f, 0.09f}) {
      EXPECT_EQ(light(x, y), 1.0f) << x << " " << y;
      EXPECT_EQ(light(-x, y), 0.0f) << x << " " << y;
    }
  // A base colour below the cutoff makes a hole of all of it.
  looks.paints[0].alpha = 0.4f;
  EXPECT_EQ(light(-0.05f, 0.03f), 1.0f);
  looks.paints[0].cutoff = 0.0f;
  EXPECT_EQ(light(-0.05f, 0.03f), 0.0f);
}

// A checkerboard of single texels is uniform grey from afar, at any pixel offset.
TEST(Looks, SmallVersionsKeepAFineBoardFromFlickering) {
  std::vector<Colour> board;
  for (unsigned y = 0; y < 512; ++y)
    for (unsigned x = 0; x < 512; ++x)
      board.push_back((x + y) % 2 == 0 ? Colour{255, 255, 255, 255} : Colour{0, 0, 0, 255});
  render::Looks looks;
  looks.textures.emplace_back(texels_of(512, board), Wrap::repeat, Wrap::repeat);
  looks.paints.push_back({.texture = 0});
  const Image image = drawn(textured(looks));
  const std::uint8_t grey = render::byte_of_linear(0.5f);
  for (unsigned y = 12; y < 48; ++y)
    for (unsigned x = 12; x < 48; ++x) expect_near(pixel(image, x, y), {grey, grey, grey}, 1);
}

// A picture as JPEG bytes, from libjpeg.
std::vector<unsigned char> jpeg_of(const Image& image, bool is_progressive = false) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = image.width;
  jpeg.image_height = image.height;
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  if (is_progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    std::vector<std::uint8_t> row(image.at(0, jpeg.next_scanline),
                                  image.at(0, jpeg.next_scanline) + std::size_t{3} * image.width);
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&jpeg, &rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::vector<unsigned char> bytes(memory, memory + size);
  jpeg_destroy_compress(&jpeg);
  std::free(memory);
  return bytes;
}

std::vector<unsigned char> png_of(const Image& image) {
  const std::string text = render::encode_png(image);
  return {text.begin(), text.end()};
}

Image plain_image(unsigned width, unsigned height) {
  Image image(width, height);
  for (std::size_t k = 0; k < image.pixels.size(); ++k)
    image.pixels[k] = k % 3 == 0 ? 180 : k % 3 == 1 ? 90 : 40;
  return image;
}

TEST(DecodeImage, ReadsPngExactlyAndJpegNearly) {
  Image noise(13, 7);
  std::mt19937 random(4);
  for (std::uint8_t& value : noise.pixels) value = static_cast<std::uint8_t>(random() & 255u);
  const render::DecodedImage png = render::decode_image(png_of(noise));
  EXPECT_EQ(png.flaw, "");
  ASSERT_EQ(png.texels.values.size(), 4u * 13 * 7);
  for (std::size_t k = 0; k < 13 * 7; ++k)
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_EQ(png.texels.values[4 * k + c], c == 3 ? 255 : noise.pixels[3 * k + c]);
  const render::DecodedImage jpeg = render::decode_image(jpeg_of(plain_image(20, 12)));
  EXPECT_EQ(jpeg.flaw, "");
  ASSERT_EQ(jpeg.texels.width, 20u);
  ASSERT_EQ(jpeg.texels.height, 12u);
  // A uniform colour only suffers rounding between colour spaces.
  for (std::size_t k = 0; k < 240; ++k) {
    EXPECT_NEAR(jpeg.texels.values[4 * k], 180, 3);
    EXPECT_NEAR(jpeg.texels.values[4 * k + 1], 90, 3);
    EXPECT_NEAR(jpeg.texels.values[4 * k + 2], 40, 3);
  }
}

TEST(DecodeImage, TheHeaderSaysSizeAndType) {
  const render::ImageHeader png = render::image_header(png_of(plain_image(40, 30)));
  EXPECT_EQ(std::tuple(png.width, png.height, std::string(png.type), png.flaw),
            std::tuple(40u, 30u, "image/png", ""));
  const render::ImageHeader jpeg = render::image_header(jpeg_of(plain_image(20, 12)));
  EXPECT_EQ(std::tuple(jpeg.width, jpeg.height, std::string(jpeg.type), jpeg.flaw),
            std::tuple(20u, 12u, "image/jpeg", ""));
  EXPECT_EQ(render::image_header({}).flaw, "is neither PNG nor JPEG");
}

TEST(DecodeImage, BrokenOnesAreToldAndNeverCrash) {
  EXPECT_EQ(render::decode_image({}).flaw, "is neither PNG nor JPEG");
  const std::vector<unsigned char> png = png_of(plain_image(40, 30)), jpeg = jpeg_of(plain_image(40, 30));
  for (const auto& whole : {png, jpeg}) {
    const std::vector<unsigned char> half(whole.begin(),
                                          whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
    EXPECT_NE(render::decode_image(half).flaw, "");
    std::mt19937 random(6);
    for (int k = 0; k < 300; ++k) {
      std::vector<unsigned char> damaged = whole;
      for (int n = 0; n < 8; ++n)
        damaged[8 + random() % (damaged.size() - 8)] = static_cast<unsigned char>(random());
      const render::DecodedImage image = render::decode_image(damaged);
      EXPECT_EQ(image.texels.values.size(), std::size_t{4} * image.texels.width * image.texels.height);
      EXPECT_TRUE(!image.texels.values.empty() || !image.flaw.empty());
      const render::ImageHeader header = render::image_header(damaged);
      EXPECT_EQ(header.flaw.empty(), header.width > 0 && header.height > 0);
      if (image.texels.values.empty()) continue;
      EXPECT_EQ(header.width, image.texels.width);
      EXPECT_EQ(header.height, image.texels.height);
    }
  }
}

// With another size in its header and a correct checksum.
std::vector<unsigned char> sized_png(std::vector<unsigned char> png, unsigned size) {
  for (const std::size_t at : {std::size_t{16}, std::size_t{20}}) {
    png[at + 2] = static_cast<unsigned char>(size / 256);
    png[at + 3] = static_cast<unsigned char>(size % 256);
  }
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t k = 12; k < 29; ++k) {
    crc ^= png[k];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  for (std::size_t k = 0; k < 4; ++k) png[29 + k] = static_cast<unsigned char>(~crc >> (24 - 8 * k));
  return png;
}

TEST(DecodeImage, LargeOnesAreRefusedBeforeMemoryIsAllocated) {
  const render::DecodedImage image = render::decode_image(sized_png(png_of(plain_image(40, 30)), 60000));
  EXPECT_TRUE(image.texels.values.empty());
  EXPECT_NE(image.flaw.find("60000 x 60000 is larger"), std::string::npos) << image.flaw;
  EXPECT_EQ(render::image_header(sized_png(png_of(plain_image(40, 30)), 60000)).flaw, image.flaw);
}

TEST(DecodeImage, SizesThatAFileCannotHoldAreRefused) {
  const render::DecodedImage image = render::decode_image(sized_png(png_of(plain_image(40, 30)), 5000));
  EXPECT_TRUE(image.texels.values.empty());
  EXPECT_NE(image.flaw.find("bytes cannot hold 5000 x 5000"), std::string::npos) << image.flaw;
  EXPECT_EQ(render::image_header(sized_png(png_of(plain_image(40, 30)), 5000)).flaw, image.flaw);
  // What compresses best is read: one colour, near the bound.
  const std::vector<unsigned char> flat = png_of(plain_image(1500, 1500));
  EXPECT_LT(flat.size(), std::size_t{1500} * 1500 * 3 / 300);
  EXPECT_EQ(render::decode_image(flat).texels.width, 1500u);
  for (const bool is_progressive : {false, true}) {
    const std::vector<unsigned char> plain = jpeg_of(plain_image(1500, 1500), is_progressive);
    EXPECT_LT(plain.size(), std::size_t{1500} * 1500 / 60);
    EXPECT_EQ(render::decode_image(plain).flaw, "");
  }
}

// JPEG of 4096 x 8192 in too few bytes is refused. In a longer file each scan covers the whole picture, so
// the limit on scans depends on its size.
TEST(DecodeImage, ManyScansOfALargePictureAreRefused) {
  const std::vector<unsigned char> whole = jpeg_of(plain_image(40, 30), true);
  const auto find = [&](unsigned char marker) {
    const std::array<unsigned char, 2> bytes{0xff, marker};
    return std::find_end(whole.begin(), whole.end(), bytes.begin(), bytes.end());
  };
  const auto last_scan = find(0xda), end = find(0xd9), frame = find(0xc2);
  ASSERT_TRUE(last_scan < end && end != whole.end() && frame < last_scan);
  std::vector<unsigned char> busy(whole.begin(), end);
  for (int k = 0; k < 100; ++k) busy.insert(busy.end(), last_scan, end);
  busy.insert(busy.end(), end, whole.end());
  EXPECT_EQ(render::decode_image(busy).texels.width, 40u);
  // Sets the frame's height and width: 4096 x 8192, for which up to about ten scans are allowed. What follows
  // the end of the picture makes the file long enough for it.
  const auto sized = [&](std::vector<unsigned char> bytes) {
    const auto at = static_cast<std::size_t>(frame - whole.begin()) + 5;
    for (const std::size_t k : {0u, 2u}) {
      bytes[at + k] = k == 0 ? 0x10 : 0x20;
      bytes[at + k + 1] = 0;
    }
    const std::string flaw = render::decode_image(bytes).flaw;
    EXPECT_NE(flaw.find("bytes cannot hold 8192 x 4096"), std::string::npos) << flaw;
    bytes.resize(bytes.size() + 4096 * 8192 / 512);
    return bytes;
  };
  EXPECT_EQ(render::decode_image(sized(whole)).texels.width, 8192u);
  const render::DecodedImage refused = render::decode_image(sized(busy));
  EXPECT_TRUE(refused.texels.values.empty());
  EXPECT_NE(refused.flaw.find("too many scans for a picture of this size"), std::string::npos)
      << refused.flaw;
}

TEST(Annotate, RowKeepsPicturesBelowTheirWords) {
  const std::vector<Image> images{plain_image(60, 50), plain_image(60, 50)};
  const std::vector<std::string> words{"skinned", "a line that is much too long for so small a picture"};
  const unsigned letters = render::caption_height(60, 50, words);
  EXPECT_LT(letters, render::caption_height(60, 50, std::span(words).first(1)));
  const Image row = render::row_of(images, words, letters);
  ASSERT_EQ(row.width, 120u);
  const unsigned strip = row.height - 50;
  EXPECT_GT(strip, 8u);
  for (unsigned y = 0; y < 50; ++y)
    for (unsigned x = 0; x < 120; ++x)
      ASSERT_TRUE(std::equal(row.at(x, strip + y), row.at(x, strip + y) + 3, images[0].pixels.begin()));
  const auto inked = [&](unsigned from, unsigned to) {
    for (unsigned y = 0; y < strip; ++y)
      for (unsigned x = from; x < to; ++x)
        if (row.at(x, y)[0] < 150) return true;
    return false;
  };
  EXPECT_TRUE(inked(0, 60));
  EXPECT_TRUE(inked(60, 120));
}

}  // namespace
}  // namespace fascicle::tests
