// What a program does before anything else, whatever it was started with.
#pragma once

#include <csignal>
#include <cstdlib>
#include <initializer_list>

#include <fcntl.h>
#include <unistd.h>

namespace fascicle::base {

// Opens what is closed of standard input, output and error on /dev/null: else the next files that are opened
// would have their numbers, and messages would go into an output.
inline void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    // The lowest free number is the stream's. Without /dev/null there is no safe way on, and nobody to tell.
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) != stream) std::_Exit(EXIT_FAILURE);
}

// A write beyond the limit on the size of files then fails, as on a full disk, in place of ending the
// program.
inline void outlive_the_limit_on_files() {
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace fascicle::base
