// The cost of a bake, measured on this machine: printed by --dry-run, and requested from schedulers.
#pragma once

#include <cstdint>

#include "host/bake/bake.h"
#include "host/cli/exit_codes.h"
#include "host/pipeline/bake_scene.h"

namespace fascicle::cli {

struct Estimate {
  std::uint64_t frames = 0;
  std::uint64_t preroll_frames =
      0;                           // before frame 0; settling and the cycles of a seamless loop are not known
  double seconds_substep = 0.0;    // measured, with positions read back once per frame
  double seconds = 0.0;            // of all these frames
  std::uint64_t solver_bytes = 0;  // in memory
  std::uint64_t output_bytes = 0;  // of all files, at most
};
Estimate estimate_of(const PreparedBake& prepared, const bake::BakeOutput& output);

}  // namespace fascicle::cli
