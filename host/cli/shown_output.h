// Standard output as people may be shown it.
#pragma once

#include <ostream>
#include <streambuf>
#include <string>

namespace fascicle::cli {

// While it lives, what goes to a stream passes base::shown_lines: a joint's name cannot make the terminal
// obey. Escapes above ASCII are those of JSON and TOML, so that their texts stay what they are. A line goes
// out once it is whole or the stream is flushed.
class ShownOutput final : public std::streambuf {
 public:
  explicit ShownOutput(std::ostream& stream);
  ~ShownOutput() override;
  ShownOutput(const ShownOutput&) = delete;
  ShownOutput& operator=(const ShownOutput&) = delete;

 private:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override;
  bool put_out(std::size_t count);

  std::ostream& stream_;
  std::streambuf* below_;
  std::string waiting_;
};

}  // namespace fascicle::cli
