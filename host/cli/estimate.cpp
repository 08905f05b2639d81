#include "host/cli/estimate.h"

#include <algorithm>
#include <chrono>

#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/cli/exit_codes.h"
#include "host/drive/drive_source.h"

namespace fascicle::cli {
namespace {

// The first `substeps` of a frame.
model::Drive shortened(model::Drive drive, std::uint32_t substeps, const model::Model& model) {
  drive.substeps = std::min(drive.substeps, substeps);
  const std::size_t count = drive.substeps;
  drive.bones = drive.bones.first(count * model.joint_count);
  drive.muscles = drive.muscles.first(count * model.muscle_count);
  drive.forces = drive.forces.first(count * model.force_count);
  drive.colliders = drive.colliders.first(count * model.collider_count);
  const auto left_out = std::find_if(drive.cuts.begin(), drive.cuts.end(),
                                     [count](const model::Cut& cut) { return cut.substep >= count; });
  drive.cuts = drive.cuts.first(static_cast<std::size_t>(left_out - drive.cuts.begin()));
  return drive;
}

// Seconds per substep, with positions read back once per frame, as in a bake. Skips the first frame, in which
// drivers compile.
double measured_substep(const scene::Scene& scene, const Built& built, model::Solver& solver) {
  constexpr std::uint32_t substeps = 8;
  constexpr std::uint64_t frames = 4;
  const model::Model& model = built.model;
  const model::Read what{.positions = true, .velocities = true, .surface = model.surface_count() > 0};
  drive::DriveSource source(scene, model, built.steps.substeps);
  solver.load(source.initial_state());
  std::uint64_t timed = 0;
  std::chrono::steady_clock::time_point start;
  for (std::uint64_t frame = 1; frame <= frames; ++frame) {
    if (frame == 2) start = std::chrono::steady_clock::now();
    const model::Drive drive = shortened(source.drive(frame), substeps, model);
    solver.submit(drive, what);
    solver.collect();
    if (frame > 1) timed += drive.substeps;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  return seconds.count() / static_cast<double>(timed);
}

}  // namespace

Estimate estimate_of(const PreparedBake& prepared, const bake::BakeOutput& output) {
  Estimate estimate;
  estimate.frames = scene::frame_count(prepared.scene);
  estimate.seconds_substep = measured_substep(prepared.scene, prepared.built, *prepared.simulation.solver);
  estimate.preroll_frames =
      drive::DriveSource(prepared.scene, prepared.built.model, prepared.built.steps.substeps)
          .preroll_frames();
  estimate.seconds = estimate.seconds_substep *
                     static_cast<double>(estimate.frames + estimate.preroll_frames) *
                     prepared.built.steps.substeps;
  estimate.solver_bytes = model::solver_bytes(prepared.built.model);
  estimate.output_bytes =
      bake::output_bytes(prepared.scene, prepared.built.model, bake::formats_to_write(output), output.glb);
  return estimate;
}

}  // namespace fascicle::cli
