#include "host/model/solver.h"

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <string>

namespace fascicle::model {

const char* name_of(Stage stage) {
  switch (stage) {
    case Stage::skin:
      return "skin";
    case Stage::predict:
      return "predict";
    case Stage::region:
      return "region";
    case Stage::goal:
      return "goal";
    case Stage::integrate:
      return "integrate";
    case Stage::embed:
      return "embed";
  }
  return "";
}

std::uint32_t stage_width(Stage stage) {
  switch (stage) {
    case Stage::region:
      return 16;
    case Stage::integrate:
      return 6;
    default:
      return 3;
  }
}

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
  check("decay", drive.decay.size(), model.layers.size());
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
}

namespace {

using Matrix3 = std::array<double, 9>;  // row by row

// What the solvers' stages guarantee of their outputs holds for the first state too: nothing below 2^-40 but
// zero.
float rounded(double x) {
  const float f = static_cast<float>(x);
  return std::abs(f) < 0x1p-40f ? 0.0f : f;
}

double determinant(const Matrix3& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

// The rotation nearest to m by Newton's iteration for the polar factor, R <- (R + R^-T)/2 (Higham 1986); the
// identity for a map that mirrors or flattens, where there is none to start from.
Matrix3 nearest_rotation(Matrix3 m) {
  const Matrix3 identity{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (int step = 0; step < 40; ++step) {
    const double d = determinant(m);
    if (!(d > 1e-12)) return identity;
    const Matrix3 cofactor{m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
                           m[2] * m[7] - m[1] * m[8], m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7],
                           m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3]};
    double change = 0.0;
    for (std::size_t k = 0; k < 9; ++k) {
      const double next = 0.5 * (m[k] + cofactor[k] / d);
      change += std::abs(next - m[k]);
      m[k] = next;
    }
    if (change < 1e-15) break;
  }
  return m;
}

// w x y z of a rotation matrix, by its largest component (Shepperd 1978).
std::array<double, 4> quaternion_of(const Matrix3& r) {
  const double trace = r[0] + r[4] + r[8];
  std::array<double, 4> q{};
  if (trace >= r[0] && trace >= r[4] && trace >= r[8]) {
    q = {1.0 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  } else if (r[0] >= r[4] && r[0] >= r[8]) {
    q = {r[7] - r[5], 1.0 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6]};
  } else if (r[4] >= r[8]) {
    q = {r[2] - r[6], r[1] + r[3], 1.0 + r[4] - r[0] - r[8], r[5] + r[7]};
  } else {
    q = {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1.0 + r[8] - r[0] - r[4]};
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& c : q) c /= length;
  return q;
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
  state.skinned.resize(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    std::array<double, 12> blend{};
    for (std::uint32_t k = model.skin_offset[i]; k < model.skin_offset[i + 1]; ++k) {
      const shader::Bone& b = pose[model.skin_joint[k]];
      const std::array<float, 12> entries{b.xx, b.xy, b.xz, b.xt, b.yx, b.yy,
                                          b.yz, b.yt, b.zx, b.zy, b.zz, b.zt};
      for (std::size_t c = 0; c < 12; ++c)
        blend[c] += static_cast<double>(model.skin_weight[k]) * static_cast<double>(entries[c]);
    }
    for (std::size_t row = 0; row < 3; ++row) {
      double x = blend[4 * row + 3];
      for (std::size_t c = 0; c < 3; ++c)
        x += blend[4 * row + c] * static_cast<double>(model.rest[3 * i + c]);
      state.positions[3 * i + row] = state.skinned[3 * i + row] = rounded(x);
    }
    const Matrix3 linear{blend[0], blend[1], blend[2], blend[4], blend[5],
                         blend[6], blend[8], blend[9], blend[10]};
    const std::array<double, 4> q = quaternion_of(nearest_rotation(linear));
    for (std::size_t c = 0; c < 4; ++c) state.rotations[4 * i + c] = rounded(q[c]);
  }
  return state;
}

State rest_state(const Model& model) {
  const std::vector<shader::Bone> pose(model.joint_count, shader::Bone{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  return initial_state(model, pose, model.rest_origin);
}

}  // namespace fascicle::model
