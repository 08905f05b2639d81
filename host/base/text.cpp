#include "host/base/text.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace fascicle::base {

std::string short_text(double value) {
  return number_text(std::round(value * 100.0) / 100.0);
}

std::string percent_text(double share) {
  return short_text(100.0 * share) + " %";
}

std::string hash_text(std::uint64_t hash) {
  std::array<char, 17> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%016" PRIx64, hash);
  return buffer.data();
}

std::optional<char32_t> take_code_point(std::string_view& text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  bool is_whole = length > 0 && first < 0xf5 && length <= text.size();
  char32_t code_point = length <= 1 ? first : first & (0x7fu >> length);
  for (std::size_t k = 1; is_whole && k < length; ++k) {
    is_whole = (byte(k) & 0xc0u) == 0x80;
    code_point = code_point << 6 | (byte(k) & 0x3fu);
  }
  // Rejects overlong forms, UTF-16 surrogates and values beyond the last code point.
  is_whole = is_whole && !(length == 3 && code_point < 0x800) && !(length == 4 && code_point < 0x10000) &&
             !(code_point >= 0xd800 && code_point < 0xe000) && code_point <= 0x10ffff;
  text.remove_prefix(is_whole ? length : 1);
  return is_whole ? std::optional(code_point) : std::nullopt;
}

bool is_obeyed(char32_t c) {
  const bool is_control = c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 || c == 0x2029;
  const bool turns = c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x202a && c <= 0x202e) ||
                     (c >= 0x2066 && c <= 0x2069);
  return is_control || turns;
}

namespace {

std::string shown(std::string_view text, std::string_view kept) {
  std::string out;
  out.reserve(text.size());
  const auto escape = [&out](const char* format, unsigned value) {
    std::array<char, 12> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, value);
    out += buffer.data();
  };
  while (!text.empty()) {
    const std::string_view before = text;
    const std::optional<char32_t> c = take_code_point(text);
    if (c && (!is_obeyed(*c) || (*c < 0x80 && kept.find(static_cast<char>(*c)) != std::string_view::npos)))
      out += before.substr(0, before.size() - text.size());
    else if (!c)
      escape("\\x%02x", static_cast<unsigned char>(before.front()));
    else if (*c == '\n' || *c == '\t' || *c == '\r')
      out += *c == '\n' ? "\\n" : *c == '\t' ? "\\t" : "\\r";
    else
      escape(*c < 0x20 ? "\\x%02x" : "\\u%04x", static_cast<unsigned>(*c));
  }
  return out;
}

}  // namespace

std::string shown_text(std::string_view text) {
  return shown(text, "");
}

std::string shown_lines(std::string_view text) {
  return shown(text, "\n\t");
}

}  // namespace fascicle::base
