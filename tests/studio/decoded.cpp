#include "tests/studio/decoded.h"

#include <cstring>
#include <stdexcept>

namespace fascicle::tests {
namespace {

template <class Number>
Number at(const std::string& bytes, std::size_t offset) {
  Number number{};
  if (offset + sizeof number > bytes.size()) throw std::runtime_error("the message is cut short");
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

std::size_t aligned(std::size_t offset) {
  return (offset + 3) / 4 * 4;
}

void must(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

}  // namespace

DecodedArray decode_array(const std::string& bytes) {
  must(at<std::uint8_t>(bytes, 0) == 2 && at<std::uint8_t>(bytes, 1) == 1, "no array of version 1");
  DecodedArray array;
  array.kind = at<std::uint8_t>(bytes, 2);
  const std::size_t length = at<std::uint8_t>(bytes, 3);
  array.body = at<std::uint32_t>(bytes, 4);
  const std::size_t count = at<std::uint32_t>(bytes, 8);
  must(at<std::uint32_t>(bytes, 12) == 0, "byte 12 is not 0");
  array.name = bytes.substr(16, length);
  std::size_t offset = aligned(16 + length);
  for (std::size_t k = 0; k < count; ++k) {
    if (array.kind == 1) array.numbers.push_back(at<std::uint8_t>(bytes, offset + k));
    if (array.kind == 2) array.numbers.push_back(at<std::uint32_t>(bytes, offset + 4 * k));
    if (array.kind == 3) array.floats.push_back(at<float>(bytes, offset + 4 * k));
  }
  must(offset + count * (array.kind == 1 ? 1 : 4) == bytes.size(), "the array has another size than it says");
  return array;
}

namespace {

DecodedFrame decode_one(const std::string& bytes, std::uint8_t type) {
  must(at<std::uint8_t>(bytes, 0) == type && at<std::uint8_t>(bytes, 1) == 1, "no frame of version 1");
  DecodedFrame frame;
  const std::uint32_t bits = at<std::uint16_t>(bytes, 2);
  frame.sequence = at<std::uint32_t>(bytes, 4);
  frame.body = at<std::uint32_t>(bytes, 8);
  frame.revision = at<std::uint32_t>(bytes, 12);
  frame.frame = at<std::uint32_t>(bytes, 16);
  frame.flags = at<std::uint32_t>(bytes, 20);
  frame.time = at<double>(bytes, 24);
  frame.position_hash = at<std::uint64_t>(bytes, 32);
  frame.seconds = at<float>(bytes, 40);
  frame.rate = at<float>(bytes, 44);
  frame.lag = at<float>(bytes, 48);
  frame.largest_lag = at<float>(bytes, 52);
  frame.energy = at<float>(bytes, 56);
  frame.volume = at<float>(bytes, 60);
  frame.inverted = at<std::uint32_t>(bytes, 64);
  must(at<std::uint32_t>(bytes, 68) == 0, "byte 68 is not 0");
  frame.speed = at<float>(bytes, 72);
  std::size_t offset = 80;
  for (std::uint32_t bit = 1; bit <= 64; bit *= 2) {
    if ((bits & bit) == 0) continue;
    std::array<double, 3> least{}, step{};
    for (std::size_t a = 0; a < 3; ++a) {
      least[a] = double{at<float>(bytes, offset + 4 * a)};
      step[a] = double{at<float>(bytes, offset + 12 + 4 * a)};
    }
    const std::size_t points = at<std::uint32_t>(bytes, offset + 24);
    must(at<std::uint32_t>(bytes, offset + 28) == 0, "byte 28 of a block is not 0");
    offset += 32;
    std::vector<double>& places = frame.blocks[bit];
    for (std::size_t k = 0; k < 3 * points; ++k)
      places.push_back(least[k % 3] + step[k % 3] * at<std::uint16_t>(bytes, offset + 2 * k));
    frame.steps[bit] = step;
    offset = aligned(offset + 6 * points);
  }
  must(offset == bytes.size(), "bytes follow the last block");
  return frame;
}

}  // namespace

DecodedFrame decode_frame(const std::string& bytes) {
  const std::size_t size = at<std::uint32_t>(bytes, 76);
  must(size <= bytes.size(), "the frame has another size than it says");
  DecodedFrame frame = decode_one(bytes.substr(0, size), 1);
  if (size == bytes.size()) return frame;
  must(size % 4 == 0, "what follows is not aligned");
  const std::string rest = bytes.substr(size);
  must(at<std::uint32_t>(rest, 76) == rest.size(), "the frame beside has another size than it says");
  frame.beside.push_back(decode_one(rest, 3));
  return frame;
}

}  // namespace fascicle::tests
