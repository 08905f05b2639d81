// Numbers as text, independent of the locale; and text from files made safe for a terminal.
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

// At most two decimals: 0.55, 2.6, 12.
std::string short_text(double value);

// A fraction of 1 as a percentage with at most two decimals: 2.55 %, 12 %; 0 % below 0.005 %.
std::string percent_text(double share);

// 16 lower-case hexadecimal digits.
std::string hash_text(std::uint64_t hash);

// Removes a code point from the front of UTF-8 text. If the bytes are not valid UTF-8, returns nothing and
// removes one byte.
std::optional<char32_t> take_code_point(std::string_view& text);

// Whether a terminal acts on this code point instead of showing it: control characters, and those that change
// the direction of text, so that it reads differently from what it is.
bool is_obeyed(char32_t code_point);

// Text that is safe to show in a terminal: code points it would act on become \n, \t, \x1b or \u202e, and so
// do bytes that are not UTF-8.
std::string shown_text(std::string_view text);
// The same for text of several lines: line ends and tabs are kept.
std::string shown_lines(std::string_view text);

}  // namespace fascicle::base
