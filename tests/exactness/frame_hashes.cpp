// frame_hashes SCENE FRAMES cpu:THREADS[:LEVEL]|vulkan:N...
// Builds a scene once, steps it on each device as bake does, and prints "on DEVICE" and then each frame's
// number and the hashes of its positions, velocities and surface. The exactness tests run this program
// compiled at several optimisation levels, on several devices and under several C library settings, and
// compare what it prints.
//
// Programs that differ from the release build only in the solver need not build the model again: the first of
// them leaves it in the folder FASCICLE_KEPT_MODEL, and the others read it there.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cpu_reference/solver/cpu_solver.h"
#ifdef FASCICLE_KEEPS_MODELS
#include "host/bake/model_file.h"
#endif
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

struct Body {
  model::Model model;
  build::Steps steps;
};

Body built(const scene::Scene& scene) {
  build::Report report;
  build::BuildOptions options;
#ifdef FASCICLE_MESHER
  options.mesher = FASCICLE_MESHER;
#endif
  Body body;
  body.model = build::build_model(scene, report, options);
  model::check_model(body.model);
  body.steps = build::choose_steps(scene, body.model, report);
  return body;
}

Body body_of(const scene::Scene& scene) {
#ifdef FASCICLE_KEEPS_MODELS
  if (const char* folder = std::getenv("FASCICLE_KEPT_MODEL")) {
    const std::filesystem::path steps = std::filesystem::path(folder) / "steps",
                                file = std::filesystem::path(folder) / bake::model_file_name;
    if (std::filesystem::exists(steps)) {
      Body body{bake::read_model_file(file, std::nullopt), {}};
      std::ifstream(steps) >> body.steps.substeps >> body.steps.iterations;
      return body;
    }
    Body body = built(scene);
    const std::string bytes = bake::encode_model(body.model);
    std::ofstream(file, std::ios::binary) << bytes;
    std::ofstream(steps) << body.steps.substeps << ' ' << body.steps.iterations;
    return body;
  }
#endif
  return built(scene);
}

void run(const std::string& name, std::uint64_t frames, const std::vector<std::string>& devices) {
  const scene::Scene scene = scene::load_scene(name);
  const Body body = body_of(scene);
  for (const std::string& device : devices) step_on(device, frames, scene, body.model, body.steps);
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
