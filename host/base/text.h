// Numbers as text, the same in every locale.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <string>
#include <type_traits>

namespace fascicle::base {

// The shortest decimal that reads back as the same number.
template <class Number>
requires std::is_arithmetic_v<Number> std::string number_text(Number value) {
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), end.ptr};
}

// Two digits after the point: 0.55, 2.6, 12.
std::string short_text(double value);

// A share of 1 with at most two digits after the point: 2.55 %, 12 %; 0 % below 0.005 %.
std::string percent_text(double share);

// 16 lower-case hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace fascicle::base
