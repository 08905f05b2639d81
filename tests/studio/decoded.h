// Decodes the studio's binary messages, written from docs/design/studio.md alone.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace fascicle::tests {

struct DecodedArray {
  std::string name;
  std::uint32_t kind = 0, body = 0;
  std::vector<std::uint32_t> numbers;  // of u8 and u32
  std::vector<float> floats;           // of f32
};
// Throws std::runtime_error for anything that the page does not define.
DecodedArray decode_array(const std::string& bytes);

struct DecodedFrame {
  std::uint32_t sequence = 0, body = 0, revision = 0, frame = 0, flags = 0, inverted = 0;
  double time = 0.0;
  std::uint64_t position_hash = 0;
  float seconds = 0.0f, rate = 0.0f, lag = 0.0f, largest_lag = 0.0f, energy = 0.0f, volume = 0.0f,
        speed = 0.0f;
  std::map<std::uint32_t, std::vector<double>> blocks;  // by bit: 3 numbers per point
  std::map<std::uint32_t, std::array<double, 3>> steps;
  std::vector<DecodedFrame> beside;  // the comparison bake's frame, or none
};
DecodedFrame decode_frame(const std::string& bytes);

}  // namespace fascicle::tests
