// VulkanSolver: the float solver in compute shaders. Make one for a model that has passed check_model, then
// submit a Drive for each frame and collect its positions, see host/model/solver.h.
#pragma once

#include <memory>

#include "gpu/device.h"
#include "host/model/solver.h"

namespace fascicle::gpu {

// Throws gpu::DeviceError if the model does not fit the device's limits, with the numbers. The device and the
// model must outlive the solver. After a DeviceError from a call of the solver, its state is undefined until
// load() succeeds; after a DeviceLost it can only be destroyed.
std::unique_ptr<model::Solver> make_vulkan_solver(Device& device, const model::Model& model,
                                                  const model::SolverOptions& options);

}  // namespace fascicle::gpu
