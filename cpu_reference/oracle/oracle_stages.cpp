// The stages of a substep in double precision, as in the paper, and their output for probes.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "cpu_reference/oracle/oracle_impl.h"

namespace fascicle::cpu_reference {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

Eigen::Affine3d map_of(const shader::Bone& B) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.matrix().topRows<3>() << B.xx, B.xy, B.xz, B.xt, B.yx, B.yy, B.yz, B.yt, B.zx, B.zy, B.zz, B.zt;
  return map;
}

// The rotation in a map; the identity if it mirrors or flattens.
Quaterniond rotation_in(const Eigen::Affine3d& map) {
  const Matrix3d linear = map.linear();
  if (linear.determinant() <= 0.0) return Quaterniond::Identity();
  return best_rotation(linear, Quaterniond::Identity());
}

}  // namespace

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

// A cut preserves the motion relative to the skeleton. With R the rotation from the blended map of the motion
// that ends to that of the one that begins, q' = s' + R (q - s) and v' = u' + R (v - u).
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

// f_i/m_i = gravity, as changed in the bones' frames, + the scene's forces by their coefficients + ties.
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

// The force half of (4). The part of the skeleton's acceleration that a vertex does not feel carries it
// along.
void Oracle::Impl::predict(const Vector3d& gravity, std::span<const shader::Force> forces, double h) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    if (!model.carried.empty())
      v[i] += double(model.carried[i]) * (skinned_velocity(i, h) - skinned_velocities[i]);
    v[i] = velocity_with_forces(v[i], acceleration_of(i, gravity, forces), h);
  }
}

// (15)(16)(17) for all muscles of a region, then the shear from their twist; the identity outside the
// muscles.
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

// The other half of (4), damping, and (5). Kinematic vertices follow skinning, or stay.
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

// The implicit integrator's predict: y and the start of the iterations. Damping is relative to the skinned
// velocity u at the substep's end, and the part of the skeleton's acceleration that a vertex does not feel is
// applied as an acceleration.
void Oracle::Impl::begin_implicit(const Vector3d& gravity, std::span<const shader::Force> forces,
                                  const Stepping& step, double share) {
  history.resize(model.vertex_count);
  is_pushed.assign(model.vertex_count, false);
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
      u += step.bdf2() / 2.0 * (u - skinned_velocities[i]);
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

// Each iteration ends outside the solids.
void Oracle::Impl::obstruct(const Substep& now) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i))
      q[i] = collided(model, now.colliders, i, history[i].q, q[i], v[i], now.h).place;
}

// The moves of limits enter the velocity, like any other move that the iterations find.
void Oracle::Impl::apply_limits(const Stepping& step) {
  const Points before = q;
  Points began(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) began[i] = history[i].q;
  limits.apply(q, began, step.length());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    y[i] += q[i] - before[i];
    goals[i] += q[i] - before[i];
  }
}

// Ends an explicit substep, with the velocity that takes the vertex there.
void Oracle::Impl::collide(const Substep& now) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    if (model.is_implicit()) {
      collide_implicit(i, now);
      continue;
    }
    const Collided there = collided(model, now.colliders, i, q[i] - now.h * v[i], q[i], v[i], now.h);
    v[i] += (there.place - q[i] - there.raised) / now.h;
    q[i] = there.place;
  }
}

// The solids' impulse is that on a freely moving body, and the history is shifted as if it had included the
// impulse.
void Oracle::Impl::collide_implicit(std::uint32_t i, const Substep& now) {
  const double d = model.layers[model.layer_of(i)].damping;
  const Vector3d free_place = pulled_position(y[i], goals[i], model.mass[i], stiffness[i], d, *now.stepping);
  const Vector3d free_velocity = differentiated_position(free_place, history[i], *now.stepping);
  const auto sent_to = [&](const Vector3d& place) {
    return collided(model, now.colliders, i, history[i].q, place, free_velocity, now.h);
  };
  // The iterations end outside the solids, so test as well where the vertex would be without what they pushed
  // away.
  Collided there = sent_to(q[i]);
  const Collided pushed = sent_to(free_place);
  if (!there.touches && !pushed.touches) return;
  if (pushed.touches) there.velocity = pushed.velocity;
  const Vector3d impulse = there.velocity - free_velocity;
  q[i] = there.place;
  v[i] = there.velocity;
  history[i].q += there.place - free_place - now.h * impulse;
  history[i].v += impulse;
  is_pushed[i] = true;
}

// The largest a of a free vertex: how far x_hat moves with the goal.
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
    v_before[i] = history[i].v;
    if (is_pushed[i]) continue;
    v[i] = model.is_kinematic(i) ? u : differentiated_position(q[i], history[i], step);
  }
}

void Oracle::Impl::respond_to_contacts(double h) {
  const Points gains = contacts.velocity_gains(contacts_found, v, h);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    q[i] += h * gains[i];
    v[i] += gains[i];
  }
}

// Moves the goals too, as solids in the same iteration test where the vertex would be without them.
void Oracle::Impl::hold_contacts(const Stepping& step) {
  Points moved(model.vertex_count);
  std::vector<double> yielding(model.vertex_count), to_goal(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    const double d = model.layers[model.layer_of(i)].damping;
    to_goal[i] =
        pulled_position(Vector3d::Zero(), Vector3d::UnitX(), model.mass[i], stiffness[i], d, step).x();
    yielding[i] = model.is_kinematic(i) ? 0.0 : (1.0 - to_goal[i]) / model.mass[i];
    moved[i] = q[i] - history[i].q;
  }
  const Points moves = contacts.held_moves(contacts_found, moved, yielding, step.length());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    q[i] += moves[i];
    if (to_goal[i] > 0.0) goals[i] += moves[i] / to_goal[i];
  }
}

void Oracle::Impl::settle_contacts(const Stepping& step) {
  const Points gains = contacts.settling_gains(contacts_found, v, v_before, step.second());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) v[i] += gains[i];
}

// Barycentric coordinates attach a render vertex to its four vertices.
void Oracle::Impl::embed() {
  surface.assign(model.surface_count(), Vector3d::Zero());
  for (std::size_t k = 0; k < model.surface_vertex.size(); ++k)
    surface[k / 4] += double(model.surface_weight[k]) * q[model.surface_vertex[k]];
}

void Oracle::Impl::run(model::Kernel kernel, const Substep& now, std::uint32_t iteration) {
  using model::Kernel;
  switch (kernel) {
    case Kernel::skin:
      return skin(now.bones);
    case Kernel::tie:
      tied = ties.accelerations(q, v, now.h);
      return;
    case Kernel::contact:
      return respond_to_contacts(now.h);
    case Kernel::contact_yield:
      return hold_contacts(*now.stepping);
    case Kernel::contact_rest:
      return settle_contacts(*now.stepping);
    case Kernel::contact_find:
      contacts_found = contacts.found_at(q);
      return;
    case Kernel::contact_bound:
    case Kernel::contact_enclose:
    case Kernel::contact_chain:
    case Kernel::contact_crowd:
    case Kernel::contact_hold:
    case Kernel::contact_settle:
    case Kernel::contact_press:
      return;  // contact_find and the kernels that move vertices do the whole stage
    case Kernel::predict:
      if (model.is_implicit())
        return begin_implicit(now.gravity, now.forces, *now.stepping, now.chebyshev->extrapolated());
      return predict(now.gravity, now.forces, now.h);
    case Kernel::region:
      return region(now.muscles);
    case Kernel::goal:
      return goal();
    case Kernel::relax:
      return relax(now.chebyshev->gain(iteration), now.chebyshev->omega(iteration), *now.stepping);
    case Kernel::obstruct:
      return obstruct(now);
    case Kernel::limit:
      return apply_limits(*now.stepping);
    case Kernel::collide:
      return collide(now);
    case Kernel::integrate:
      if (model.is_implicit()) return finish_implicit(*now.stepping);
      return integrate(now.decay, now.h);
    case Kernel::embed:
      return embed();
    case Kernel::rebase:
    case Kernel::lack:
    case Kernel::crowd:
    case Kernel::update:
    case Kernel::iterate:
      break;
  }
  throw std::logic_error("oracle: " + std::string(name_of(kernel)) + " is not run by itself");
}

void Oracle::Impl::append_field(std::vector<float>& floats, model::Field field, std::uint32_t i) const {
  using model::Field;
  switch (field) {
    case Field::position:
      return append(floats, q[i]);
    case Field::velocity:
      return append(floats, v[i]);
    case Field::rotation:
      return append(floats, regions[i].R);
    case Field::transform: {
      const RegionPose& pose = regions[i];
      const Matrix3d L = pose.R.toRotationMatrix() * pose.T + pose.V;
      for (int row = 0; row < 3; ++row) append(floats, Vector3d(L.row(row)));
      return append(floats, Vector3d(pose.c - L * pose.c0));
    }
    case Field::goal:
      return append(floats, goals[i]);
    case Field::skinned:
      return append(floats, skinned[i]);
    case Field::gravity:
      return append(floats, turned_gravity[i]);
    case Field::predicted:
      return append(floats, model.is_implicit() ? y[i] : v[i]);
    case Field::tied:
      return append(floats, tied[i]);
    case Field::surface:
      return append(floats, surface[i]);
    default:
      throw std::logic_error("oracle: " + std::string(name_of(field)) + " is not shown");
  }
}

std::vector<float> Oracle::Impl::output(model::Stage stage) const {
  std::vector<float> floats;
  for (std::uint32_t i = 0; i < item_count(model, items_of(stage)); ++i)
    for (const model::Field field : shown_by(stage)) append_field(floats, field, i);
  return floats;
}

}  // namespace fascicle::cpu_reference
