#include "host/page/range_encoder.h"

#include <bit>
#include <cassert>
#include <cstdlib>
#include <utility>

namespace fascicle::page {

namespace {

constexpr unsigned probability_bits = 12, adaption = 5;
constexpr std::uint32_t least_range = 1u << 24;

}  // namespace

void RangeEncoder::bit(Probability& probability, bool one) {
  const std::uint32_t bound = (range_ >> probability_bits) * probability.of_zero;
  if (one) {
    low_ += bound;
    range_ -= bound;
    probability.of_zero = static_cast<std::uint16_t>(probability.of_zero - (probability.of_zero >> adaption));
  } else {
    range_ = bound;
    probability.of_zero = static_cast<std::uint16_t>(
        probability.of_zero + (((1u << probability_bits) - probability.of_zero) >> adaption));
  }
  normalise();
}

void RangeEncoder::direct(std::uint32_t bits, unsigned count) {
  while (count-- > 0) {
    range_ >>= 1;
    if ((bits >> count & 1u) != 0) low_ += range_;
    normalise();
  }
}

void RangeEncoder::normalise() {
  while (range_ < least_range) {
    range_ <<= 8;
    shift();
  }
}

// Outputs a byte only when no later carry can change it.
void RangeEncoder::shift() {
  if (low_ < 0xff000000u || low_ > 0xffffffffu) {
    const auto carry = static_cast<std::uint8_t>(low_ >> 32);
    bytes_ += static_cast<char>(held_ + carry);
    for (; held_count_ > 1; --held_count_) bytes_ += static_cast<char>(0xff + carry);
    held_ = static_cast<std::uint8_t>(low_ >> 24);
    held_count_ = 0;
  }
  ++held_count_;
  low_ = (low_ & 0x00ffffffu) << 8;
}

std::string RangeEncoder::finish() {
  for (int k = 0; k < 5; ++k) shift();
  return std::move(bytes_);
}

unsigned bit_length(std::int64_t number) {
  return static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(std::llabs(number))));
}

void NumberEncoder::put(RangeEncoder& to, std::int32_t number, std::size_t context) {
  Context& in = contexts_[context];
  const unsigned length = bit_length(number);
  assert(length <= 30);
  std::size_t node = 1;
  for (unsigned k = 5; k-- > 0;) {
    const bool one = (length >> k & 1u) != 0;
    to.bit(in.length[node], one);
    node = 2 * node + (one ? 1 : 0);
  }
  if (length == 0) return;
  to.bit(in.sign, number < 0);
  const auto size = static_cast<std::uint32_t>(std::abs(number));
  unsigned left = length - 1;
  node = 1;
  for (unsigned k = 0; k < 2 && left > 0; ++k) {
    const bool one = (size >> --left & 1u) != 0;
    to.bit(low_[length][node], one);
    node = 2 * node + (one ? 1 : 0);
  }
  to.direct(size & ((1u << left) - 1u), left);
}

}  // namespace fascicle::page
