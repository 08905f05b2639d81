// Decodes the output of RangeEncoder and NumberEncoder, written from docs/formats.md; with maps for tables
// and 64-bit arithmetic.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace fascicle::tests {

class RangeDecoder {
 public:
  explicit RangeDecoder(std::string bytes);
  bool bit(std::uint64_t& of_zero);
  std::uint64_t plain(unsigned count);
  // Unread bytes.
  std::size_t left_over() const { return bytes_.size() - at_; }

 private:
  void refill();
  std::string bytes_;
  std::size_t at_ = 0;
  std::uint64_t range_ = 0xffffffff, code_ = 0;
};

class NumberDecoder {
 public:
  std::int64_t take(RangeDecoder& from, std::uint64_t context);

 private:
  std::uint64_t& at(std::uint64_t a, std::uint64_t b) {
    return of_zero_.try_emplace({a, b}, 2048).first->second;
  }
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> of_zero_;
};

}  // namespace fascicle::tests
