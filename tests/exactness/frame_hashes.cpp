// frame_hashes SCENE FRAMES cpu:THREADS[:LEVEL]|vulkan:N...
// Builds a scene once, steps it on each device as bake does, and prints "on DEVICE" and then each frame's
// number and the hashes of its positions, velocities and surface. The exactness tests run this program
// compiled at several optimisation levels, on several devices and under several C library settings, and
// compare what it prints.
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "host/model/validate.h"
#include "host/scene/scene.h"
#ifdef FASCICLE_WITH_VULKAN
#include "gpu/device.h"
#include "gpu/vulkan_solver.h"
#endif

using namespace fascicle;

namespace {

unsigned long long hash_of(const std::vector<float>& values) {
  if (values.empty()) throw std::runtime_error("the solver gave back an empty buffer");
  model::Frame frame;
  frame.positions = values;
  return model::position_hash(frame);
}

void step_on(const std::string& device, std::uint64_t frames, const scene::Scene& scene,
             const model::Model& model, const build::Steps& steps) {
  const model::SolverOptions solver_options{
      .integrator = model.is_implicit() ? model::Integrator::implicit_step : model::Integrator::explicit_step,
      .rotation = scene.solver.rotation,
      .iterations = steps.iterations,
      .viscosity = scene.solver.viscosity};
  const auto number = static_cast<unsigned>(std::stoul(device.substr(device.find(':') + 1)));
#ifdef FASCICLE_WITH_VULKAN
  std::unique_ptr<gpu::Device> gpu_device;  // outlives the solver
#endif
  std::unique_ptr<model::Solver> solver;
#ifdef FASCICLE_WITH_VULKAN
  if (device.rfind("vulkan:", 0) == 0) {
    gpu_device = std::make_unique<gpu::Device>(number);
    solver = gpu::make_vulkan_solver(*gpu_device, model, solver_options);
  }
#endif
  if (!solver) {
    const std::size_t second = device.find(':', device.find(':') + 1);
    auto simd = std::optional(cpu_reference::Simd::automatic);
    if (second != std::string::npos) simd = cpu_reference::simd_named(device.substr(second + 1));
    if (!simd) throw std::runtime_error(device + ": no such level");
    solver = cpu_reference::make_cpu_solver(model, solver_options, number, *simd);
  }
  std::printf("on %s\n", device.c_str());
  drive::DriveSource drives(scene, model, steps.substeps);
  solver->load(drive::lead_in(scene, model, drives, *solver).state);
  for (std::uint64_t k = 1; k <= frames; ++k) {
    solver->submit(drives.drive(k), {.positions = true, .velocities = true, .surface = true});
    const model::Frame frame = solver->collect();
    std::printf("%llu %016llx %016llx %016llx\n", static_cast<unsigned long long>(k),
                hash_of(frame.positions), hash_of(frame.velocities), hash_of(frame.surface));
  }
}

void run(const std::string& name, std::uint64_t frames, const std::vector<std::string>& devices) {
  const scene::Scene scene = scene::load_scene(name);
  build::Report report;
  build::BuildOptions options;
#ifdef FASCICLE_MESHER
  options.mesher = FASCICLE_MESHER;
#endif
  const model::Model model = build::build_model(scene, report, options);
  model::check_model(model);
  const build::Steps steps = build::choose_steps(scene, model, report);
  for (const std::string& device : devices) step_on(device, frames, scene, model, steps);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: frame_hashes SCENE FRAMES cpu:THREADS[:LEVEL]|vulkan:N...\n");
    return 2;
  }
  try {
    run(argv[1], std::stoull(argv[2]), {argv + 3, argv + argc});
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "frame_hashes: %s\n", error.what());
    return 1;
  }
}
