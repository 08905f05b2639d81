// States made on the host: the first one, and one carried over a cut.
#include <cmath>
#include <stdexcept>

#include "host/model/rotation.h"
#include "host/model/solver.h"

namespace fascicle::model {

namespace {

using Vector3 = std::array<double, 3>;

// Like the outputs of the solvers' stages, states hold no magnitude below 2^-40 except zero.
float rounded(double x) {
  const float f = static_cast<float>(x);
  return std::abs(f) < 0x1p-40f ? 0.0f : f;
}

Vector3 vector_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

void write_rounded(const Vector3& v, std::vector<float>& values, std::size_t i) {
  for (std::size_t c = 0; c < 3; ++c) values[3 * i + c] = rounded(v[c]);
}

struct Blend {
  Matrix3 linear{};
  Vector3 translation{};
  Vector3 apply(const Vector3& p) const {
    Vector3 r = multiply(linear, p);
    for (std::size_t c = 0; c < 3; ++c) r[c] += translation[c];
    return r;
  }
};

Blend blend_of(const Model& model, std::span<const shader::Bone> pose, std::size_t i) {
  Blend blend;
  for (std::uint32_t k = model.skin_offset[i]; k < model.skin_offset[i + 1]; ++k) {
    const shader::Bone& b = pose[model.skin_joint[k]];
    const double w = double{model.skin_weight[k]};
    const std::array<float, 9> linear{b.xx, b.xy, b.xz, b.yx, b.yy, b.yz, b.zx, b.zy, b.zz};
    const std::array<float, 3> translation{b.xt, b.yt, b.zt};
    for (std::size_t c = 0; c < 9; ++c) blend.linear[c] += w * double{linear[c]};
    for (std::size_t c = 0; c < 3; ++c) blend.translation[c] += w * double{translation[c]};
  }
  return blend;
}

Vector3 velocity(const Vector3& from, const Vector3& to, double h) {
  Vector3 v{};
  for (std::size_t c = 0; c < 3; ++c) v[c] = (to[c] - from[c]) / h;
  return v;
}

// `there` + R (v - `here`)
Vector3 moved(const Vector3& v, const Vector3& here, const Matrix3& R, const Vector3& there) {
  Vector3 offset{};
  for (std::size_t c = 0; c < 3; ++c) offset[c] = v[c] - here[c];
  Vector3 r = multiply(R, offset);
  for (std::size_t c = 0; c < 3; ++c) r[c] += there[c];
  return r;
}

}  // namespace

State initial_state(const Model& model, std::span<const shader::Bone> pose,
                    const std::array<double, 3>& origin) {
  const std::size_t n = model.vertex_count;
  State state;
  state.origin = origin;
  state.positions.resize(3 * n);
  state.velocities.assign(3 * n, 0.0f);
  state.rotations.assign(4 * n, 0.0f);
  for (std::size_t i = 0; i < n; ++i) state.rotations[4 * i] = 1.0f;
  if (!model.has_skeleton()) {
    for (std::size_t k = 0; k < 3 * n; ++k) {
      const double metres = model.rest_origin[k % 3] - origin[k % 3];
      state.positions[k] = rounded(static_cast<double>(model.rest[k]) + metres / model.unit);
    }
    return state;
  }
  if (pose.size() != model.joint_count)
    throw std::invalid_argument("initial_state: pose does not fit the model's joints");
  for (std::size_t i = 0; i < n; ++i) {
    const Blend blend = blend_of(model, pose, i);
    write_rounded(blend.apply(vector_at(model.rest, i)), state.positions, i);
    const Quaternion q = quaternion_of(nearest_rotation(blend.linear));
    for (std::size_t c = 0; c < 4; ++c) state.rotations[4 * i + c] = rounded(q[c]);
  }
  state.skinned = state.positions;
  state.skinned_velocities.assign(3 * model.carried.size(), 0.0f);
  return state;
}

State carried(const Model& model, const State& state, double h, const Cut& cut) {
  check_state(model, state);
  State next = state;
  next.origin = cut.origin;
  next.positions_before.clear();
  next.velocities_before.clear();
  next.step_before = 0.0;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    const Vector3 rest = vector_at(model.rest, i);
    const Blend from = blend_of(model, cut.at, i), to = blend_of(model, cut.to, i);
    const Vector3 s = from.apply(rest), s_next = to.apply(rest);
    const Vector3 u = velocity(blend_of(model, cut.before, i).apply(rest), s, h);
    const Vector3 u_next = velocity(s_next, blend_of(model, cut.after, i).apply(rest), h);
    const Matrix3 R = multiply(nearest_rotation(to.linear), transposed(nearest_rotation(from.linear)));
    write_rounded(moved(vector_at(state.positions, i), s, R, s_next), next.positions, i);
    write_rounded(moved(vector_at(state.velocities, i), u, R, u_next), next.velocities, i);
    write_rounded(s_next, next.skinned, i);
    if (!model.carried.empty()) write_rounded(u_next, next.skinned_velocities, i);
    const float* r = &state.rotations[4 * i];
    const Quaternion q = multiply(quaternion_of(R), {double{r[0]}, double{r[1]}, double{r[2]}, double{r[3]}});
    for (std::size_t c = 0; c < 4; ++c) next.rotations[4 * i + c] = rounded(q[c]);
  }
  return next;
}

State rest_state(const Model& model) {
  const std::vector<shader::Bone> pose(model.joint_count, bone_at_rest);
  return initial_state(model, pose, model.rest_origin);
}

}  // namespace fascicle::model
