// fascicle_solver_save and fascicle_solver_load.
//
// Little-endian: char[8] "FASCSTP2", the hash of all that follows (32 hex digits), then Head, the last pose
// given (float64), then a checkpoint's bytes (host/bake/checkpoint.h) with the model's identity.
#include "host/api/solver_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "host/api/boundary.h"
#include "host/bake/checkpoint.h"
#include "host/bake/identity.h"
#include "host/base/content_hash.h"
#include "host/base/text.h"
#include "host/base/version.h"

namespace fascicle::api {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::string_view magic = "FASCSTP2";

constexpr std::size_t hash_digits = 32;

struct Head {
  std::uint64_t frame, driven, pose_numbers;
  double time;
};

bake::Identity identity_of_steps(const fascicle_solver& solver) {
  return {{"model", base::hash_text(bake::model_hash(solver.body->model))},
          {"solver version", std::to_string(base::solver_version)},
          {"integrator", model::name_of(solver.options.integrator)},
          {"rotation", model::name_of(solver.options.rotation)},
          {"iterations", std::to_string(solver.options.iterations)},
          {"viscosity", base::number_text(solver.options.viscosity)}};
}

std::string hash_of(std::string_view bytes) {
  base::ContentHash hash;
  hash.add(bytes);
  return hash.text();
}

std::string saved_bytes(const fascicle_solver& solver) {
  std::string pose;
  if (solver.driven == fascicle_solver::Driven::by_poses && solver.poses)
    for (const Eigen::Matrix4d& joint : solver.poses->last())
      pose.append(reinterpret_cast<const char*>(joint.data()), 16 * sizeof(double));
  const Head head{solver.frame, static_cast<std::uint64_t>(solver.driven), pose.size() / sizeof(double),
                  solver.time};
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  bytes += pose + bake::checkpoint_text({identity_of_steps(solver), solver.solver->save()});
  return std::string(magic) + hash_of(bytes) + bytes;
}

[[noreturn]] void refuse_state(const std::string& why) {
  throw bake::BakeError("the solver's state cannot be used: " + why);
}

// The hash keeps out damage, not a forger.
void check_values(const fascicle_solver& solver, const model::State& state, double time,
                  const drive::Pose& pose) {
  try {
    model::check_state(solver.body->model, state);
  } catch (const std::invalid_argument& error) {
    refuse_state(error.what());
  }
  const bool is_finite =
      std::isfinite(time) && std::ranges::all_of(state.origin, [](double x) { return std::isfinite(x); }) &&
      std::ranges::all_of(pose, [](const Eigen::Matrix4d& joint) { return joint.allFinite(); });
  if (!is_finite) refuse_state("its time, origin or pose is not finite");
  check_finite(state.positions, state.frame);
}

void load_bytes(fascicle_solver& solver, std::string_view bytes) {
  Head head{};
  if (!bytes.starts_with(magic)) refuse_state("the bytes are not from fascicle_solver_save of this version");
  bytes.remove_prefix(magic.size());
  const std::string_view hash = bytes.substr(0, hash_digits);
  bytes.remove_prefix(hash.size());
  if (hash != hash_of(bytes) || bytes.size() < sizeof head) refuse_state("the bytes are damaged or cut off");
  std::memcpy(&head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  if (head.pose_numbers > bytes.size() / sizeof(double) || head.driven > 3)
    refuse_state("the bytes are damaged");
  const std::size_t joints = head.pose_numbers / 16;
  const bool by_poses =
      static_cast<fascicle_solver::Driven>(head.driven) == fascicle_solver::Driven::by_poses;
  if (head.pose_numbers != 16 * (by_poses ? std::uint64_t{solver.body->model.joint_count} : 0))
    refuse_state("it is from another model");
  if (head.driven != 0 && head.driven != 3 && !solver.body->scene) refuse_state("it is from another model");
  drive::Pose pose(joints);
  for (Eigen::Matrix4d& joint : pose) {
    std::memcpy(joint.data(), bytes.data(), 16 * sizeof(double));
    bytes.remove_prefix(16 * sizeof(double));
  }
  const bake::Checkpoint found = bake::parse_checkpoint(bytes, "the solver's state");
  if (const std::string text = text_of(bake::differences(found.identity, identity_of_steps(solver)));
      !text.empty())
    refuse_state("it is from another model or solver: " + text);
  check_values(solver, found.state, head.time, pose);
  solver.solver->load(found.state);
  solver.frame = head.frame;
  solver.time = head.time;
  solver.driven = static_cast<fascicle_solver::Driven>(head.driven);
  if (by_poses) {
    if (!solver.poses) solver.poses.emplace(*solver.body->scene, solver.body->model, solver.body->substeps);
    solver.poses->stand(pose);
  }
  show(solver, found.state);
}

}  // namespace
}  // namespace fascicle::api

using namespace fascicle;

fascicle_status fascicle_solver_save(const fascicle_solver* solver, void* bytes, size_t capacity,
                                     size_t* size) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    api::must_have(size, "size");
    const std::string saved = api::saved_bytes(*solver);
    if (bytes != nullptr && capacity < saved.size())
      throw api::BadArgument("capacity is " + std::to_string(capacity) + "; the state takes " +
                             std::to_string(saved.size()) + " bytes");
    *size = saved.size();
    if (bytes != nullptr) std::memcpy(bytes, saved.data(), saved.size());
  });
}

fascicle_status fascicle_solver_load(fascicle_solver* solver, const void* bytes, size_t size) {
  return api::guarded([&] {
    api::must_be_usable(solver, "solver");
    api::must_have(bytes, "bytes");
    api::load_bytes(*solver, {static_cast<const char*>(bytes), size});
  });
}
