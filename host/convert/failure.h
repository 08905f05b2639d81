// The exit statuses of fascicle-convert; --help lists them. One line on stderr gives the reason in words.
#pragma once

#include <stdexcept>
#include <string>

namespace fascicle::convert {

enum ExitCode : int {
  done = 0,
  bad_usage = 2,
  unreadable = 3,  // the file is missing, malformed, or contains no triangles
  cannot_write = 4,
  out_of_memory = 6,
};

// Ends the program with this exit status after printing the text to stderr.
struct Failure : std::runtime_error {
  Failure(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

}  // namespace fascicle::convert
