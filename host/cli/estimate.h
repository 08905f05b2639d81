// What a bake will take, measured on this machine: what --dry-run prints, and what a scheduler is asked for.
#pragma once

#include <cstdint>

#include "host/bake/bake.h"
#include "host/cli/exit_codes.h"
#include "host/pipeline/bake_scene.h"

namespace fascicle::cli {

struct Estimate {
  std::uint64_t frames = 0;
  double seconds_substep = 0.0;    // measured, positions brought back once a frame
  double seconds = 0.0;            // of all frames
  std::uint64_t solver_bytes = 0;  // memory
  std::uint64_t output_bytes = 0;  // of the files, at most
};
Estimate estimate_of(const PreparedBake& prepared, const bake::BakeOutput& output);

}  // namespace fascicle::cli
