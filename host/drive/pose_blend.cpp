#include "host/drive/pose_blend.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/model/rotation.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::drive {

model::Matrix3 rows_of(const Eigen::Matrix4d& map) {
  model::Matrix3 rows{};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rows[static_cast<std::size_t>(3 * r + c)] = map(r, c);
  return rows;
}

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

// Inverse of an affine map; empty if it is singular.
std::optional<Matrix4d> inverse_by_cofactors(const Matrix4d& map) {
  const auto minor_of = [&](int r, int c) {
    const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return map(r1, c1) * map(r2, c2) - map(r1, c2) * map(r2, c1);  // cyclic, so it has the cofactor's sign
  };
  const double determinant =
      map(0, 0) * minor_of(0, 0) + map(0, 1) * minor_of(0, 1) + map(0, 2) * minor_of(0, 2);
  if (!(std::abs(determinant) > 1e-30)) return std::nullopt;
  Matrix4d inverse = Matrix4d::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) inverse(r, c) = minor_of(c, r) / determinant;
  inverse.topRightCorner<3, 1>() = -(inverse.topLeftCorner<3, 3>() * map.topRightCorner<3, 1>());
  return inverse;
}

// A map decomposed into a rotation after a stretch, and a translation.
struct Parts {
  Vector4d rotation;  // x y z w
  Matrix3d stretch;
  Vector3d translation;
};

Parts parts_of(const Matrix4d& map) {
  const model::Matrix3 rows = rows_of(map);
  const model::Matrix3 rotation = model::nearest_rotation(rows);
  const model::Matrix3 stretch = model::multiply(model::transposed(rotation), rows);
  const model::Quaternion q = model::quaternion_of(rotation);
  Parts parts{{q[1], q[2], q[3], q[0]}, Matrix3d::Zero(), map.topRightCorner<3, 1>()};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) parts.stretch(r, c) = stretch[static_cast<std::size_t>(3 * r + c)];
  return parts;
}

Matrix4d blend(const Matrix4d& a, const Matrix4d& b, double share) {
  const Parts from = parts_of(a), to = parts_of(b);
  Matrix4d map = rig::local_transform(from.translation + (to.translation - from.translation) * share,
                                      rig::slerp(from.rotation, to.rotation, share), Vector3d::Ones());
  map.topLeftCorner<3, 3>() =
      (map.topLeftCorner<3, 3>() * (from.stretch + (to.stretch - from.stretch) * share)).eval();
  return map;
}

// The joints' maps in the bind pose. A node that skins nothing has none, so it stays fixed to its parent.
std::vector<Matrix4d> bind_pose(const rig::Character& character) {
  std::vector<Matrix4d> bind(character.skeleton.size());
  for (std::size_t j = 0; j < bind.size(); ++j) {
    const rig::Joint& joint = character.skeleton[j];
    const auto inverse = joint.skins ? inverse_by_cofactors(joint.inverse_bind) : std::nullopt;
    const Matrix4d& above = joint.parent < 0 ? character.root : bind[static_cast<std::size_t>(joint.parent)];
    bind[j] = inverse ? *inverse : Matrix4d(above * joint.rest_local);
  }
  return bind;
}

}  // namespace

std::vector<Matrix4d> blend_from_bind(const rig::Character& character, std::size_t root,
                                      const std::vector<Matrix4d>& pose, double share) {
  const std::vector<Matrix4d> bind = bind_pose(character);
  // Both poses are relative to the root's motion from the bind pose, so that the body as a whole stands
  // still.
  const auto back = inverse_by_cofactors(bind[root]);
  const Matrix4d carry = back ? Matrix4d(pose[root] * *back) : Matrix4d(Matrix4d::Identity());
  const Matrix4d away = inverse_by_cofactors(carry).value_or(Matrix4d(Matrix4d::Identity()));
  std::vector<Matrix4d> blended(pose.size());
  for (std::size_t j = 0; j < pose.size(); ++j) {
    const std::int32_t parent = character.skeleton[j].parent;
    const auto p = static_cast<std::size_t>(std::max(parent, 0));
    const auto above_bind = parent < 0 ? std::nullopt : inverse_by_cofactors(bind[p]);
    const auto above_pose = parent < 0 ? std::nullopt : inverse_by_cofactors(pose[p]);
    if (above_bind && above_pose)
      blended[j] = blended[p] * blend(*above_bind * bind[j], *above_pose * pose[j], share);
    else
      blended[j] = blend(bind[j], away * pose[j], share);
  }
  for (Matrix4d& map : blended) map = (carry * map).eval();
  return blended;
}

}  // namespace fascicle::drive
