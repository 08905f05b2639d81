// fascicle_solver_save and fascicle_solver_load.
#include "host/api/solver_state.h"

#include <cstring>
#include <string_view>

#include "host/api/boundary.h"
#include "host/api/saved_state.h"
#include "host/bake/identity.h"
#include "host/base/text.h"
#include "host/base/version.h"

namespace fascicle::api {
namespace {

bake::Identity identity_of_steps(const fascicle_solver& solver) {
  return {{"model", base::hash_text(bake::model_hash(solver.body->model))},
          {"solver version", std::to_string(base::solver_version)},
          {"integrator", model::name_of(solver.options.integrator)},
          {"rotation", model::name_of(solver.options.rotation)},
          {"iterations", std::to_string(solver.options.iterations)},
          {"viscosity", base::number_text(solver.options.viscosity)}};
}

std::string saved_bytes(const fascicle_solver& solver) {
  SavedState saved{
      .frame = solver.frame, .driven = solver.driven, .time = solver.time, .state = solver.solver->save()};
  if (solver.driven == Driven::by_poses && solver.poses) saved.pose = solver.poses->last();
  return saved_state_bytes(saved, identity_of_steps(solver));
}

void load_bytes(fascicle_solver& solver, std::string_view bytes) {
  const SavedState saved = parse_saved_state(
      bytes, {solver.body->model, solver.body->scene.has_value(), identity_of_steps(solver)});
  check_finite(saved.state.positions, solver.body->model.unit, saved.state.frame);
  solver.solver->load(saved.state);
  solver.frame = saved.frame;
  solver.time = saved.time;
  solver.driven = saved.driven;
  if (saved.driven == Driven::by_poses) {
    if (!solver.poses) solver.poses.emplace(*solver.body->scene, solver.body->model, solver.body->substeps);
    solver.poses->stand(saved.pose);
  }
  show(solver, saved.state);
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
