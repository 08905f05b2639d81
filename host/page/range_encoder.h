// An adaptive binary range coder: what is likely takes less than a bit. docs/formats.md describes its bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fascicle::page {

// Of a bit being 0, in 4096ths; adapts to what was coded.
struct Probability {
  std::uint16_t of_zero = 2048;
};

class RangeEncoder {
 public:
  void bit(Probability& probability, bool one);
  // The lowest `count` bits, the highest first, as likely 0 as 1.
  void direct(std::uint32_t bits, unsigned count);
  // All bytes; nothing may be coded after it.
  std::string finish();

 private:
  void normalise();
  void shift();

  std::string bytes_;
  std::uint64_t low_ = 0;  // 32 bits and a carry
  std::uint32_t range_ = 0xffffffffu;
  std::uint8_t held_ = 0;         // the last byte, which a carry may still change
  std::uint64_t held_count_ = 1;  // it and the 0xff bytes after it
};

// Whole numbers of at most 30 bits beside the sign, small ones best. Contexts are told apart by what a
// number's size is likely to be.
class NumberEncoder {
 public:
  explicit NumberEncoder(std::size_t contexts) : contexts_(contexts) {}
  void put(RangeEncoder& to, std::int32_t number, std::size_t context);

 private:
  struct Context {
    std::array<Probability, 32> length;  // a tree over the number of bits
    Probability sign;
  };
  std::vector<Context> contexts_;
  std::array<std::array<Probability, 4>, 32> low_{};  // by length: the two bits below the highest
};

// About how many bits a number takes, for choosing between codes.
unsigned bit_length(std::int64_t number);

}  // namespace fascicle::page
