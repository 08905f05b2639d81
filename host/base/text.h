// Numbers as text, the same in every locale; and text from files as a terminal may show it.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
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

// Takes a code point off the front of UTF-8. Where the bytes there are none, nothing, and one byte goes.
std::optional<char32_t> take_code_point(std::string_view& text);

// Whether a terminal obeys this code point instead of showing it: controls, and what turns the direction in
// which text runs, so that it reads otherwise than it is.
bool is_obeyed(char32_t code_point);

// Text as a terminal may show it: what it would obey becomes \n, \t, \x1b or \u202e, and so do bytes that are
// no UTF-8.
std::string shown_text(std::string_view text);
// The same of text of several lines: line ends and tabs stay.
std::string shown_lines(std::string_view text);

}  // namespace fascicle::base
