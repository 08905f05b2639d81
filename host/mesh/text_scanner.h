// Reads words and numbers from the text of a mesh file, always within its bounds and in no locale. Every
// complaint becomes a SceneError "FILE:LINE: what is wrong; what to do".
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/mesh/mesh.h"

namespace fascicle::mesh {

class TextScanner {
 public:
  // `text` must outlive the scanner. From `comment` to the end of a line nothing counts. Words end before
  // `stop`, and where it stands the text counts as ended, until skip_if() or until() passes it. '\0': no such
  // character.
  TextScanner(std::string file, std::string_view text, char comment, char stop = '\0');

  // Moves over blanks, line ends and comments. True if nothing follows.
  bool at_end();
  // Moves over blanks and comments only. True if the line, or the text, ends here.
  bool at_line_end();
  void skip_line();

  // The next word, from this or a later line. `what` says what was expected, for the message.
  std::string_view word(std::string_view what);
  // Like word(), but leaves it there. Empty at the end.
  std::string_view peek();
  // A finite decimal number. No hexadecimal, no infinity, no nan.
  double number(std::string_view what);
  Vector3d point(std::string_view what);
  // A whole number in [minimum, maximum].
  std::uint64_t whole(std::string_view what, std::uint64_t minimum = 0, std::uint64_t maximum = UINT64_MAX);
  // How many of something follow, each of at least `bytes_each` characters. Refuses counts that the rest of
  // the text cannot hold, so that memory may be taken for what this returns.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  // A vertex number of the file, counted from `base`, turned into an index below `vertices`.
  std::uint32_t index(std::size_t vertices, std::uint64_t base);

  // The text from here up to and without `end`, which is passed over too.
  std::string_view until(std::string_view end);
  // Passes over `text` if it stands right here.
  bool skip_if(std::string_view text);

  std::size_t remaining() const { return text_.size() - position_; }
  // The line of the word read last, from 1.
  std::size_t line() const;
  // Complains at the word read last.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string file_;
  std::string_view text_;
  std::size_t position_ = 0;
  std::size_t word_start_ = 0;
  char comment_;
  char stop_;
};

// A word as a message may show it: short, in quotes, control characters and non-ASCII replaced.
std::string shown(std::string_view word);

}  // namespace fascicle::mesh
