#include "host/build/bind_place.h"

#include <Eigen/LU>

#include "host/base/text.h"
#include "host/build/message.h"
#include "host/model/reach.h"

namespace fascicle::build {

using scene::Vector3d;

namespace {

[[noreturn]] void fail_for_inverse(const rig::Joint& joint, const std::string& source) {
  fail(source, "joint \"" + joint.name + "\": its inverse bind matrix has no inverse");
}

Vector3d bind_position(const rig::Joint& joint, const std::string& source) {
  const Eigen::FullPivLU<Eigen::Matrix4d> factored(joint.inverse_bind);
  if (joint.inverse_bind.allFinite() && factored.isInvertible()) {
    const Eigen::Vector4d origin = factored.solve(Eigen::Vector4d(0, 0, 0, 1));
    return origin.head<3>() / origin[3];
  }
  // Next to a translation of 1e8, a rotation counts as zero.
  const Eigen::FullPivLU<Eigen::Matrix3d> linear(joint.inverse_bind.topLeftCorner<3, 3>());
  if (!joint.inverse_bind.allFinite() || !linear.isInvertible() ||
      joint.inverse_bind.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    fail_for_inverse(joint, source);
  return -linear.solve(joint.inverse_bind.topRightCorner<3, 1>());
}

}  // namespace

Vector3d bind_place(const rig::Joint& joint, double scale, const std::string& source) {
  const Vector3d place = scale * bind_position(joint, source);
  if (!place.allFinite()) fail_for_inverse(joint, source);
  if (!(place.cwiseAbs().maxCoeff() < model::farthest))
    fail(source, "joint \"" + joint.name + "\": it is " + base::number_text(place.cwiseAbs().maxCoeff()) +
                     " m away from the origin, which cannot be simulated; move the character nearer");
  return place;
}

}  // namespace fascicle::build
