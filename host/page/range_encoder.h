// An adaptive binary range coder. docs/formats.md describes its output.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fascicle::page {

// Probability of a 0 bit, in 4096ths; adapts to the coded bits.
struct Probability {
  std::uint16_t of_zero = 2048;
};

class RangeEncoder {
 public:
  void bit(Probability& probability, bool one);
  // Codes the lowest `count` bits, highest first, with equal probabilities.
  void direct(std::uint32_t bits, unsigned count);
  // Returns all bytes; nothing may be coded afterwards.
  std::string finish();

 private:
  void normalise();
  void shift();

  std::string bytes_;
  std::uint64_t low_ = 0;  // 32 bits and a carry
  std::uint32_t range_ = 0xffffffffu;
  std::uint8_t held_ = 0;         // the last byte, which a carry may still change
  std::uint64_t held_count_ = 1;  // that byte and the 0xff bytes after it
};

// Codes integers of at most 30 bits plus sign; small ones are cheapest. The caller chooses the context by the
// expected size.
class NumberEncoder {
 public:
  explicit NumberEncoder(std::size_t contexts) : contexts_(contexts) {}
  void put(RangeEncoder& to, std::int32_t number, std::size_t context);

 private:
  struct Context {
    std::array<Probability, 32> length;  // binary tree of the number of bits
    Probability sign;
  };
  std::vector<Context> contexts_;
  std::array<std::array<Probability, 4>, 32> low_{};  // by length: the two bits below the highest
};

// Approximate cost of a number in bits, for choosing between predictions.
unsigned bit_length(std::int64_t number);

}  // namespace fascicle::page
