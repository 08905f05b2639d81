#include "host/cli/text.h"

#include <array>
#include <cstdio>
#include <optional>
#include <string_view>

namespace fascicle::cli {

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string shell_word(const std::string& word) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,@%+-";
  // zsh replaces a word that starts with = by a program's path.
  if (!word.empty() && word.front() != '=' && word.find_first_not_of(plain) == std::string::npos) return word;
  if (shown_text(word) == word) return in_quotes(word);
  std::string out = "$'";
  for (std::string_view rest = word; !rest.empty();) {
    const std::string_view before = rest;
    const std::optional<char32_t> c = base::take_code_point(rest);
    const std::string_view bytes = before.substr(0, before.size() - rest.size());
    if (c == U'\'' || c == U'\\') out += '\\';
    if (c && !base::is_obeyed(*c)) {
      out += bytes;
      continue;
    }
    for (const char byte : bytes) {
      std::array<char, 8> octal{};
      std::snprintf(octal.data(), octal.size(), "\\%03o",
                    static_cast<unsigned>(static_cast<unsigned char>(byte)));
      out += octal.data();
    }
  }
  return out + "'";
}

}  // namespace fascicle::cli
