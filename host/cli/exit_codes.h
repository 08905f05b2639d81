// What the executable's exit status means, and the two errors that only the command line can make.
#pragma once

#include <stdexcept>

namespace fascicle::cli {

enum class ExitCode : int {
  done = 0,
  unforeseen = 1,      // disk full, out of memory, a device lost on the way
  bad_usage = 2,       // unknown or contradicting options, a folder that holds a bake already
  bad_input = 3,       // scene, mesh or frame cache that cannot be used
  no_such_device = 4,  // or one that cannot run this model
  not_finite = 5,      // the simulation left the finite numbers
  difference = 6,      // validation found one
  interrupted = 75     // by SIGINT or SIGTERM; --resume goes on (the value is sysexits.h's EX_TEMPFAIL)
};

// An option that cannot be followed. what() says what to do.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A device that was asked for and is not there, or will not do.
struct NoSuchDevice : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace fascicle::cli
