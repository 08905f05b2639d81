#include "host/studio/wire.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "host/base/file.h"

namespace fascicle::studio {

using base::append_array;
using base::append_bytes;

namespace {

constexpr std::uint8_t array_type = 2, wire_version = 1;
constexpr std::size_t longest_array_name = 64, alignment = 4, size_offset = 76;
constexpr float most_steps = 65535.0f;

void align(std::string& out) {
  while (out.size() % alignment != 0) out += '\0';
}

template <class Item>
std::string encode_items(std::string_view name, std::uint32_t body, std::uint8_t kind,
                         std::span<const Item> items) {
  assert(name.size() <= longest_array_name);
  std::string out;
  out.reserve(16 + longest_array_name + items.size_bytes());
  append_bytes(out, array_type);
  append_bytes(out, wire_version);
  append_bytes(out, kind);
  append_bytes(out, static_cast<std::uint8_t>(name.size()));
  append_bytes(out, body);
  append_bytes(out, static_cast<std::uint32_t>(items.size()));
  append_bytes(out, std::uint32_t{0});
  out += name;
  align(out);
  append_array(out, items);
  return out;
}

void append_block(std::string& out, std::span<const float> points) {
  std::array<float, 3> least{}, step{};
  for (std::size_t a = 0; a < 3; ++a) {
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (std::size_t k = a; k < points.size(); k += 3) {
      low = std::min(low, points[k]);
      high = std::max(high, points[k]);
    }
    least[a] = points.empty() ? 0.0f : low;
    step[a] = points.empty() ? 0.0f : (high - low) / most_steps;
  }
  append_bytes(out, least);
  append_bytes(out, step);
  append_bytes(out, static_cast<std::uint32_t>(points.size() / 3));
  append_bytes(out, std::uint32_t{0});
  std::array<float, 3> scale{};
  for (std::size_t a = 0; a < 3; ++a) scale[a] = step[a] > 0.0f ? 1.0f / step[a] : 0.0f;
  const std::size_t begin = out.size();
  out.resize(begin + 2 * points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const std::size_t a = k % 3;
    const float place = (points[k] - least[a]) * scale[a] + 0.5f;
    const float number = place >= 0.0f ? std::min(place, most_steps) : 0.0f;  // NaN becomes 0, too
    const auto rounded = static_cast<std::uint16_t>(number);
    out[begin + 2 * k] = static_cast<char>(rounded & 0xff);
    out[begin + 2 * k + 1] = static_cast<char>(rounded >> 8);
  }
  align(out);
}

}  // namespace

std::string encode_array(std::string_view name, std::uint32_t body, std::span<const std::uint8_t> items) {
  return encode_items(name, body, 1, items);
}
std::string encode_array(std::string_view name, std::uint32_t body, std::span<const std::uint32_t> items) {
  return encode_items(name, body, 2, items);
}
std::string encode_array(std::string_view name, std::uint32_t body, std::span<const float> items) {
  return encode_items(name, body, 3, items);
}

std::string encode_frame(const FrameNumbers& numbers, std::span<const BlockPoints> blocks, FrameOf of) {
  std::uint16_t bits = 0;
  for (const BlockPoints& block : blocks)
    bits = static_cast<std::uint16_t>(bits | static_cast<unsigned>(block.block));
  std::string out;
  append_bytes(out, static_cast<std::uint8_t>(of));
  append_bytes(out, wire_version);
  append_bytes(out, bits);
  append_bytes(out, numbers.sequence);
  append_bytes(out, numbers.body);
  append_bytes(out, numbers.revision);
  append_bytes(out, numbers.frame);
  append_bytes(out, numbers.flags);
  append_bytes(out, numbers.time);
  append_bytes(out, numbers.position_hash);
  append_bytes(out, numbers.seconds);
  append_bytes(out, numbers.rate);
  append_bytes(out, numbers.lag);
  append_bytes(out, numbers.largest_lag);
  append_bytes(out, numbers.energy);
  append_bytes(out, numbers.volume);
  append_bytes(out, numbers.inverted);
  append_bytes(out, std::uint32_t{0});
  append_bytes(out, numbers.speed);
  assert(out.size() == size_offset);
  append_bytes(out, std::uint32_t{0});
  for (const BlockPoints& block : blocks) append_block(out, block.points);
  const auto size = static_cast<std::uint32_t>(out.size());
  std::string bytes;
  append_bytes(bytes, size);
  out.replace(size_offset, bytes.size(), bytes);
  return out;
}

}  // namespace fascicle::studio
