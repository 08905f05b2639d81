#include "cpu_reference/oracle/oracle.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "cpu_reference/oracle/oracle_impl.h"

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using model::Stage;

namespace {}  // namespace

void append(std::vector<float>& floats, const Vector3d& v) {
  for (int k = 0; k < 3; ++k) floats.push_back(float(v[k]));
}

void append(std::vector<float>& floats, const Quaterniond& q) {
  for (double component : {q.w(), q.x(), q.y(), q.z()}) floats.push_back(float(component));
}

std::vector<float> floats_of(const Points& points) {
  std::vector<float> floats;
  floats.reserve(3 * points.size());
  for (const Vector3d& p : points) append(floats, p);
  return floats;
}

Oracle::Impl::Impl(const model::Model& of, const model::SolverOptions& with)
    : model(of),
      options(with),
      rest(points_of(of.rest)),
      weights(region_weights(of)),
      ties(of),
      contacts(of),
      limits(of),
      regions(of.vertex_count) {
  if (model.is_implicit()) stiffness = vertex_stiffness(model, region_stiffness(model));
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    regions[r].c0 = region_centre(weights, r, rest);
    const Vector3d& c0 = regions[r].c0;
    rest_moment.push_back(region_moment(weights, r, Matrix3d::Identity(), rest, c0, rest, c0));
  }
}

Oracle::Impl::Substep Oracle::Impl::substep_of(const model::Drive& drive, std::uint32_t number) const {
  const auto part = [&](auto all, std::uint32_t count) {
    return all.subspan(std::size_t{number} * count, count);
  };
  Substep now{.h = float(drive.h),
              .gravity = vector_at(drive.gravity, 0),
              .bones = part(drive.bones, model.joint_count),
              .muscles = part(drive.muscles, model.muscle_count),
              .forces = part(drive.forces, model.force_count),
              .colliders = part(drive.colliders, model.collider_count),
              .decay = drive.decay};
  if (!model.is_implicit()) return now;
  now.stepping = Stepping{now.h, step_before == drive.h, options.viscosity};
  double gain = 0.0;
  for (const float g : model.volume_gain) gain = std::max(gain, double(g));
  now.chebyshev = Chebyshev(options.iterations, stiffest(*now.stepping), gain / 2.0);
  return now;
}

// The rotation option selects a float approximation of (9); here (9) is solved exactly, so the option is
// ignored.
Oracle::Oracle(const model::Model& model, const model::SolverOptions& options) {
  model::check_options(model, options);
  impl_ = std::make_unique<Impl>(model, options);
  load(model::rest_state(model));
}

Oracle::~Oracle() = default;

void Oracle::submit(const model::Drive& drive, model::Read what, model::Probe* probe) {
  Impl& s = *impl_;
  const model::Model& m = s.model;
  model::check_drive(m, drive);
  // Float solvers use float(h), so the reference takes the same step.
  const double h = float(drive.h);
  const Vector3d shift = vector_at(drive.origin_shift, 0);
  for (Vector3d& p : s.q) p -= shift;
  for (Vector3d& p : s.skinned) p -= shift;
  for (Vector3d& p : s.q_before) p -= shift;
  s.origin = drive.origin;
  ++s.frame;

  const model::SubstepPlan plan = substep_plan(m, s.options, true);
  for (std::uint32_t substep = 0; substep < drive.substeps; ++substep) {
    for (const model::Cut& cut : drive.cuts)
      if (cut.substep == substep) s.carry(cut, h);
    const Impl::Substep now = s.substep_of(drive, substep);
    model::Where where{.frame = s.frame, .substep = substep};
    const auto show = [&](std::optional<Stage> stage) {
      if (probe == nullptr || !stage) return;
      where.stage = *stage;
      probe->on_stage(where, s.output(*stage));
    };
    for (const model::Block& block : plan) {
      if (block.repeat == model::Block::Repeat::limit_passes) {
        s.run(model::Kernel::limit, now, 0);
      } else {
        for (std::uint32_t k = 0; k < block.times; ++k) {
          where.iteration = block.repeat == model::Block::Repeat::iterations ? k : 0;
          for (const model::Step& step : block.steps) {
            s.run(step.kernel, now, where.iteration);
            show(step.shown);
          }
        }
        where.iteration = 0;
      }
      show(block.shown);
    }
    if (m.is_implicit()) s.step_before = drive.h;
  }
  s.embed();
  if (probe != nullptr) probe->on_stage({s.frame, drive.substeps - 1, Stage::embed}, s.output(Stage::embed));

  model::Frame frame;
  frame.index = s.frame;
  frame.origin = s.origin;
  if (what.positions) frame.positions = floats_of(s.q);
  if (what.velocities) frame.velocities = floats_of(s.v);
  if (what.surface) frame.surface = floats_of(s.surface);
  if (what.skinned) frame.skinned = floats_of(s.skinned);
  s.frames.push_back(std::move(frame));
}

model::Frame Oracle::collect() {
  if (impl_->frames.empty()) throw std::logic_error("oracle: collect() without a submitted frame");
  model::Frame frame = std::move(impl_->frames.front());
  impl_->frames.pop_front();
  return frame;
}

// State holds floats, so save() and load() round positions and velocities once (relative 6e-8); a run that
// uses them differs by that from one that does not.
model::State Oracle::save() const {
  model::State state;
  state.frame = impl_->frame;
  state.origin = impl_->origin;
  state.positions = floats_of(impl_->q);
  state.velocities = floats_of(impl_->v);
  for (const RegionPose& pose : impl_->regions) append(state.rotations, pose.R);
  state.skinned = floats_of(impl_->skinned);
  state.skinned_velocities = floats_of(impl_->skinned_velocities);
  if (impl_->step_before == 0.0) return state;
  state.positions_before = floats_of(impl_->q_before);
  state.velocities_before = floats_of(impl_->v_before);
  state.step_before = impl_->step_before;
  return state;
}

void Oracle::load(const model::State& state) {
  model::check_state(impl_->model, state);
  impl_->frame = state.frame;
  impl_->origin = state.origin;
  impl_->q = points_of(state.positions);
  impl_->v = points_of(state.velocities);
  impl_->skinned = points_of(state.skinned);
  impl_->skinned_velocities = points_of(state.skinned_velocities);
  impl_->goals = impl_->q;
  impl_->y = impl_->q;
  impl_->q_before = state.positions_before.empty() ? impl_->q : points_of(state.positions_before);
  impl_->v_before = state.velocities_before.empty() ? impl_->v : points_of(state.velocities_before);
  impl_->step_before = state.step_before;
  for (std::uint32_t r = 0; r < impl_->model.vertex_count; ++r) {
    const float* c = &state.rotations[4 * std::size_t{r}];
    impl_->regions[r].R = Quaterniond(c[0], c[1], c[2], c[3]).normalized();
  }
  impl_->frames.clear();
}

const Points& Oracle::positions() const {
  return impl_->q;
}

const Points& Oracle::velocities() const {
  return impl_->v;
}

double Oracle::weight(std::uint32_t i, std::uint32_t r) const {
  return impl_->weights.of_region.coeff(int(i), int(r));
}

}  // namespace fascicle::cpu_reference
