#include "tests/page/range_decoder.h"

#include <stdexcept>

namespace fascicle::tests {

RangeDecoder::RangeDecoder(std::string bytes) : bytes_(std::move(bytes)) {
  for (at_ = 0; at_ < 5; ++at_) code_ = 256 * code_ + static_cast<std::uint8_t>(bytes_.at(at_));
}

void RangeDecoder::refill() {
  for (; range_ < 0x1000000; range_ *= 256) {
    if (at_ == bytes_.size()) throw std::out_of_range("the bytes end too early");
    code_ = 256 * code_ + static_cast<std::uint8_t>(bytes_[at_++]);
  }
}

bool RangeDecoder::bit(std::uint64_t& of_zero) {
  const std::uint64_t bound = range_ / 4096 * of_zero;
  const bool one = code_ >= bound;
  if (one) {
    code_ -= bound;
    range_ -= bound;
    of_zero -= of_zero / 32;
  } else {
    range_ = bound;
    of_zero += (4096 - of_zero) / 32;
  }
  refill();
  return one;
}

std::uint64_t RangeDecoder::plain(unsigned count) {
  std::uint64_t bits = 0;
  for (; count > 0; --count) {
    range_ /= 2;
    const bool one = code_ >= range_;
    if (one) code_ -= range_;
    bits = 2 * bits + (one ? 1 : 0);
    refill();
  }
  return bits;
}

std::int64_t NumberDecoder::take(RangeDecoder& from, std::uint64_t context) {
  constexpr std::uint64_t of_low = 1000000;
  std::uint64_t node = 1;
  while (node < 32) node = 2 * node + (from.bit(at(context, node)) ? 1 : 0);
  const auto length = static_cast<unsigned>(node - 32);
  if (length == 0) return 0;
  const bool negative = from.bit(at(context, 0));
  std::uint64_t value = 1;
  unsigned left = length - 1;
  if (left > 0) {
    value = 2 * value + (from.bit(at(of_low + length, 1)) ? 1 : 0);
    --left;
  }
  if (left > 0) {
    value = 2 * value + (from.bit(at(of_low + length, 2 + (value & 1))) ? 1 : 0);
    --left;
  }
  value = (value << left) + from.plain(left);
  return negative ? -static_cast<std::int64_t>(value) : static_cast<std::int64_t>(value);
}

}  // namespace fascicle::tests
