// Standard output that is safe to show to people.
#pragma once

#include <ostream>
#include <streambuf>
#include <string>

namespace fascicle::cli {

// During its lifetime, a stream's output passes through base::shown_lines, so that a joint's name cannot
// control the terminal. Escapes of non-ASCII characters are those of JSON and TOML, so such texts keep their
// meaning. A line is written once it is complete or the stream is flushed.
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
