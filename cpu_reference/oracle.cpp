#include "cpu_reference/oracle.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <stdexcept>

#include <Eigen/Geometry>

#include "cpu_reference/oracle_equations.h"
#include "cpu_reference/oracle_implicit.h"
#include "cpu_reference/oracle_limit.h"
#include "cpu_reference/oracle_tie.h"
#include "cpu_reference/oracle_weights.h"

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using model::Stage;

namespace {

Vector3d vector_at(std::span<const float> values, std::size_t i) {
  return Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

Points points_of(std::span<const float> values) {
  Points points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = vector_at(values, i);
  return points;
}

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

Eigen::Affine3d map_of(const shader::Bone& B) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.matrix().topRows<3>() << B.xx, B.xy, B.xz, B.xt, B.yx, B.yy, B.yz, B.yt, B.zx, B.zy, B.zz, B.zt;
  return map;
}

// The rotation in a map; none (the identity) if it mirrors or flattens.
Quaterniond rotation_in(const Eigen::Affine3d& map) {
  const Matrix3d linear = map.linear();
  if (linear.determinant() <= 0.0) return Quaterniond::Identity();
  return best_rotation(linear, Quaterniond::Identity());
}

}  // namespace

struct Oracle::Impl {
  Impl(const model::Model& of, const model::SolverOptions& with)
      : model(of),
        options(with),
        rest(points_of(of.rest)),
        weights(region_weights(of)),
        ties(of),
        limits(of),
        regions(of.vertex_count) {
    if (model.is_implicit()) stiffness = vertex_stiffness(model, region_stiffness(model));
    for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
      regions[r].c0 = region_centre(weights, r, rest);
      const Vector3d& c0 = regions[r].c0;
      rest_moment.push_back(region_moment(weights, r, Matrix3d::Identity(), rest, c0, rest, c0));
    }
  }

  const model::Model& model;
  const model::SolverOptions options;
  const Points rest;
  const Weights weights;
  const Ties ties;
  const Limits limits;
  std::vector<Matrix3d> rest_moment;  // A_r at rest
  std::vector<double> stiffness;      // K_i; empty with the explicit integrator

  // History.
  std::uint64_t frame = 0;
  std::array<double, 3> origin{0, 0, 0};
  Points q, v;
  Points skinned;                   // of the last substep; empty without a skeleton
  Points skinned_velocities;        // u of the last substep; empty where the model carries nothing
  std::vector<RegionPose> regions;  // of these only R is history
  Points q_before, v_before;        // implicit: a substep before
  double step_before = 0.0;         // s: the length of that substep; 0 if there was none

  // Between the stages of a substep.
  Points skinned_before;
  Points turned_gravity;  // the bones' change of gravity
  Points tied;            // accelerations by ties; empty without
  Points goals;
  Points surface;
  Points y, iterate_before;            // implicit
  std::vector<VertexHistory> history;  // implicit: as the substep began

  std::deque<model::Frame> frames;

  void skin(std::span<const shader::Bone> bones);
  void predict(const Vector3d& gravity, std::span<const shader::Force> forces, double h);
  void region(std::span<const shader::Muscle> muscles);
  void goal();
  void integrate(std::span<const float> decay, double h);
  Vector3d acceleration_of(std::uint32_t i, const Vector3d& gravity,
                           std::span<const shader::Force> forces) const;
  void begin_implicit(const Vector3d& gravity, std::span<const shader::Force> forces, const Stepping& step,
                      double share);
  void relax(double gain, double omega, const Stepping& step);
  void finish_implicit(const Stepping& step);
  double stiffest(const Stepping& step) const;
  void embed();

  Matrix3d scale_of_region(std::uint32_t r, std::span<const shader::Muscle> muscles) const;
  Vector3d skinned_velocity(std::uint32_t i, double h) const;
  void carry(const model::Cut& cut, double h);
  std::vector<float> output(Stage stage) const;
};

// Linear blend skinning: sum_k w_k B_k q0_i, and the same blend of the bones' change of gravity, g - R_k g.
void Oracle::Impl::skin(std::span<const shader::Bone> bones) {
  skinned_before = skinned;
  turned_gravity.assign(skinned.size(), Vector3d::Zero());
  for (std::uint32_t i = 0; i < skinned.size(); ++i) {
    skinned[i].setZero();
    for (std::uint32_t k = model.skin_offset[i]; k < model.skin_offset[i + 1]; ++k) {
      const shader::Bone& bone = bones[model.skin_joint[k]];
      skinned[i] += double(model.skin_weight[k]) * (map_of(bone) * rest[i]);
      turned_gravity[i] +=
          double(model.skin_weight[k]) * Vector3d(bone.gravity_x, bone.gravity_y, bone.gravity_z);
    }
  }
}

// A cut: relative to the skeleton nothing happens. With R the turn from the blended map of the motion that
// ends to that of the one that begins, q' = s' + R (q - s) and v' = u' + R (v - u).
void Oracle::Impl::carry(const model::Cut& cut, double h) {
  const auto blended = [&](std::span<const shader::Bone> pose, std::uint32_t i) {
    Eigen::Affine3d map;
    map.matrix().setZero();
    for (std::uint32_t k = model.skin_offset[i]; k < model.skin_offset[i + 1]; ++k)
      map.matrix() += double(model.skin_weight[k]) * map_of(pose[model.skin_joint[k]]).matrix();
    return map;
  };
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Eigen::Affine3d from = blended(cut.at, i), to = blended(cut.to, i);
    const Vector3d s = from * rest[i], s_next = to * rest[i];
    const Vector3d u = (s - blended(cut.before, i) * rest[i]) / h;
    const Vector3d u_next = (blended(cut.after, i) * rest[i] - s_next) / h;
    const Quaterniond R = rotation_in(to) * rotation_in(from).conjugate();
    q[i] = s_next + R * (q[i] - s);
    v[i] = u_next + R * (v[i] - u);
    skinned[i] = s_next;
    if (!model.carried.empty()) skinned_velocities[i] = u_next;
    regions[i].R = (R * regions[i].R).normalized();
  }
  step_before = 0.0;
}

// f_i/m_i = gravity, as it has changed in the bones' frames, + the scene's forces by their coefficients +
// ties.
Vector3d Oracle::Impl::acceleration_of(std::uint32_t i, const Vector3d& gravity,
                                       std::span<const shader::Force> forces) const {
  Vector3d acceleration = tied.empty() ? gravity : gravity + tied[i];
  if (model.has_skeleton()) acceleration += turned_gravity[i];
  if (model.force_count > 0) {
    for (std::uint32_t k = model.force_offset[i]; k < model.force_offset[i + 1]; ++k) {
      const shader::Force& f = forces[model.force_index[k]];
      acceleration += double(model.force_coefficient[k]) * Vector3d(f.x, f.y, f.z);
    }
  }
  return acceleration;
}

// The forces' half of (4). What of the skeleton's acceleration the vertex does not feel moves it along.
void Oracle::Impl::predict(const Vector3d& gravity, std::span<const shader::Force> forces, double h) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    if (!model.carried.empty())
      v[i] += double(model.carried[i]) * (skinned_velocity(i, h) - skinned_velocities[i]);
    v[i] = velocity_with_forces(v[i], acceleration_of(i, gravity, forces), h);
  }
}

// (15)(16)(17) of all muscles of a region, then the shear of their twist; the identity outside the muscles.
Matrix3d Oracle::Impl::scale_of_region(std::uint32_t r, std::span<const shader::Muscle> muscles) const {
  if (model.muscle_count == 0) return Matrix3d::Identity();
  const shader::RegionFrame& directions = model.region_frame[r];
  const Vector3d n =
      Vector3d(directions.normal_x, directions.normal_y, directions.normal_z).stableNormalized();
  const Vector3d axis(directions.axis_x, directions.axis_y, directions.axis_z);
  const Vector3d around(directions.around_x, directions.around_y, directions.around_z);
  double bulge = 0.0, shear = 0.0;
  for (std::uint32_t e = model.muscle_offset[r]; e < model.muscle_offset[r + 1]; ++e) {
    const shader::RegionMuscle& entry = model.region_muscle[e];
    const shader::Muscle& muscle = muscles[entry.muscle];
    bulge += double(entry.bulge) * (n.dot(Vector3d(muscle.tau_x, muscle.tau_y, muscle.tau_z)) + muscle.swell);
    shear += double(entry.shear) * muscle.twist;
  }
  return muscle_twist(axis, around, shear) * muscle_scale(n, muscle_stretch(bulge));
}

// (8), (9) and the volume term. A moment below 2^-40 of the rest moment keeps the last rotation, and so does
// a region without weights.
void Oracle::Impl::region(std::span<const shader::Muscle> muscles) {
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    RegionPose& pose = regions[r];
    pose.T = scale_of_region(r, muscles);
    pose.c = region_centre(weights, r, q);
    const Matrix3d A = region_moment(weights, r, pose.T, rest, pose.c0, q, pose.c);
    if (A.norm() > std::ldexp(rest_moment[r].norm(), -40)) pose.R = best_rotation(A, pose.R);
    if (!model.volume_gain.empty() && model.volume_gain[r] > 0.0f) {
      const Matrix3d untouched = region_moment(weights, r, Matrix3d::Identity(), rest, pose.c0, q, pose.c);
      pose.V = volume_push(untouched, rest_moment[r], double(model.volume_gain[r]));
    }
  }
}

// (10) and (11).
void Oracle::Impl::goal() {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    goals[i] = blended_goal(weights, i, regions, rest, q);
}

Vector3d Oracle::Impl::skinned_velocity(std::uint32_t i, double h) const {
  if (!model.has_skeleton()) return Vector3d::Zero();
  return (skinned[i] - skinned_before[i]) / h;
}

// The other half of (4), damping, and (5). Kinematic vertices go where skinning takes them, or stay.
void Oracle::Impl::integrate(std::span<const float> decay, double h) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d u = skinned_velocity(i, h);
    if (!model.carried.empty()) skinned_velocities[i] = u;
    if (model.is_kinematic(i)) {
      if (model.has_skeleton()) q[i] = skinned[i];
      v[i] = u;
      continue;
    }
    v[i] = velocity_to_goal(v[i], model.alpha[i], goals[i], q[i], h);
    v[i] = damped_velocity(v[i], u, decay[model.layer_of(i)]);
    q[i] = moved_position(q[i], v[i], h);
  }
}

// The implicit integrator's predict: y and where the iterations start. The velocity u that damping is
// relative to is the skinned one at the substep's end, and what the vertex does not feel of the skeleton's
// acceleration is an acceleration.
void Oracle::Impl::begin_implicit(const Vector3d& gravity, std::span<const shader::Force> forces,
                                  const Stepping& step, double share) {
  history.resize(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    history[i] = {q[i], step.has_history ? q_before[i] : q[i], v[i], step.has_history ? v_before[i] : v[i]};
    if (model.is_kinematic(i)) {
      if (model.has_skeleton()) q[i] = skinned[i];
      y[i] = q[i];
      continue;
    }
    Vector3d f = acceleration_of(i, gravity, forces);
    Vector3d u = skinned_velocity(i, step.h);
    if (!model.carried.empty()) {
      f += double(model.carried[i]) * (u - skinned_velocities[i]) / step.h;
      if (step.has_history) u = (3.0 * u - skinned_velocities[i]) / 2.0;
    }
    const double d = model.layers[model.layer_of(i)].damping;
    y[i] = predicted_position(history[i], step, f, d, u);
    q[i] = start_of_iterations(history[i], step, f, d, u, share);
  }
  iterate_before = q;
}

// x <- x_prev + omega (gain (x_hat - x) + x - x_prev)
void Oracle::Impl::relax(double gain, double omega, const Stepping& step) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    const double d = model.layers[model.layer_of(i)].damping;
    const Vector3d x_hat = pulled_position(y[i], goals[i], model.mass[i], stiffness[i], d, step);
    const Vector3d x = omega * (gain * (x_hat - q[i]) + q[i] - iterate_before[i]) + iterate_before[i];
    iterate_before[i] = q[i];
    q[i] = x;
  }
}

// The largest a of a free vertex: how far x_hat goes with the goal.
double Oracle::Impl::stiffest(const Stepping& step) const {
  double largest = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double d = model.layers[model.layer_of(i)].damping;
    const Vector3d x_hat =
        pulled_position(Vector3d::Zero(), Vector3d::UnitX(), model.mass[i], stiffness[i], d, step);
    if (!model.is_kinematic(i)) largest = std::max(largest, x_hat.x());
  }
  return largest;
}

void Oracle::Impl::finish_implicit(const Stepping& step) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const Vector3d u = skinned_velocity(i, step.h);
    if (!model.carried.empty()) skinned_velocities[i] = u;
    q_before[i] = history[i].q;
    v_before[i] = v[i];
    v[i] = model.is_kinematic(i) ? u : differentiated_position(q[i], history[i], step);
  }
}

// A render vertex rides on its four vertices by barycentric coordinates.
void Oracle::Impl::embed() {
  surface.assign(model.surface_count(), Vector3d::Zero());
  for (std::size_t k = 0; k < model.surface_vertex.size(); ++k)
    surface[k / 4] += double(model.surface_weight[k]) * q[model.surface_vertex[k]];
}

std::vector<float> Oracle::Impl::output(Stage stage) const {
  std::vector<float> values;
  switch (stage) {
    case Stage::skin:
      for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
        append(values, skinned[i]);
        append(values, turned_gravity[i]);
      }
      return values;
    case Stage::tie:
      return floats_of(tied);
    case Stage::predict:
      return floats_of(model.is_implicit() ? y : v);
    case Stage::region:
      for (const RegionPose& pose : regions) {
        const Matrix3d L = pose.R.toRotationMatrix() * pose.T + pose.V;
        for (int row = 0; row < 3; ++row) append(values, Vector3d(L.row(row)));
        append(values, Vector3d(pose.c - L * pose.c0));
        append(values, pose.R);
      }
      return values;
    case Stage::goal:
      return floats_of(goals);
    case Stage::relax:
    case Stage::limit:
      return floats_of(q);
    case Stage::integrate:
      for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
        append(values, q[i]);
        append(values, v[i]);
      }
      return values;
    case Stage::embed:
      return floats_of(surface);
  }
  return values;
}

// The rotation option names ways to approximate (9) in float; here (9) is solved, so it has no say.
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
  // Float solvers see float(h): the reference takes the same step.
  const double h = float(drive.h);
  const Vector3d gravity = vector_at(drive.gravity, 0);
  const Vector3d shift = vector_at(drive.origin_shift, 0);
  for (Vector3d& p : s.q) p -= shift;
  for (Vector3d& p : s.skinned) p -= shift;
  for (Vector3d& p : s.q_before) p -= shift;
  s.origin = drive.origin;
  ++s.frame;

  for (std::uint32_t substep = 0; substep < drive.substeps; ++substep) {
    for (const model::Cut& cut : drive.cuts)
      if (cut.substep == substep) s.carry(cut, h);
    const auto show = [&](Stage stage, std::uint32_t iteration = 0) {
      if (probe != nullptr) probe->on_stage({s.frame, substep, stage, iteration}, s.output(stage));
    };
    if (m.has_skeleton()) {
      s.skin(drive.bones.subspan(std::size_t{substep} * m.joint_count, m.joint_count));
      show(Stage::skin);
    }
    if (!s.ties.empty()) {
      s.tied = s.ties.accelerations(s.q, s.v, h);
      show(Stage::tie);
    }
    const auto forces = drive.forces.subspan(std::size_t{substep} * m.force_count, m.force_count);
    const auto muscles = drive.muscles.subspan(std::size_t{substep} * m.muscle_count, m.muscle_count);
    if (m.is_implicit()) {
      const Stepping step{h, s.step_before == drive.h};
      double gain = 0.0;
      for (const float g : m.volume_gain) gain = std::max(gain, double(g));
      const Chebyshev chebyshev(s.options.iterations, s.stiffest(step), gain / 2.0);
      s.begin_implicit(gravity, forces, step, chebyshev.extrapolated());
      show(Stage::predict);
      for (std::uint32_t k = 0; k < s.options.iterations; ++k) {
        s.region(muscles);
        show(Stage::region, k);
        s.goal();
        show(Stage::goal, k);
        s.relax(chebyshev.gain(k), chebyshev.omega(k), step);
        show(Stage::relax, k);
      }
      if (!s.limits.empty()) {
        s.limits.apply(s.q);
        show(Stage::limit);
      }
      s.finish_implicit(step);
      s.step_before = drive.h;
      show(Stage::integrate);
      continue;
    }
    s.predict(gravity, forces, h);
    show(Stage::predict);
    s.region(muscles);
    show(Stage::region);
    s.goal();
    show(Stage::goal);
    s.integrate(drive.decay, h);
    show(Stage::integrate);
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

// State holds floats, so a run that goes through save() and load() differs from one that does not by one
// rounding of positions and velocities (relative 6e-8).
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
