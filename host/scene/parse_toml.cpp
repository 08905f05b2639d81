#include "host/scene/parse_toml.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "host/base/text.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

constexpr std::size_t most_key_parts = 32;
constexpr std::size_t deepest_nesting = 32;
// toml++ looks 127 characters ahead for the time after a date, and does not count underscores.
constexpr std::size_t most_underscores = 64;
// toml++ keeps the tables made by dotted keys and headers in lists, and searches them for each further one,
// so its time grows quadratically. Ten thousand jobs have 30,000.
constexpr std::size_t most_key_dots = 50'000;

class Checked {
 public:
  Checked(std::string_view text, std::string_view source) : text_(text), source_(source) {}

  void check() const {
    if (text_.size() > most_toml_bytes)
      fail_at(0, "has more than the " + std::to_string(most_toml_bytes) + " bytes that are read");
    check_encoding();
    check_depth();
  }

 private:
  void check_encoding() const {
    for (std::string_view rest = text_; !rest.empty();) {
      const std::size_t at = text_.size() - rest.size();
      const std::optional<char32_t> code_point = base::take_code_point(rest);
      if (!code_point) fail_at(at, "not valid UTF-8; save the file in that encoding");
      if (*code_point == 0) fail_at(at, "a zero byte; is this a text file?");
    }
  }

  // Counts the parts of a key, open brackets, underscores in a word and the dots of all keys, outside strings
  // and comments. For valid TOML this matches what toml++ sees; at the first error, toml++ stops reading.
  void check_depth() const {
    std::size_t parts = 1, underscores = 0, key_dots = 0;
    std::string open;  // brackets
    bool in_key = true;
    for (std::size_t at = 0; at < text_.size();) {
      const char c = text_[at];
      if (c == '#') {
        at = std::min(text_.find('\n', at), text_.size());
        continue;
      }
      if (c == '"' || c == '\'') {
        at = end_of_string(at);
        continue;
      }
      if (c == '.' && ++parts > most_key_parts)
        fail_at(at, "a key of more than " + std::to_string(most_key_parts) + " parts");
      if (c == '_' && ++underscores > most_underscores)
        fail_at(at, "a word of more than " + std::to_string(most_underscores) + " underscores");
      // The second bracket of [[a]] creates a list, which toml++ searches too.
      if (in_key && (c == '.' || (c == '[' && !open.empty())) && ++key_dots > most_key_dots)
        fail_at(at, "more than " + std::to_string(most_key_dots) +
                        " dots in keys and lists of tables in all; divide the file");
      if (c == '[' || c == '{') open += c;
      if (open.size() > deepest_nesting)
        fail_at(at, "nested deeper than " + std::to_string(deepest_nesting) + " levels");
      if ((c == ']' || c == '}') && !open.empty()) open.pop_back();
      if (c == '=' || c == '}') in_key = false;
      if (c == '{' || (c == ',' && open.ends_with('{')) || (c == '\n' && open.empty())) in_key = true;
      if (std::string_view("[]{}=,\n").find(c) != std::string_view::npos) parts = 1;
      if (std::string_view("[]{}=,.\n").find(c) != std::string_view::npos) underscores = 0;
      ++at;
    }
  }

  // One past the string that starts at `at`. An unterminated one ends where toml++ will report it.
  std::size_t end_of_string(std::size_t at) const {
    const char quote = text_[at];
    const bool is_long = text_.substr(at, 3) == std::string(3, quote);
    const std::string end(is_long ? 3 : 1, quote);
    for (at += end.size(); at < text_.size(); ++at) {
      if (text_[at] == '\n' && !is_long) return at;
      if (text_[at] == '\\' && quote == '"') {
        ++at;
      } else if (text_.substr(at, end.size()) == end) {
        at += end.size();
        // Up to two quotes may precede the closing three.
        for (int more = 0; is_long && more < 2 && at < text_.size() && text_[at] == quote; ++more) ++at;
        return at;
      }
    }
    return text_.size();
  }

  [[noreturn]] void fail_at(std::size_t at, const std::string& what) const {
    const std::string_view before = text_.substr(0, at);
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    std::size_t column = 1;
    for (std::string_view rest = before.substr(line_start); !rest.empty(); ++column)
      base::take_code_point(rest);
    const auto line = static_cast<std::uint32_t>(1 + std::count(before.begin(), before.end(), '\n'));
    const toml::source_position position{line, static_cast<std::uint32_t>(column)};
    fail({position, position, std::make_shared<const std::string>(source_)}, "TOML",
         "column " + std::to_string(column) + ": " + what);
  }

  std::string_view text_, source_;
};

}  // namespace

toml::table parse_toml(std::string_view text, std::string_view source) {
  Checked(text, source).check();
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    fail(error.source(), "TOML", error.description());
  }
}

std::string toml_string(const std::string& text) {
  std::ostringstream out;
  out << toml::toml_formatter{toml::value<std::string>(text), toml::format_flags::none};
  return out.str();
}

}  // namespace fascicle::scene
