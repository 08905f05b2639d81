#include "cpu_reference/solver/stages.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <stdexcept>
#include <string>

#include "cpu_reference/solver/collide_stages.h"
#include "cpu_reference/solver/lane_stages.h"
#include "shaders/kernel/contact.inc"
#include "shaders/kernel/embed.inc"
#include "shaders/kernel/goal.inc"
#include "shaders/kernel/integrate.inc"
#include "shaders/kernel/limit.inc"
#include "shaders/kernel/predict.inc"
#include "shaders/kernel/region.inc"
#include "shaders/kernel/relax.inc"
#include "shaders/kernel/skin.inc"
#include "shaders/kernel/tie.inc"
#include "shaders/kernel/volume.inc"

namespace fascicle::cpu_reference {

namespace {

using Vector = kernel::Vector<float>;
using Matrix = kernel::Matrix<float>;
using Quaternion = kernel::Quaternion<float>;
using Transform = kernel::Transform<float>;
using RegionSum = kernel::RegionSum<float>;
using model::Model;

Vector vector_at(const float* v) {
  return {v[0], v[1], v[2]};
}

void put_vector(float* out, const Vector& v) {
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

Vector load_vector(const Floats& values, std::size_t i) {
  return vector_at(values.data() + vector_stride * i);
}

void store_vector(Floats& values, std::size_t i, const Vector& v) {
  put_vector(values.data() + vector_stride * i, v);
}

Vector load_position(const Fields& fields, std::size_t i) {
  return vector_at(fields.vertices.data() + vertex_stride * i);
}

void store_position(Fields& fields, std::size_t i, const Vector& v) {
  put_vector(fields.vertices.data() + vertex_stride * i, v);
}

Vector rest_of(const Model& model, std::size_t i) {
  return vector_at(model.rest.data() + 3 * i);
}

Transform load_transform(const Fields& fields, std::size_t r) {
  const float* t = fields.regions.data() + region_stride * r;
  return {{t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10]}, {t[3], t[7], t[11]}};
}

void store_transform(Fields& fields, std::size_t r, const Transform& t) {
  float* out = fields.regions.data() + region_stride * r;
  const float entries[12] = {t.linear.xx, t.linear.xy, t.linear.xz, t.translation.x,
                             t.linear.yx, t.linear.yy, t.linear.yz, t.translation.y,
                             t.linear.zx, t.linear.zy, t.linear.zz, t.translation.z};
  for (int k = 0; k < 12; ++k) out[k] = entries[k];
}

Transform transform_of(const shader::Bone& b) {
  return {{b.xx, b.xy, b.xz, b.yx, b.yy, b.yz, b.zx, b.zy, b.zz}, {b.xt, b.yt, b.zt}};
}

Vector gravity_of(const shader::Bone& b) {
  return {b.gravity_x, b.gravity_y, b.gravity_z};
}

// The velocity that skinning alone would give vertex i.
Vector velocity_of_skin(const Model& model, const SubstepInput& in, const Fields& fields, std::uint32_t i) {
  if (!model.has_skeleton()) return {0.0f, 0.0f, 0.0f};
  return kernel::skinned_velocity<float>(load_vector(fields.skinned, i),
                                         load_vector(fields.skinned_before, i), in.step.inverse_h);
}

// Acceleration of vertex i by gravity, the scene's forces and ties.
Vector external_acceleration(const Model& model, const SubstepInput& in, const Fields& fields,
                             std::uint32_t i) {
  Vector acceleration{in.step.gravity_x, in.step.gravity_y, in.step.gravity_z};
  if (model.has_skeleton())
    acceleration = kernel::add_gravity<float>(acceleration, load_vector(fields.gravity, i));
  if (model.force_count > 0) {
    for (std::uint32_t k = model.force_offset[i]; k < model.force_offset[i + 1]; ++k) {
      const shader::Force& f = in.forces[model.force_index[k]];
      acceleration = kernel::add_force<float>(acceleration, model.force_coefficient[k], {f.x, f.y, f.z});
    }
  }
  if (model.has_ties()) acceleration = kernel::vector_sum<float>(acceleration, load_vector(fields.tied, i));
  return acceleration;
}

Vector predicted_velocity(const Model& model, const SubstepInput& in, const Fields& fields, std::uint32_t i) {
  Vector velocity = load_vector(fields.velocities, i);
  if (model.is_kinematic(i)) return velocity;
  const Vector acceleration = external_acceleration(model, in, fields, i);
  if (!model.carried.empty())
    velocity =
        kernel::carry_velocity<float>(velocity, model.carried[i], velocity_of_skin(model, in, fields, i),
                                      load_vector(fields.skinned_velocities, i));
  return kernel::predict_velocity<float>(velocity, acceleration, in.step.h);
}

// Requires a region with a muscle.
Matrix scale_of_muscles(const Model& model, const SubstepInput& in, std::uint32_t r) {
  const shader::RegionFrame& frame = model.region_frame[r];
  const Vector n{frame.normal_x, frame.normal_y, frame.normal_z};
  float bulge = 0.0f, shear = 0.0f;
  for (std::uint32_t e = model.muscle_offset[r]; e < model.muscle_offset[r + 1]; ++e) {
    const shader::RegionMuscle& entry = model.region_muscle[e];
    const shader::Muscle& m = in.muscles[entry.muscle];
    const float bulge_term =
        kernel::muscle_bulge<float>(n, entry.bulge, {m.tau_x, m.tau_y, m.tau_z}, m.swell);
    const float shear_term = entry.shear * m.twist;
    const bool is_first = e == model.muscle_offset[r];
    bulge = is_first ? bulge_term : bulge + bulge_term;
    shear = is_first ? shear_term : shear + shear_term;
  }
  return kernel::muscle_twist<float>(kernel::muscle_scale<float>(n, bulge),
                                     {frame.axis_x, frame.axis_y, frame.axis_z},
                                     {frame.around_x, frame.around_y, frame.around_z}, shear);
}

Vector blended_goal(const Model& model, const Fields& fields, std::uint32_t i) {
  const Transform own = load_transform(fields, i);
  Transform blend = own;
  for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e)
    blend = kernel::goal_add<float>(blend, model.share_given[e], load_transform(fields, model.ring[e]), own);
  return kernel::goal_position<float>(blend, rest_of(model, i));
}

void move(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i, const Vector& velocity,
          const Vector& goal) {
  const Vector u = velocity_of_skin(model, in, fields, i);
  if (!model.carried.empty()) store_vector(fields.skinned_velocities, i, u);
  if (model.is_kinematic(i)) {
    if (model.has_skeleton()) store_position(fields, i, load_vector(fields.skinned, i));
    store_vector(fields.velocities, i, u);
    return;
  }
  const Vector position = load_position(fields, i);
  const Vector v = kernel::integrate_velocity<float>(
      velocity, position, goal, model.alpha[i] * in.step.inverse_h, u, in.decay[model.layer_of(i)]);
  store_vector(fields.velocities, i, v);
  store_position(fields, i, kernel::integrate_position<float>(position, v, in.step.h));
}

// y, and the start of the iterations.
void begin_implicit(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  const Vector q = load_position(fields, i);
  const Vector q_before = load_vector(fields.positions_before, i);
  store_vector(fields.positions_before, i, q);
  const Vector v = load_vector(fields.velocities, i), v_before = load_vector(fields.velocities_before, i);
  store_vector(fields.velocities_before, i, v);
  const auto start_at = [&](const Vector& start) {
    store_position(fields, i, start);
    store_vector(fields.iterate_before, i, start);
  };
  if (model.is_kinematic(i)) {
    const Vector there = model.has_skeleton() ? load_vector(fields.skinned, i) : q;
    start_at(there);
    store_vector(fields.predicted, i, there);
    return;
  }
  Vector acceleration = external_acceleration(model, in, fields, i);
  Vector u = velocity_of_skin(model, in, fields, i);
  if (!model.carried.empty()) {
    const Vector before = load_vector(fields.skinned_velocities, i);
    acceleration =
        kernel::carry_acceleration<float>(acceleration, model.carried[i] * in.step.inverse_h, u, before);
    u = kernel::with_history<float>(u, before, in.implicit.skin_history);
  }
  const shader::Response& answer = in.responses[i];
  const Vector v_y =
      kernel::predict_damped<float>(kernel::with_history<float>(v, v_before, in.implicit.history),
                                    acceleration, u, in.implicit.step, answer.kept, answer.dragged);
  store_vector(fields.predicted, i,
               kernel::predict_position<float>(q, q_before, in.implicit.history, v_y, in.implicit.step));
  store_vector(fields.velocities, i, v_y);
  start_at(kernel::start_position<float>(q, v, v_before, acceleration, u, in.step.h, in.step.inverse_h,
                                         in.implicit.start, in.implicit.extrapolated, answer.kept,
                                         answer.dragged));
}

void relax_free(const SubstepInput& in, Fields& fields, std::uint32_t i, const Vector& goal) {
  const shader::Response& answer = in.responses[i];
  const Vector x = load_position(fields, i);
  store_position(fields, i,
                 kernel::relax_position<float>(x, load_vector(fields.iterate_before, i),
                                               load_vector(fields.predicted, i), goal, answer.to_goal,
                                               answer.to_inertia, in.implicit.gain, in.implicit.omega));
  store_vector(fields.iterate_before, i, x);
}

// The position is known, the velocity follows.
void finish_implicit(const Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i) {
  const Vector u = velocity_of_skin(model, in, fields, i);
  if (!model.carried.empty()) store_vector(fields.skinned_velocities, i, u);
  Vector v = u;
  if (!model.is_kinematic(i))
    v = kernel::pulled_velocity<float>(load_vector(fields.velocities, i), load_position(fields, i),
                                       load_vector(fields.predicted, i), load_vector(fields.goals, i),
                                       in.responses[i].to_goal, in.implicit.inverse_step);
  store_vector(fields.velocities, i, v);
}

}  // namespace

void rebase(const SubstepInput& in, Fields& fields, Range range) {
  const Vector shift{in.step.shift_x, in.step.shift_y, in.step.shift_z};
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    store_position(fields, i, kernel::rebase<float>(load_position(fields, i), shift));
    if (!fields.positions_before.empty())
      store_vector(fields.positions_before, i,
                   kernel::rebase<float>(load_vector(fields.positions_before, i), shift));
    if (!fields.skinned.empty())
      store_vector(fields.skinned, i, kernel::rebase<float>(load_vector(fields.skinned, i), shift));
  }
}

void skin(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    std::uint32_t k = model.skin_offset[i];
    const auto map_term = [&] {
      return kernel::skin_term<float>(model.skin_weight[k], transform_of(in.bones[model.skin_joint[k]]));
    };
    const auto gravity_term = [&] {
      return kernel::skin_gravity_term<float>(model.skin_weight[k],
                                              gravity_of(in.bones[model.skin_joint[k]]));
    };
    Transform blend = map_term();
    Vector gravity = gravity_term();
    for (++k; k < model.skin_offset[i + 1]; ++k) {
      blend = kernel::skin_add<float>(blend, map_term());
      gravity = kernel::skin_gravity_add<float>(gravity, gravity_term());
    }
    store_vector(fields.skinned, i, kernel::skin_position<float>(blend, rest_of(model, i)));
    store_vector(fields.gravity, i, kernel::snap_vector<float>(gravity));
  }
}

void tie(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  const auto place_of = [&](std::uint32_t i) {
    const Vector x = load_position(fields, i);
    return model.is_implicit() ? kernel::place_ahead<float>(x, load_vector(fields.velocities, i), in.step.h)
                               : x;
  };
  const auto entry_term = [&](std::uint32_t i, std::uint32_t e) {
    const shader::Tie& t = model.tie[model.tie_index[e]];
    const kernel::TiePush<float> p = kernel::tie_push<float>(
        place_of(t.sliding), place_of(t.corner_a), place_of(t.corner_b), place_of(t.corner_c), t.mobility_a,
        t.mobility_b, t.mobility_c, t.rest_height);
    const float of_corner = i == t.corner_a ? p.of_a : i == t.corner_b ? p.of_b : p.of_c;
    const float coefficient = model.tie_coefficient[e];
    return kernel::scaled_vector<float>(i == t.sliding ? -coefficient : coefficient * of_corner, p.push);
  };
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    const std::uint32_t first = model.tie_offset[i], end = model.tie_offset[i + 1];
    Vector acceleration{0.0f, 0.0f, 0.0f};
    if (first < end) {
      Vector sum = entry_term(i, first);
      for (std::uint32_t e = first + 1; e < end; ++e) sum = kernel::vector_sum<float>(sum, entry_term(i, e));
      acceleration = kernel::tie_acceleration<float>(sum, in.step.inverse_h);
    }
    store_vector(fields.tied, i, acceleration);
  }
}

void predict(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_implicit())
      begin_implicit(model, in, fields, i);
    else
      store_vector(fields.predicted, i, predicted_velocity(model, in, fields, i));
  }
}

void region(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t r = range.first; r < range.last; ++r) {
    const Vector position = load_position(fields, r), rest = rest_of(model, r);
    const float* centre = model.region_rest.data() + 4 * std::size_t{r};
    Vector o{centre[0], centre[1], centre[2]};
    const float inverse_weight = centre[3];
    RegionSum sum{};
    if (inverse_weight > 0.0f) {
      for (std::uint32_t e = model.ring_offset[r]; e < model.ring_offset[r + 1]; ++e) {
        const std::uint32_t i = model.ring[e];
        const RegionSum term = kernel::region_term<float>(
            model.share_taken[e] * model.pull[i], kernel::subtract<float>(load_position(fields, i), position),
            kernel::subtract<float>(rest_of(model, i), rest));
        sum = e == model.ring_offset[r] ? term : kernel::region_add<float>(sum, term);
      }
    }
    Matrix moment = kernel::region_moment<float>(sum, o);
    Matrix push{};
    const bool has_volume = !model.region_volume.empty();
    if (has_volume) {
      const float* volume = model.region_volume.data() + 3 * std::size_t{r};
      push = kernel::volume_push<float>(moment, volume[0], volume[1], volume[2]);
    }
    Matrix scale{};
    const bool has_muscle = model.muscle_count > 0 && model.muscle_offset[r] < model.muscle_offset[r + 1];
    if (has_muscle) {
      scale = scale_of_muscles(model, in, r);
      moment = kernel::multiply_transposed<float>(moment, scale);
    }
    float* rotation = fields.regions.data() + region_stride * r + rotation_place;
    const Quaternion q = kernel::extract_rotation<float>({rotation[0], rotation[1], rotation[2], rotation[3]},
                                                         moment, in.mueller);
    rotation[0] = q.w;
    rotation[1] = q.x;
    rotation[2] = q.y;
    rotation[3] = q.z;
    Matrix linear = kernel::matrix_of<float>(q);
    if (has_muscle) linear = kernel::multiply_matrices<float>(linear, scale);
    if (has_volume) linear = kernel::add<float>(linear, push);
    store_transform(fields, r,
                    kernel::region_transform<float>(linear, sum, o, inverse_weight, position, rest));
  }
}

void goal(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i)
    store_vector(fields.goals, i, blended_goal(model, fields, i));
}

void integrate(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_implicit())
      finish_implicit(model, in, fields, i);
    else
      move(model, in, fields, i, load_vector(fields.predicted, i), load_vector(fields.goals, i));
  }
}

void relax(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i)
    if (!model.is_kinematic(i)) relax_free(in, fields, i, load_vector(fields.goals, i));
}

namespace {

// place(i) is vertex i's position.
template <class PlaceOf>
kernel::LimitVolume<float> volume_of(const shader::Limit& l, const PlaceOf& place) {
  return kernel::limit_volume<float>(place(l.corner_a), place(l.corner_b), place(l.corner_c),
                                     place(l.corner_d), l.inverse_size);
}

}  // namespace

void lack(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t t = range.first; t < range.last; ++t) {
    const shader::Limit& l = model.limit[t];
    const float volume = volume_of(l, [&](std::uint32_t i) { return load_position(fields, i); }).volume;
    float least = l.least;
    if (kernel::limit_lack<float>(volume, least) > 0.0f) {
      const auto before = [&](std::uint32_t i) { return load_vector(fields.positions_before, i); };
      least = kernel::limit_least<float>(least, volume_of(l, before).volume, in.implicit.step);
    }
    fields.lack[t] = kernel::limit_lack<float>(volume, least);
  }
}

void crowd(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    float count = 0.0f;
    for (std::uint32_t e = model.limit_offset[i]; e < model.limit_offset[i + 1]; ++e)
      if (fields.lack[model.limit_entry[e] / 4] > 0.0f) count += 1.0f;
    fields.load[i] = count * model.mobility[i];
    store_vector(fields.iterate_before, i, load_position(fields, i));
  }
}

void push(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t t = range.first; t < range.last; ++t) {
    const shader::Limit& l = model.limit[t];
    const kernel::LimitVolume<float> v =
        volume_of(l, [&](std::uint32_t i) { return load_vector(fields.iterate_before, i); });
    const float push =
        kernel::limit_push<float>(v, fields.lack[t], fields.load[l.corner_a], fields.load[l.corner_b],
                                  fields.load[l.corner_c], fields.load[l.corner_d], l.least_square, l.size);
    float* to = fields.terms.data() + 12 * std::size_t{fields.term_place[t]};
    for (const Vector& gradient : {kernel::limit_first_gradient<float>(v), v.by_b, v.by_c, v.by_d}) {
      const Vector term = kernel::limit_term<float>(push, gradient);
      for (const float part : {term.x, term.y, term.z}) *to++ = part;
    }
  }
}

void limit(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (!(fields.load[i] > 0.0f)) continue;
    Vector sum{};
    bool is_first = true;
    for (std::uint32_t e = model.limit_offset[i]; e < model.limit_offset[i + 1]; ++e) {
      const std::uint32_t t = model.limit_entry[e] / 4;
      if (!(fields.lack[t] > 0.0f)) continue;
      const float* from =
          fields.terms.data() + 12 * std::size_t{fields.term_place[t]} + 3 * (model.limit_entry[e] % 4);
      const Vector term{from[0], from[1], from[2]};
      sum = is_first ? term : kernel::vector_sum<float>(sum, term);
      is_first = false;
    }
    const Vector move = kernel::limit_move<float>(sum, model.mobility[i]);
    store_position(fields, i, kernel::limit_moved<float>(load_position(fields, i), move));
    for (Floats* field : {&fields.predicted, &fields.goals})
      store_vector(*field, i, kernel::limit_moved<float>(load_vector(*field, i), move));
    store_vector(
        fields.velocities, i,
        kernel::limit_velocity<float>(load_vector(fields.velocities, i), move, in.implicit.inverse_step));
  }
}

void iterate(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_kinematic(i)) continue;
    const Vector g = blended_goal(model, fields, i);
    store_vector(fields.goals, i, g);
    relax_free(in, fields, i, g);
  }
}

void update(const Model& model, const SubstepInput& in, Fields& fields, Range range) {
  for (std::uint32_t i = range.first; i < range.last; ++i) {
    if (model.is_kinematic(i))
      move(model, in, fields, i, {}, {});
    else
      move(model, in, fields, i, predicted_velocity(model, in, fields, i), blended_goal(model, fields, i));
  }
}

void embed(const Model& model, const SubstepInput&, Fields& fields, Range range) {
  for (std::uint32_t s = range.first; s < range.last; ++s) {
    const std::uint32_t* v = model.surface_vertex.data() + 4 * std::size_t{s};
    const float* w = model.surface_weight.data() + 4 * std::size_t{s};
    for (std::size_t c = 0; c < 3; ++c)
      fields.surface[3 * std::size_t{s} + c] = kernel::embed_coordinate<float>(
          w[0], fields.vertices[vertex_stride * v[0] + c], w[1], fields.vertices[vertex_stride * v[1] + c],
          w[2], fields.vertices[vertex_stride * v[2] + c], w[3], fields.vertices[vertex_stride * v[3] + c]);
  }
}

namespace {

enum class InLanes { always, of_implicit, with_qcp };

struct KernelRow {
  model::Kernel kernel;
  ModelStage one_by_one;
  LaneStage LaneStages::*in_lanes = nullptr;
  InLanes when = InLanes::always;
};
constexpr KernelRow kernel_code[] = {
    {model::Kernel::skin, &skin, &LaneStages::skin},
    {model::Kernel::tie, &tie},
    {model::Kernel::predict, &predict, &LaneStages::predict, InLanes::of_implicit},
    {model::Kernel::region, &region, &LaneStages::region, InLanes::with_qcp},
    {model::Kernel::goal, &goal},
    {model::Kernel::relax, &relax},
    {model::Kernel::obstruct, &obstruct},
    {model::Kernel::collide, &collide},
    {model::Kernel::integrate, &integrate, &LaneStages::integrate, InLanes::of_implicit},
    {model::Kernel::update, &update, &LaneStages::update},
    {model::Kernel::iterate, &iterate, &LaneStages::iterate},
    {model::Kernel::embed, &embed},
};

}  // namespace

KernelCode code_of(model::Kernel kernel, const Model& model, model::Rotation rotation) {
  const KernelRow* row = std::find_if(std::begin(kernel_code), std::end(kernel_code),
                                      [&](const KernelRow& r) { return r.kernel == kernel; });
  if (row == std::end(kernel_code))
    throw std::logic_error("kernel " + std::string(name_of(kernel)) +
                           " has no row in kernel_code (cpu_reference/solver/stages.cpp)");
  const bool has_lanes = row->when == InLanes::always ||
                         (row->when == InLanes::of_implicit && model.is_implicit()) ||
                         (row->when == InLanes::with_qcp && rotation == model::Rotation::qcp);
  return {row->one_by_one, has_lanes ? row->in_lanes : nullptr};
}

}  // namespace fascicle::cpu_reference
