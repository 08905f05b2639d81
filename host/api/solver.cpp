// Solvers of the C API.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "host/api/boundary.h"
#include "host/api/handles.h"
#include "host/api/solver_state.h"
#include "host/base/text.h"
#include "host/drive/lead_in.h"
#include "host/formats/surface.h"
#include "host/model/reach.h"
#include "host/model/validate.h"

namespace fascicle::api {
namespace {

constexpr std::uint32_t most_substeps =
    1000;  // of a frame, which nothing interrupts; scenes have the same limit

const scene::Scene& scene_of(const fascicle_solver& solver) {
  if (!solver.body->scene)
    throw BadArgument(
        "the model was made from arrays and has no scene; step it with fascicle_solver_step_drive");
  return *solver.body->scene;
}

drive::DriveSource& clip_of(fascicle_solver& solver) {
  if (!solver.clip) solver.clip.emplace(scene_of(solver), solver.body->model, solver.body->substeps);
  return *solver.clip;
}

drive::PoseDrive& poses_of(fascicle_solver& solver) {
  if (!solver.poses) solver.poses.emplace(scene_of(solver), solver.body->model, solver.body->substeps);
  return *solver.poses;
}

void step(fascicle_solver& solver, const model::Drive& drive) {
  const model::Read what{
      .positions = true, .velocities = true, .surface = solver.body->model.surface_count() > 0};
  solver.solver->submit(drive, what);
  solver.shown = solver.solver->collect();
  ++solver.frame;
  check_finite(solver.shown.positions, solver.body->model.unit, solver.frame);
}

void stand_at_rest(fascicle_solver& solver) {
  const model::State rest = model::rest_state(solver.body->model);
  solver.solver->load(rest);
  solver.driven = Driven::no;
  solver.frame = 0;
  solver.time = solver.body->scene ? solver.body->scene->start : 0.0;
  show(solver, rest);
}

// Starts at frame 0 of a new driver, from the state that `state_of_start` computes. If that fails, the solver
// is at rest with no driver, because it has already been partly stepped.
template <class Work>
void start(fascicle_solver& solver, Driven driven, Work&& state_of_start) {
  try {
    solver.driven = Driven::no;
    const model::State state = state_of_start();
    solver.solver->load(state);
    show(solver, state);
  } catch (...) {
    stand_at_rest(solver);
    throw;
  }
  solver.driven = driven;
  solver.frame = 0;
  solver.time = solver.body->scene->start;
}

drive::Pose pose_of(const double* joints, std::size_t joint_count) {
  drive::Pose pose(joint_count);
  for (std::size_t j = 0; j < joint_count; ++j)
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) {
        const double x = joints[16 * j + static_cast<std::size_t>(4 * row + column)];
        if (!std::isfinite(x)) throw BadArgument("joint " + std::to_string(j) + " of the pose is not finite");
        pose[j](row, column) = x;
      }
  constexpr double rounding = 1e-6;  // for maps that were blended or inverted, possibly in floats
  for (std::size_t j = 0; j < joint_count; ++j)
    if ((pose[j].row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).cwiseAbs().maxCoeff() > rounding)
      throw BadArgument("joint " + std::to_string(j) +
                        ": the last row must be 0 0 0 1; are the matrices column-major?");
  return pose;
}

void check_count(std::size_t given, std::size_t wanted, const char* what) {
  if (given != wanted)
    throw BadArgument(std::string(what) + " is " + std::to_string(given) + "; it must be " +
                      std::to_string(wanted));
}

// Checks that there are `wanted` items before reading any. The structs consist of floats only.
template <class Item>
std::vector<Item> items_of(const float* values, std::size_t count, std::size_t wanted, const char* name,
                           const char* count_name) {
  static_assert(std::is_trivially_copyable_v<Item>);
  check_count(count, wanted, count_name);
  if (count > 0) must_have(values, name);
  std::vector<Item> items(count);
  if (count > 0) std::memcpy(static_cast<void*>(items.data()), values, count * sizeof(Item));
  return items;
}

void copy_world(const std::vector<float>& positions, const fascicle_solver& solver, float* metres,
                std::size_t count) {
  check_count(count, positions.size(), "count");
  if (count > 0) must_have(metres, "metres");
  const std::vector<float> world =
      formats::world_positions(positions, solver.body->model.unit, solver.shown.origin);
  std::copy(world.begin(), world.end(), metres);
}

model::SolverOptions with(model::SolverOptions options, const fascicle_solver_options& given) {
  if (given.iterations > 1000)
    throw BadArgument("options.iterations is " + std::to_string(given.iterations) +
                      "; it must be from 1 to 1000, or 0 for the scene's");
  if (given.iterations > 0) options.iterations = given.iterations;
  if (!std::isnan(given.viscosity)) {
    if (!std::isfinite(given.viscosity) || given.viscosity < 0.0)
      throw BadArgument("options.viscosity is " + base::number_text(given.viscosity) +
                        "; it must be a finite number of at least 0, or NaN for the scene's");
    options.viscosity = given.viscosity;
  }
  if (given.rotation == nullptr) return options;
  const auto rotation = base::named<model::Rotation>(given.rotation);
  if (!rotation) {
    std::string names;
    for (const std::string& name : base::all_names<model::Rotation>())
      names += (names.empty() ? "\"" : " or \"") + name + '"';
    throw BadArgument("options.rotation: there is no \"" + std::string(given.rotation) + "\"; use " + names);
  }
  options.rotation = *rotation;
  return options;
}

}  // namespace

void check_finite(const std::vector<float>& positions, double unit, std::uint64_t frame) {
  if (!model::is_in_reach(positions, unit))
    throw bake::NotFinite("frame " + std::to_string(frame) +
                          ": positions are no longer finite, or absurdly far away; use more substeps or "
                          "softer layers");
}

void show(fascicle_solver& solver, const model::State& state) {
  check_finite(state.positions, solver.body->model.unit, state.frame);
  solver.shown = {};
  solver.shown.index = state.frame;
  solver.shown.origin = state.origin;
  solver.shown.positions = state.positions;
  solver.shown.velocities = state.velocities;
  solver.shown.surface = formats::embed(solver.body->model, state.positions);
}

}  // namespace fascicle::api

using namespace fascicle;
using api::Driven;

void fascicle_solver_options_init(fascicle_solver_options* options, size_t struct_size) {
  fascicle_solver_options defaults{};
  defaults.viscosity = std::numeric_limits<double>::quiet_NaN();
  api::fill(options, struct_size, defaults);
}

void fascicle_pose_init(fascicle_pose* pose, size_t struct_size) {
  fascicle_pose defaults{};
  defaults.pose_count = 1;
  defaults.time = std::numeric_limits<double>::quiet_NaN();
  api::fill(pose, struct_size, defaults);
}

void fascicle_drive_init(fascicle_drive* drive, size_t struct_size) {
  fascicle_drive defaults{};
  defaults.substeps = 1;
  api::fill(drive, struct_size, defaults);
}

fascicle_status fascicle_solver_create(const fascicle_model* model, const fascicle_device* device,
                                       const fascicle_solver_options* options, fascicle_solver** solver) {
  return api::guarded_make(solver, [&] {
    api::must_have(model, "model");
    const auto taken = api::taken(options, fascicle_solver_options_init, "options");
    auto made = std::make_unique<fascicle_solver>();
    made->body = model->body;
    made->options = api::with(model->body->options, taken);
    if (device != nullptr) {
      api::must_be_usable(device, "device");
      made->device = device->device;
      made->solver = made->device->make_solver(made->body->model, made->options);
    } else {
      pipeline::Simulation chosen = pipeline::choose_simulation({}, 0, made->body->model, made->options, {});
      made->device = std::make_shared<pipeline::ChosenDevice>(std::move(chosen.device));
      made->solver = std::move(chosen.solver);
    }
    made->device_text = made->device->text();
    api::stand_at_rest(*made);
    return made;
  });
}

void fascicle_solver_destroy(fascicle_solver* solver) {
  api::destroy_in_own_process(solver);
}

const char* fascicle_solver_device_text(const fascicle_solver* solver) {
  return solver == nullptr ? nullptr : solver->device_text.c_str();
}

fascicle_status fascicle_solver_start_clip(fascicle_solver* solver, fascicle_progress_function* progress,
                                           void* user) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    drive::DriveSource& clip = api::clip_of(*solver);
    api::start(*solver, Driven::by_clip, [&] {
      std::uint64_t done = 0;
      const drive::LeadIn led = drive::lead_in(
          *solver->body->scene, solver->body->model, clip, *solver->solver,
          [&] { return progress != nullptr && progress(user, FASCICLE_PHASE_LEAD_IN, done++, 0) != 0; });
      if (led.stopped) throw api::Cancelled("cancelled before frame 0");
      return led.state;
    });
  });
}

fascicle_status fascicle_solver_step_clip(fascicle_solver* solver) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    if (solver->driven != Driven::by_clip)
      throw api::BadArgument("the solver does not follow its clip; call fascicle_solver_start_clip first");
    api::step(*solver, api::clip_of(*solver).drive(solver->frame + 1));
    solver->time += 1.0 / solver->body->scene->fps;
  });
}

fascicle_status fascicle_solver_start_pose(fascicle_solver* solver, const double* joints, size_t count) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    drive::PoseDrive& poses = api::poses_of(*solver);
    const std::size_t joint_count = solver->body->model.joint_count;
    api::check_count(count, 16 * joint_count, "count");
    if (count > 0) api::must_have(joints, "joints");
    const drive::Pose pose = api::pose_of(joints, joint_count);
    api::start(*solver, Driven::by_poses, [&] { return poses.start(pose); });
  });
}

fascicle_status fascicle_solver_step_pose(fascicle_solver* solver, const fascicle_pose* pose) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    drive::PoseDrive& poses = api::poses_of(*solver);
    if (solver->driven != Driven::by_poses)
      throw api::BadArgument("the solver does not follow poses; call fascicle_solver_start_pose first");
    const auto taken = api::taken(pose, fascicle_pose_init, "pose");
    const std::size_t joint_count = solver->body->model.joint_count;
    std::vector<drive::Pose> given;
    if (joint_count > 0) {
      const std::size_t substeps = solver->body->substeps;
      if (taken.pose_count != 1 && taken.pose_count != substeps)
        throw api::BadArgument("pose.pose_count is " + std::to_string(taken.pose_count) +
                               "; it must be 1, or one for each substep, " + std::to_string(substeps));
      api::must_have(taken.joints, "pose.joints");
      for (std::size_t k = 0; k < taken.pose_count; ++k)
        given.push_back(api::pose_of(taken.joints + 16 * k * joint_count, joint_count));
    }
    const double time = std::isnan(taken.time) ? solver->time + 1.0 / solver->body->scene->fps : taken.time;
    if (!std::isfinite(time)) throw api::BadArgument("pose.time is not finite");
    api::step(*solver, poses.drive(given, time, taken.jumps != 0));
    solver->time = time;
  });
}

fascicle_status fascicle_solver_clip_pose(fascicle_solver* solver, uint64_t frame, double* joints,
                                          size_t count) {
  return api::guarded([&] {
    api::must_have(solver, "solver");
    const drive::Pose pose = api::clip_of(*solver).joints(frame);
    api::check_count(count, 16 * pose.size(), "count");
    if (count > 0) api::must_have(joints, "joints");
    for (std::size_t j = 0; j < pose.size(); ++j)
      for (int k = 0; k < 16; ++k) joints[16 * j + static_cast<std::size_t>(k)] = pose[j](k / 4, k % 4);
  });
}

fascicle_status fascicle_solver_step_drive(fascicle_solver* solver, const fascicle_drive* drive) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    api::must_have(drive, "drive");
    const auto taken = api::taken(drive, fascicle_drive_init, "drive");
    const model::Model& model = solver->body->model;
    const std::size_t substeps = taken.substeps;
    if (substeps == 0 || substeps > api::most_substeps)
      throw api::BadArgument("drive.substeps is " + std::to_string(substeps) + "; it must be from 1 to " +
                             std::to_string(api::most_substeps));
    const auto bones = api::items_of<shader::Bone>(
        taken.bones, taken.bone_count, substeps * model.joint_count, "drive.bones", "drive.bone_count");
    const auto muscles =
        api::items_of<shader::Muscle>(taken.muscles, taken.muscle_count, substeps * model.muscle_count,
                                      "drive.muscles", "drive.muscle_count");
    const auto forces = api::items_of<shader::Force>(
        taken.forces, taken.force_count, substeps * model.force_count, "drive.forces", "drive.force_count");
    const auto colliders = api::items_of<shader::Collider>(taken.colliders, taken.collider_count,
                                                           substeps * model.collider_count, "drive.colliders",
                                                           "drive.collider_count");
    const auto decay = api::items_of<float>(taken.decay, taken.decay_count, model.layers.size(),
                                            "drive.decay", "drive.decay_count");
    model::Drive made;
    made.substeps = taken.substeps;
    made.h = taken.h;
    for (std::size_t a = 0; a < 3; ++a) {
      made.origin[a] = taken.origin[a];
      made.origin_shift[a] = taken.origin_shift[a];
      made.gravity[a] = taken.gravity[a];
    }
    made.bones = bones;
    made.muscles = muscles;
    made.forces = forces;
    made.colliders = colliders;
    made.decay = decay;
    if (!(made.h > 0.0 && std::isfinite(made.h))) throw api::BadArgument("drive.h must be above 0, s");
    const auto are_finite = [](const auto& values) {
      return std::all_of(std::begin(values), std::end(values), [](auto x) { return std::isfinite(x); });
    };
    if (!are_finite(taken.origin)) throw api::BadArgument("drive.origin is not finite");
    if (!are_finite(taken.origin_shift)) throw api::BadArgument("drive.origin_shift is not finite");
    if (!are_finite(taken.gravity)) throw api::BadArgument("drive.gravity is not finite");
    if (!std::all_of(decay.begin(), decay.end(), [](float d) { return d >= 0.0f && d <= 1.0f; }))
      throw api::BadArgument("drive.decay must be from 0 to 1");
    model::check_drive(model, made);
    api::step(*solver, made);
    solver->driven = Driven::by_drives;
    solver->time += taken.h * taken.substeps;
  });
}

fascicle_status fascicle_solver_frame(const fascicle_solver* solver, fascicle_frame* frame) {
  return api::guarded([&] {
    api::must_have(solver, "solver");
    api::must_have(frame, "frame");
    const model::Frame& shown = solver->shown;
    *frame = {};
    frame->index = solver->frame;
    frame->unit = solver->body->model.unit;
    std::copy(shown.origin.begin(), shown.origin.end(), frame->origin);
    frame->vertex_count = shown.positions.size() / 3;
    frame->surface_vertex_count = shown.surface.size() / 3;
    frame->positions = shown.positions.data();
    frame->velocities = shown.velocities.data();
    frame->surface = shown.surface.empty() ? nullptr : shown.surface.data();
  });
}

fascicle_status fascicle_solver_positions(const fascicle_solver* solver, float* metres, size_t count) {
  return api::guarded([&] {
    api::must_have(solver, "solver");
    api::copy_world(solver->shown.positions, *solver, metres, count);
  });
}

fascicle_status fascicle_solver_surface(const fascicle_solver* solver, float* metres, size_t count) {
  return api::guarded([&] {
    api::must_have(solver, "solver");
    api::copy_world(solver->shown.surface, *solver, metres, count);
  });
}

fascicle_status fascicle_solver_position_hash(const fascicle_solver* solver, char text[17]) {
  return api::guarded([&] {
    api::must_have(solver, "solver");
    api::must_have(text, "text");
    const std::string hash = base::hash_text(model::position_hash(solver->shown));
    std::memcpy(text, hash.c_str(), std::min<std::size_t>(hash.size() + 1, 17));
  });
}
