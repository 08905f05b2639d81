// Measures a device's speed, for fascicle bench.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gpu/device.h"
#include "host/model/solver.h"

namespace fascicle::gpu {

// Bytes per second, read plus written, of copies between two large device buffers: by the driver's copy or by
// a shader, the best of several rounds.
double copy_rate(Device& device);

// One stage of a substep over the whole model, as it runs without a probe.
struct StageTime {
  std::string stage;
  double nanoseconds;  // including the barrier after it, mean of many in a row
};
// The kernels of the model's plan, except skin, tie and those of stage limit. Empty if the device has no
// timestamps, or if a kernel takes several dispatches.
std::vector<StageTime> stage_times(Device& device, const model::Model& model,
                                   const model::SolverOptions& options, const model::Drive& drive);

// Bytes per vertex that a substep without a skeleton reads and writes: each array once per stage, with
// neighbours' positions and maps counted once at their own vertex. `passes` over the regions: 1, or for an
// implicit model the number of iterations; its first and last stages are not counted.
double substep_bytes(const model::Model& model, std::uint32_t passes);

}  // namespace fascicle::gpu
