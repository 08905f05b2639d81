// What a program does first, whatever state it was started in.
#pragma once

#include <csignal>
#include <cstdlib>
#include <initializer_list>

#include <fcntl.h>
#include <unistd.h>

namespace fascicle::base {

// Opens standard input, output and error on /dev/null if they are closed: otherwise the next files opened
// would get their numbers, and messages would be written into an output.
inline void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    // open() returns the lowest free number, which is the stream's. Without /dev/null there is no safe way to
    // continue, and no way to report it.
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) != stream) std::_Exit(EXIT_FAILURE);
}

// Makes a write beyond the file size limit fail, as on a full disk, instead of ending the program.
inline void outlive_the_limit_on_files() {
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace fascicle::base
