#include "host/mesh/text_scanner.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "host/base/errors.h"

namespace fascicle::mesh {
namespace {

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
bool is_space(char c) {
  return is_blank(c) || c == '\n';
}

}  // namespace

TextScanner::TextScanner(std::string file, std::string_view text, char comment, char stop)
    : file_(std::move(file)), text_(text), comment_(comment), stop_(stop) {}

bool TextScanner::at_end() {
  while (at_line_end() && position_ < text_.size()) ++position_;
  return position_ == text_.size() || (stop_ != '\0' && text_[position_] == stop_);
}

bool TextScanner::at_line_end() {
  while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
  if (comment_ != '\0' && position_ < text_.size() && text_[position_] == comment_) {
    position_ = std::min(text_.find('\n', position_), text_.size());
  }
  return position_ == text_.size() || text_[position_] == '\n';
}

void TextScanner::skip_line() {
  const std::size_t end = text_.find('\n', position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
}

std::string_view TextScanner::peek() {
  if (at_end()) return {};
  std::size_t end = position_;
  const auto ends_word = [&](char c) { return is_space(c) || (c != '\0' && (c == comment_ || c == stop_)); };
  while (end < text_.size() && !ends_word(text_[end])) ++end;
  return text_.substr(position_, end - position_);
}

std::string_view TextScanner::word(std::string_view what) {
  const std::string_view found = peek();
  word_start_ = position_;
  if (found.empty()) {
    fail("the file ends where " + std::string(what) + " should follow; it may be cut short, export it again");
  }
  position_ += found.size();
  return found;
}

double TextScanner::number(std::string_view what) {
  const std::string_view found = word(what);
  const char* first = found.data();
  const char* last = first + found.size();
  if (found.size() > 1 && *first == '+' && first[1] != '-') ++first;
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (error == std::errc::result_out_of_range) {
    fail(std::string(what) + " is " + shown(found) + ", beyond the range of double; scale the mesh");
  }
  if (error != std::errc{} || end != last) {
    fail(std::string(what) + " is " + shown(found) + ", not a decimal number; correct it");
  }
  if (!std::isfinite(value)) fail(std::string(what) + " is " + shown(found) + ", not finite; correct it");
  return value;
}

Vector3d TextScanner::point(std::string_view what) {
  const double x = number(what);
  const double y = number(what);
  const double z = number(what);
  return {x, y, z};
}

std::uint64_t TextScanner::whole(std::string_view what, std::uint64_t minimum, std::uint64_t maximum) {
  const std::string_view found = word(what);
  std::uint64_t value = 0;
  const char* last = found.data() + found.size();
  const auto [end, error] = std::from_chars(found.data(), last, value);
  if (error != std::errc{} || end != last) {
    fail(std::string(what) + " is " + shown(found) + ", not a whole number; correct it");
  }
  if (value < minimum || value > maximum) {
    fail(std::string(what) + " is " + shown(found) + ", not between " + std::to_string(minimum) + " and " +
         std::to_string(maximum) + "; correct it");
  }
  return value;
}

std::size_t TextScanner::count(std::string_view what, std::size_t bytes_each) {
  const std::uint64_t value = whole(what);
  // The last entry needs no space or line end after it: hence the + 1.
  if (value > (remaining() + 1) / bytes_each) {
    fail(std::string(what) + " is " + std::to_string(value) + ", more than the rest of the file (" +
         std::to_string(remaining()) + " bytes) can hold; the count is wrong or the file is cut short");
  }
  return static_cast<std::size_t>(value);
}

std::uint32_t TextScanner::index(std::size_t vertices, std::uint64_t base) {
  const std::uint64_t value = whole("a vertex number");
  if (vertices == 0) fail("a vertex number, but this file has no vertices; export it again");
  if (value < base || value - base >= vertices) {
    fail("vertex number " + std::to_string(value) + " is not between " + std::to_string(base) + " and " +
         std::to_string(base + vertices - 1) + ", the vertices of this file; correct it");
  }
  return static_cast<std::uint32_t>(value - base);
}

std::string_view TextScanner::until(std::string_view end) {
  word_start_ = position_;
  const std::size_t found = text_.find(end, position_);
  if (found == std::string_view::npos) {
    fail("the file ends without " + shown(end) + "; it may be cut short, export it again");
  }
  const std::string_view between = text_.substr(position_, found - position_);
  position_ = found + end.size();
  return between;
}

bool TextScanner::skip_if(std::string_view text) {
  if (text_.substr(position_, text.size()) != text) return false;
  position_ += text.size();
  return true;
}

std::size_t TextScanner::line() const {
  const std::string_view before = text_.substr(0, word_start_);
  return 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
}

void TextScanner::fail(const std::string& what) const {
  throw base::SceneError(file_ + ":" + std::to_string(line()) + ": " + what);
}

std::string shown(std::string_view word) {
  constexpr std::size_t longest = 32;
  std::string text = "\"";
  for (const char c : word.substr(0, longest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > longest ? "...\"" : "\"");
}

}  // namespace fascicle::mesh
