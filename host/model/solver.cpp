#include "host/model/solver.h"

#include <array>
#include <cassert>
#include <cmath>
#include <string>

namespace fascicle::model {

std::vector<float> side_by_side(std::span<const float> a, std::size_t a_width, std::span<const float> b,
                                std::size_t b_width) {
  assert(a.size() / a_width == b.size() / b_width);
  std::vector<float> items;
  items.reserve(a.size() + b.size());
  for (; !a.empty(); a = a.subspan(a_width), b = b.subspan(b_width)) {
    items.insert(items.end(), a.begin(), a.begin() + static_cast<std::ptrdiff_t>(a_width));
    items.insert(items.end(), b.begin(), b.begin() + static_cast<std::ptrdiff_t>(b_width));
  }
  return items;
}

void check_options(const Model& model, const SolverOptions& options) {
  const bool implicit = options.integrator == Integrator::implicit_step;
  if (implicit != model.is_implicit())
    throw std::invalid_argument(std::string("solver: the model is not for the ") +
                                name_of(options.integrator) + " integrator");
  if (implicit && options.iterations == 0) throw std::invalid_argument("solver: iterations is 0");
  if (!std::isfinite(options.viscosity) || options.viscosity < 0.0)
    throw std::invalid_argument("solver: viscosity is not a finite number of at least 0");
}

void check_drive(const Model& model, const Drive& drive) {
  const auto check = [&](const char* what, std::size_t have, std::size_t need) {
    if (have != need)
      throw std::invalid_argument(std::string("drive: ") + what + " has " + std::to_string(have) +
                                  " entries, must have " + std::to_string(need));
  };
  if (drive.substeps == 0) throw std::invalid_argument("drive: substeps is 0");
  if (!(drive.h > 0.0) || !std::isfinite(drive.h)) throw std::invalid_argument("drive: h is not positive");
  const std::size_t s = drive.substeps;
  check("bones", drive.bones.size(), s * model.joint_count);
  check("muscles", drive.muscles.size(), s * model.muscle_count);
  check("forces", drive.forces.size(), s * model.force_count);
  check("colliders", drive.colliders.size(), s * model.collider_count);
  check("decay", drive.decay.size(), model.layers.size());
  if (!drive.cuts.empty() && !model.has_skeleton())
    throw std::invalid_argument("drive: it has cuts, but the model has no skeleton");
  if (!drive.cuts.empty() && drive.origin_shift != std::array<float, 3>{0, 0, 0})
    throw std::invalid_argument("drive: the cuts move the origin, so origin_shift must be 0");
  for (std::size_t k = 0; k < drive.cuts.size(); ++k) {
    const Cut& cut = drive.cuts[k];
    if (cut.substep >= drive.substeps || (k > 0 && cut.substep <= drive.cuts[k - 1].substep))
      throw std::invalid_argument("drive: cuts[" + std::to_string(k) +
                                  "] is not at a later substep of the frame");
    for (const auto& pose : {cut.before, cut.at, cut.to, cut.after})
      check("a pose of a cut", pose.size(), model.joint_count);
  }
}

shader::Substep first_substep(const Model& model, const Drive& drive) {
  shader::Substep substep{};
  substep.h = static_cast<float>(drive.h);
  substep.inverse_h = static_cast<float>(1.0 / drive.h);
  substep.gravity_x = drive.gravity[0];
  substep.gravity_y = drive.gravity[1];
  substep.gravity_z = drive.gravity[2];
  substep.shift_x = drive.origin_shift[0];
  substep.shift_y = drive.origin_shift[1];
  substep.shift_z = drive.origin_shift[2];
  substep.vertex_count = model.vertex_count;
  substep.surface_count = model.surface_count();
  substep.joint_count = model.joint_count;
  substep.contact_count = static_cast<std::uint32_t>(model.contact.size());
  substep.contact_tetrahedron_count = model.contact_tetrahedron_count();
  substep.collider_count = model.collider_count;
  return substep;
}

void check_state(const Model& model, const State& state) {
  const std::size_t n = model.vertex_count;
  const auto check = [](const char* what, std::size_t have, std::size_t need) {
    if (have != need)
      throw std::invalid_argument(std::string("state: ") + what + " has " + std::to_string(have) +
                                  " floats, must have " + std::to_string(need));
  };
  check("positions", state.positions.size(), 3 * n);
  check("velocities", state.velocities.size(), 3 * n);
  check("rotations", state.rotations.size(), 4 * n);
  check("skinned", state.skinned.size(), model.has_skeleton() ? 3 * n : 0);
  check("skinned_velocities", state.skinned_velocities.size(), 3 * model.carried.size());
  const bool has_before = !state.positions_before.empty();
  if (has_before && !model.is_implicit())
    throw std::invalid_argument("state: it has a previous substep, which an explicit run does not use");
  check("positions_before", state.positions_before.size(), has_before ? 3 * n : 0);
  check("velocities_before", state.velocities_before.size(), has_before ? 3 * n : 0);
  if (has_before != (state.step_before > 0.0) || !(state.step_before >= 0.0) ||
      !std::isfinite(state.step_before))
    throw std::invalid_argument(
        "state: step_before must be above 0 with positions_before, and 0 without them");
}

}  // namespace fascicle::model
