#include "host/studio/running_body.h"

#include <stdexcept>
#include <utility>

#include "host/scene/scene_json.h"

namespace fascicle::studio {

RunningBody::RunningBody(scene::Scene scene, pipeline::Built built, const pipeline::ChosenDevice& device,
                         std::uint32_t revision, pipeline::SolverMemory memory)
    : scene_(std::move(scene)),
      built_(std::move(built)),
      device_(device),
      revision_(revision),
      frames_(scene::frame_count(scene_)),
      memory_(std::move(memory)),
      drives_(scene_, built_.model, built_.steps.substeps),
      solver_(device.make_solver(built_.model, pipeline::solver_options(scene_, built_.steps), &memory_)) {}

double RunningBody::frame_time(std::uint64_t frame) const {
  if (built_.model.has_skeleton()) return drives_.clip_time(frame);
  return scene_.start + static_cast<double>(frame) / scene_.fps;
}

std::unique_ptr<model::Solver> RunningBody::solver_of(const model::Model& model) const {
  pipeline::SolverMemory memory = memory_;
  return device_.make_solver(model, pipeline::solver_options(scene_, built_.steps), &memory);
}

model::State RunningBody::state_on_skeleton(std::uint64_t frame) {
  if (frame == 0 || !built_.model.has_skeleton()) {
    model::State state = drives_.initial_state();
    state.frame = frame;
    return state;
  }
  if (frame < frames_) return drives_.state_on_skeleton(frame);
  // The last frame has no next frame from which to take velocities.
  if (frames_ == 1) {
    solver_->load(drives_.initial_state());
  } else {
    solver_->load(drives_.state_on_skeleton(frames_ - 1));
  }
  solver_->submit(drives_.drive(frames_), {});
  solver_->collect();
  return solver_->save();
}

std::vector<float> RunningBody::joint_places(std::uint64_t frame) {
  std::vector<float> places;
  for (const Eigen::Matrix4d& map : drives_.joints(frame))
    for (int a = 0; a < 3; ++a) places.push_back(static_cast<float>(scene_.scale * map(a, 3)));
  return places;
}

std::vector<scene::Solid> RunningBody::solids(std::uint64_t frame) {
  if (!built_.model.has_colliders()) return {};
  return drives_.solids(frame);
}

bool has_same_shape(const model::Model& a, const model::Model& b) {
  return a.vertex_count == b.vertex_count && a.unit == b.unit && a.rest_origin == b.rest_origin &&
         a.joint_count == b.joint_count && a.source_vertex == b.source_vertex && a.rest == b.rest &&
         a.skin_joint == b.skin_joint && a.skin_weight == b.skin_weight;
}

bool plays_the_same(const scene::Scene& a, const scene::Scene& b) {
  return a.fps == b.fps && a.start == b.start && a.end == b.end &&
         scene::clip_name(a) == scene::clip_name(b) && scene::json_of(a.motion) == scene::json_of(b.motion) &&
         scene::frame_count(a) == scene::frame_count(b);
}

model::State carried_over(const model::State& state, RunningBody& from, RunningBody& to,
                          std::uint64_t frame) {
  if (!has_same_shape(from.model(), to.model()) || !plays_the_same(from.scene(), to.scene()))
    return to.state_on_skeleton(frame);
  const model::Model& model = to.model();
  model::State next = state;
  const bool lacks_velocities = model.has_carried() && next.skinned_velocities.empty();
  if (lacks_velocities) next.skinned_velocities = to.state_on_skeleton(frame).skinned_velocities;
  if (!model.has_carried()) next.skinned_velocities.clear();
  if (!model.is_implicit()) {
    next.positions_before.clear();
    next.velocities_before.clear();
    next.step_before = 0.0;
  }
  try {
    model::check_state(model, next);
  } catch (const std::invalid_argument&) {
    return to.state_on_skeleton(frame);
  }
  return next;
}

}  // namespace fascicle::studio
