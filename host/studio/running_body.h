// A scene, built and ready to move. Its parts refer to each other, so it must not move in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/pipeline/build_scene.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/scene.h"

namespace fascicle::studio {

class RunningBody {
 public:
  // The device must outlive it. Throws pipeline::NoSuchDevice if the model does not fit the device, and
  // gpu::DeviceLost.
  RunningBody(scene::Scene scene, pipeline::Built built, const pipeline::ChosenDevice& device,
              std::uint32_t revision, pipeline::SolverMemory memory = {});
  RunningBody(const RunningBody&) = delete;
  RunningBody& operator=(const RunningBody&) = delete;

  const scene::Scene& scene() const { return scene_; }
  const model::Model& model() const { return built_.model; }
  const pipeline::Built& built() const { return built_; }
  const pipeline::ChosenDevice& device() const { return device_; }
  std::uint32_t revision() const { return revision_; }  // of the keys that it was made from
  std::uint64_t frames() const { return frames_; }      // number of the last frame
  double frame_time(std::uint64_t frame) const;         // s of the clip

  drive::DriveSource& drives() { return drives_; }
  model::Solver& solver() { return *solver_; }
  // Of its solver, for the next body's solver.
  const pipeline::SolverMemory& memory() const { return memory_; }
  // A second solver, for a model with the same solver settings.
  std::unique_ptr<model::Solver> solver_of(const model::Model& model) const;

  // The state at the end of a frame if the flesh had followed the skeleton until then.
  model::State state_on_skeleton(std::uint64_t frame);

  // The joints' positions at the end of a frame, m, 3 numbers each.
  std::vector<float> joint_places(std::uint64_t frame);

  // The scene's solids at the end of a frame, m.
  std::vector<scene::Solid> solids(std::uint64_t frame);

 private:
  scene::Scene scene_;
  pipeline::Built built_;
  const pipeline::ChosenDevice& device_;
  std::uint32_t revision_;
  std::uint64_t frames_;
  pipeline::SolverMemory memory_;
  drive::DriveSource drives_;
  std::unique_ptr<model::Solver> solver_;
};

// Whether two models have the same body and shape, so that a state of one is valid for the other.
bool has_same_shape(const model::Model& a, const model::Model& b);
// Whether two scenes play the same frames: the clip, its range, rate and motion.
bool plays_the_same(const scene::Scene& a, const scene::Scene& b);

// Converts the current state for a body with other keys, so that the flesh continues from where it is. If the
// body or its motion differs, the flesh follows the skeleton up to that frame.
model::State carried_over(const model::State& state, RunningBody& from, RunningBody& to, std::uint64_t frame);

}  // namespace fascicle::studio
