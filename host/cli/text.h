// Numbers as people read them, under the command line's own name, and words as shells read them.
#pragma once

#include <string>

#include "host/pipeline/text.h"

namespace fascicle::cli {

using pipeline::bits_text;
using pipeline::bytes_text;
using pipeline::columns_text;
using pipeline::count_text;
using pipeline::duration_text;
using pipeline::float_text;
using pipeline::number_text;

// Within '...' of a POSIX shell, or of fish.
inline std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// A word for a POSIX shell, quoted where it must be.
inline std::string shell_word(const std::string& word) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,@%+-";
  return !word.empty() && word.find_first_not_of(plain) == std::string::npos ? word : in_quotes(word);
}

}  // namespace fascicle::cli
