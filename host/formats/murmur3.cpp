#include "host/formats/murmur3.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace fascicle::formats {

namespace {

constexpr std::uint64_t first_factor = 0x87c37b91114253d5u, second_factor = 0x4cf5ad432745937fu;

std::uint64_t scrambled_low(std::uint64_t k) {
  return std::rotl(k * first_factor, 31) * second_factor;
}

std::uint64_t scrambled_high(std::uint64_t k) {
  return std::rotl(k * second_factor, 33) * first_factor;
}

std::uint64_t finished(std::uint64_t h) {
  h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdu;
  h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53u;
  return h ^ (h >> 33);
}

// Up to eight bytes as a little-endian number.
std::uint64_t word(std::string_view bytes) {
  std::uint64_t value = 0;
  if (!bytes.empty()) std::memcpy(&value, bytes.data(), std::min<std::size_t>(bytes.size(), sizeof value));
  return value;
}

}  // namespace

std::array<std::uint64_t, 2> murmur3_x64_128(std::string_view bytes) {
  const std::uint64_t length = bytes.size();
  std::uint64_t low = 0, high = 0;
  for (; bytes.size() >= 16; bytes.remove_prefix(16)) {
    low ^= scrambled_low(word(bytes));
    low = (std::rotl(low, 27) + high) * 5 + 0x52dce729u;
    high ^= scrambled_high(word(bytes.substr(8)));
    high = (std::rotl(high, 31) + low) * 5 + 0x38495ab5u;
  }
  // A partial word is padded with zero bytes; a zero word changes nothing.
  low ^= scrambled_low(word(bytes));
  high ^= scrambled_high(word(bytes.substr(std::min<std::size_t>(bytes.size(), 8))));
  low ^= length;
  high ^= length;
  low += high;
  high += low;
  low = finished(low);
  high = finished(high);
  low += high;
  high += low;
  return {low, high};
}

}  // namespace fascicle::formats
