// The executable's exit status.
#pragma once

#include "host/pipeline/errors.h"

namespace fascicle::pipeline {}

namespace fascicle::cli {

// The command line uses the names of host/pipeline unqualified.
using namespace pipeline;

enum class ExitCode : int {
  done = 0,
  unforeseen = 1,      // disk full, out of memory
  bad_usage = 2,       // unknown or conflicting options, or a folder that already holds a bake
  bad_input = 3,       // unusable scene, mesh or files of a bake
  no_such_device = 4,  // or it cannot run this model
  not_finite = 5,      // non-finite values in the simulation
  difference = 6,      // found by validation
  device_failed = 7,   // or was lost during the bake; --resume continues
  interrupted = 75     // by SIGINT or SIGTERM; --resume continues (EX_TEMPFAIL of sysexits.h)
};

}  // namespace fascicle::cli
