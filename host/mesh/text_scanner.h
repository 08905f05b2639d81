// Reads words and numbers from the text of a mesh file, always within its bounds and independent of the
// locale. Every error becomes a SceneError "FILE:LINE: what is wrong; what to do".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

class TextScanner {
 public:
  // `text` must outlive the scanner. Everything from `comment` to the end of a line is ignored. Words end
  // before `stop`, and the text counts as ended there until skip_if() or until() passes it. '\0': no such
  // character.
  TextScanner(std::string file, std::string_view text, char comment, char stop = '\0');

  // Skips spaces, line ends and comments. True if nothing follows.
  bool at_end();
  // Skips spaces and comments only. True at the end of the line or of the text.
  bool at_line_end();
  void skip_line();

  // The next word, on this or a later line. `what` says what was expected, for the message.
  std::string_view word(std::string_view what);
  // Like word(), but does not consume it. Empty at the end.
  std::string_view peek();
  // A finite decimal number. Rejects hexadecimal, infinity and NaN.
  double number(std::string_view what);
  Vector3d point(std::string_view what);
  // A whole number in [minimum, maximum].
  std::uint64_t whole(std::string_view what, std::uint64_t minimum = 0, std::uint64_t maximum = UINT64_MAX);
  // How many entries follow, each of at least `bytes_each` characters. Rejects counts that the rest of the
  // text cannot hold, so that it is safe to allocate memory for the result.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  // A vertex number of the file, counted from `base`, converted to an index below `vertices`.
  std::uint32_t index(std::size_t vertices, std::uint64_t base);

  // The text from here up to but excluding `end`, which is skipped too.
  std::string_view until(std::string_view end);
  // Skips `text` if it comes next.
  bool skip_if(std::string_view text);

  std::size_t remaining() const { return text_.size() - position_; }
  // The line of the last word read, counted from 1.
  std::size_t line() const;
  // Throws a SceneError at the last word read.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string file_;
  std::string_view text_;
  std::size_t position_ = 0;
  std::size_t word_start_ = 0;
  char comment_;
  char stop_;
};

// A word made safe for a message: shortened, in quotes, control characters and non-ASCII replaced.
std::string shown(std::string_view word);

}  // namespace fascicle::mesh
