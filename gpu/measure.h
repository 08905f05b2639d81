// What a device does in how much time, for fascicle bench.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gpu/device.h"
#include "host/model/solver.h"

namespace fascicle::gpu {

// Bytes a second, read plus written, of copies between two large buffers of the device: by the driver's copy
// or by a shader's, the best of a few.
double copy_rate(Device& device);

// One stage of a substep over all of the model, as it runs when nobody probes.
struct StageTime {
  std::string stage;
  double nanoseconds;  // with the barrier behind it, mean of many in a row
};
// The kernels of the model's plan but skin, tie and those of stage limit. Empty where the device has no
// timestamps, and where a kernel takes several dispatches.
std::vector<StageTime> stage_times(Device& device, const model::Model& model,
                                   const model::SolverOptions& options, const model::Drive& drive);

// Bytes that a substep without a skeleton reads and writes of a vertex: each array once a stage, neighbours'
// places and maps counted with their own vertex. `passes` over the regions: 1, or of an implicit model the
// iterations, whose first and last stages are not counted.
double substep_bytes(const model::Model& model, std::uint32_t passes);

}  // namespace fascicle::gpu
