// What the executable's exit status means.
#pragma once

#include "host/pipeline/errors.h"

namespace fascicle::pipeline {}

namespace fascicle::cli {

// The command line says in its own words what host/pipeline does.
using namespace pipeline;

enum class ExitCode : int {
  done = 0,
  unforeseen = 1,      // disk full, out of memory
  bad_usage = 2,       // unknown or contradicting options, a folder that holds a bake already
  bad_input = 3,       // scene, mesh or files of a bake that cannot be used
  no_such_device = 4,  // or one that cannot run this model
  not_finite = 5,      // the simulation left the finite numbers
  difference = 6,      // validation found one
  device_failed = 7,   // or was lost on the way; --resume goes on
  interrupted = 75     // by SIGINT or SIGTERM; --resume goes on (the value is sysexits.h's EX_TEMPFAIL)
};

}  // namespace fascicle::cli
