// Binary messages of the studio's protocol, byte for byte as in docs/design/studio.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fascicle::studio {

// An array that is sent once. `name` has at most 64 characters.
std::string encode_array(std::string_view name, std::uint32_t body, std::span<const std::uint8_t> items);
std::string encode_array(std::string_view name, std::uint32_t body, std::span<const std::uint32_t> items);
std::string encode_array(std::string_view name, std::uint32_t body, std::span<const float> items);

// One bit each.
enum class Block : std::uint16_t {
  surface = 1,
  ghost = 2,
  vertices = 4,
  ghost_vertices = 8,
  joints = 16,
  contact = 32,
  solids = 64,
};
constexpr std::uint16_t bit_of(Block block) {
  return static_cast<std::uint16_t>(block);
}
// Their names in page messages, in the order of the bits.
inline constexpr std::array<std::string_view, 7> block_names{
    "surface", "ghost", "vertices", "ghost-vertices", "joints", "contact", "solids"};

// What a frame belongs to: what is played, or the comparison bake.
enum class FrameOf : std::uint8_t { played = 1, beside = 3 };

inline constexpr std::uint32_t frame_is_recorded = 1, frame_is_pulled = 2, frame_begins = 4;

// A frame's data besides its points.
struct FrameNumbers {
  std::uint32_t sequence = 0, body = 0, revision = 0, frame = 0, flags = 0;
  double time = 0.0;                // s of the clip
  std::uint64_t position_hash = 0;  // model::position_hash
  float seconds = 0.0f, rate = 0.0f;
  float lag = 0.0f, largest_lag = 0.0f;  // m
  float energy = 0.0f;                   // J; NaN if not known
  float volume = 1.0f;                   // relative to rest
  std::uint32_t inverted = 0;            // tetrahedra
  float speed = 0.0f;                    // m/s
};

// Points of one block: 3 finite numbers each, m.
struct BlockPoints {
  Block block = Block::surface;
  std::span<const float> points;
};

// A message is the frame of what is played, followed by that of the comparison bake if there is one. Blocks
// are in ascending order of their bits. The error of a coordinate is at most half a step, which is the
// block's extent over 65535.
std::string encode_frame(const FrameNumbers& numbers, std::span<const BlockPoints> blocks,
                         FrameOf of = FrameOf::played);

}  // namespace fascicle::studio
