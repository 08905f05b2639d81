#include "tests/paper/character_run.h"

#include <variant>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "tests/paper/built_scene.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

void run_character(
    const char* file, const scene::SceneOverrides& overrides,
    const std::function<bool(const model::Model&, const rig::Character&, const model::Frame&)>& see) {
  const scene::Scene scene = scene::load_scene(asset(file).string(), overrides);
  const auto [model, substeps, options] = built(scene);
  drive::DriveSource drives(scene, model, substeps);
  const auto solver = cpu_reference::make_cpu_solver(model, options, 0);
  solver->load(drive::lead_in(scene, model, drives, *solver).state);
  for (std::uint64_t k = 1; k <= scene::frame_count(scene); ++k) {
    solver->submit(drives.drive(k), {.positions = true, .skinned = true});
    if (!see(model, std::get<rig::Character>(scene.geometry), solver->collect())) return;
  }
}

}  // namespace fascicle::tests
