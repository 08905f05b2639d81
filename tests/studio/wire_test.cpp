// Binary messages: encoded data decodes by the protocol's page.
#include "host/studio/wire.h"

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/studio/decoded.h"

namespace fascicle::tests {
namespace {

using studio::Block;
using studio::BlockPoints;

TEST(Wire, ArraysReadBack) {
  const std::vector<std::uint8_t> bytes{1, 2, 255};
  const std::vector<std::uint32_t> numbers{7, 0xffffffffu};
  const std::vector<float> floats{1.5f, -0.0f, 3e-30f};
  const DecodedArray a = decode_array(studio::encode_array("layer", 3, std::span<const std::uint8_t>(bytes)));
  EXPECT_EQ(a.name, "layer");
  EXPECT_EQ(a.body, 3u);
  EXPECT_EQ(a.numbers, (std::vector<std::uint32_t>{1, 2, 255}));
  EXPECT_EQ(
      decode_array(studio::encode_array("tetrahedron", 1, std::span<const std::uint32_t>(numbers))).numbers,
      numbers);
  EXPECT_EQ(decode_array(studio::encode_array("rest", 1, std::span<const float>(floats))).floats, floats);
  const std::vector<float> none;
  EXPECT_TRUE(decode_array(studio::encode_array("", 1, std::span<const float>(none))).floats.empty());
}

TEST(Wire, FramesReadBackWithinHalfAStep) {
  std::vector<float> surface, vertices;
  for (int k = 0; k < 3 * 1001; ++k) surface.push_back(static_cast<float>(std::sin(0.37 * k) * (k % 3 + 1)));
  // A flat block has no extent along one axis, a single point along none.
  for (int k = 0; k < 7; ++k) vertices.insert(vertices.end(), {static_cast<float>(k), 2.0f, -3.0f});
  const std::vector<float> joint{1.0f, 2.0f, 3.0f};
  const studio::FrameNumbers numbers{.sequence = 9,
                                     .body = 2,
                                     .revision = 5,
                                     .frame = 17,
                                     .flags = studio::frame_is_recorded,
                                     .time = 0.283,
                                     .position_hash = 0x0123456789abcdefULL,
                                     .seconds = 0.01f,
                                     .rate = 60.0f,
                                     .lag = 0.002f,
                                     .largest_lag = 0.02f,
                                     .energy = 4.0f,
                                     .volume = 0.99f,
                                     .inverted = 3,
                                     .speed = 0.5f};
  const std::vector<BlockPoints> blocks{
      {Block::surface, surface}, {Block::vertices, vertices}, {Block::joints, joint}};
  const DecodedFrame frame = decode_frame(studio::encode_frame(numbers, blocks));
  EXPECT_EQ(frame.sequence, 9u);
  EXPECT_EQ(frame.body, 2u);
  EXPECT_EQ(frame.revision, 5u);
  EXPECT_EQ(frame.frame, 17u);
  EXPECT_EQ(frame.flags, 1u);
  EXPECT_EQ(frame.time, 0.283);
  EXPECT_EQ(frame.position_hash, 0x0123456789abcdefULL);
  EXPECT_EQ(frame.rate, 60.0f);
  EXPECT_EQ(frame.lag, 0.002f);
  EXPECT_EQ(frame.largest_lag, 0.02f);
  EXPECT_EQ(frame.energy, 4.0f);
  EXPECT_EQ(frame.volume, 0.99f);
  EXPECT_EQ(frame.inverted, 3u);
  EXPECT_EQ(frame.speed, 0.5f);
  ASSERT_EQ(frame.blocks.size(), 3u);
  for (const BlockPoints& block : blocks) {
    const auto bit = static_cast<std::uint32_t>(block.block);
    const std::vector<double>& places = frame.blocks.at(bit);
    ASSERT_EQ(places.size(), block.points.size());
    for (std::size_t k = 0; k < places.size(); ++k)
      // Half a step, and float rounding, which is a hundredth of a step.
      EXPECT_NEAR(places[k], double{block.points[k]}, 0.51 * frame.steps.at(bit)[k % 3] + 1e-7) << k;
  }
}

TEST(Wire, AFrameWithoutBlocksIsItsHeaderAlone) {
  EXPECT_EQ(studio::encode_frame({}, {}).size(), 80u);
}

}  // namespace
}  // namespace fascicle::tests
