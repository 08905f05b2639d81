#include "host/base/display_width.h"

#include <algorithm>
#include <array>

#include "host/base/text.h"

namespace fascicle::base {

namespace {

struct Range {
  char32_t first, last;
};

template <std::size_t count>
bool is_in(const std::array<Range, count>& ranges, char32_t c) {
  return std::any_of(ranges.begin(), ranges.end(),
                     [c](const Range& range) { return c >= range.first && c <= range.last; });
}

// The blocks that names are likely to use, not all of Unicode's tables: the C library's wcwidth depends on
// the locale. Marks of European, Hebrew, Arabic and Japanese letters, joiners and variation selectors.
constexpr std::array<Range, 14> marks{{{0x300, 0x36f},
                                       {0x483, 0x489},
                                       {0x591, 0x5bd},
                                       {0x610, 0x61a},
                                       {0x64b, 0x65f},
                                       {0x1ab0, 0x1aff},
                                       {0x1dc0, 0x1dff},
                                       {0x200b, 0x200d},
                                       {0x20d0, 0x20ff},
                                       {0x3099, 0x309a},
                                       {0xfe00, 0xfe0f},
                                       {0xfe20, 0xfe2f},
                                       {0xfeff, 0xfeff},
                                       {0xe0100, 0xe01ef}}};
// Chinese, Japanese and Korean letters, full-width forms and pictures.
constexpr std::array<Range, 10> wide_letters{{{0x1100, 0x115f},
                                              {0x2e80, 0x303e},
                                              {0x3041, 0xa4cf},
                                              {0xa960, 0xa97f},
                                              {0xac00, 0xd7a3},
                                              {0xf900, 0xfaff},
                                              {0xff00, 0xff60},
                                              {0xffe0, 0xffe6},
                                              {0x1f300, 0x1faff},
                                              {0x20000, 0x3fffd}}};

}  // namespace

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const char32_t c = take_code_point(text).value_or(U'?');
    width += is_in(marks, c) ? 0u : is_in(wide_letters, c) ? 2u : 1u;
  }
  return width;
}

}  // namespace fascicle::base
