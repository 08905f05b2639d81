#include "host/made/made_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include <Eigen/Geometry>

#include "host/base/trigonometry.h"
#include "host/rig/pose_interpolation.h"

namespace fascicle::made {

using Eigen::Matrix3d;

Curve::Curve(std::vector<Key1> keys) : keys_(std::move(keys)), slopes_(keys_.size(), 0.0) {
  const auto slope = [&](std::size_t k) {
    return (keys_[k + 1].value - keys_[k].value) / (keys_[k + 1].time - keys_[k].time);
  };
  for (std::size_t k = 1; k + 1 < keys_.size(); ++k) {
    const double before = slope(k - 1), after = slope(k);
    if (before * after <= 0.0) continue;
    const double low = std::min(std::abs(before), std::abs(after)),
                 high = std::max(std::abs(before), std::abs(after));
    slopes_[k] = (before < 0.0 ? -1.0 : 1.0) * 3.0 * low * high / (high + 2.0 * low);
  }
}

double Curve::at(double time) const {
  if (time <= keys_.front().time) return keys_.front().value;
  if (time >= keys_.back().time) return keys_.back().value;
  std::size_t k = 0;
  while (time >= keys_[k + 1].time) ++k;
  const double span = keys_[k + 1].time - keys_[k].time;
  return rig::hermite(keys_[k].value, slopes_[k] * span, keys_[k + 1].value, slopes_[k + 1] * span,
                      (time - keys_[k].time) / span);
}

double motion_at(const std::vector<MotionKey>& keys, double time) {
  if (time <= keys.front().time) return keys.front().place;
  if (time >= keys.back().time) return keys.back().place;
  std::size_t k = 0;
  while (time >= keys[k + 1].time) ++k;
  const MotionKey &a = keys[k], &b = keys[k + 1];
  const double h = b.time - a.time, u = (time - a.time) / h;
  // Terms in u^3, u^4 and u^5 that make up the difference at `b` to the parabola from `a`.
  const double place = b.place - (a.place + h * a.velocity + 0.5 * h * h * a.acceleration);
  const double velocity = h * (b.velocity - (a.velocity + h * a.acceleration));
  const double acceleration = h * h * (b.acceleration - a.acceleration);
  const double c3 = 10.0 * place - 4.0 * velocity + 0.5 * acceleration;
  const double c4 = -15.0 * place + 7.0 * velocity - acceleration;
  const double c5 = 6.0 * place - 3.0 * velocity + 0.5 * acceleration;
  const double t = h * u;
  return a.place + t * (a.velocity + 0.5 * t * a.acceleration) + u * u * u * (c3 + u * (c4 + u * c5));
}

Matrix3d turn_about(const Vector3d& axis, double radians) {
  const double c = base::exact_cos(radians), s = base::exact_sin(radians), v = 1.0 - c;
  const double x = axis.x(), y = axis.y(), z = axis.z();
  Matrix3d m;
  m << v * x * x + c, v * x * y - s * z, v * x * z + s * y,  //
      v * x * y + s * z, v * y * y + c, v * y * z - s * x,   //
      v * x * z - s * y, v * y * z + s * x, v * z * z + c;
  return m;
}

Matrix3d shortest_turn(const Vector3d& from, const Vector3d& to) {
  const Vector3d w = from.cross(to);
  Matrix3d cross;
  cross << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return Matrix3d::Identity() + cross + cross * cross / (1.0 + from.dot(to));
}

Vector3d unit(const Vector3d& v) {
  return v / std::sqrt(v.squaredNorm());
}

namespace {

// Axes of a bone: along it, perpendicular to the limb's plane, and the third.
Matrix3d frame(const Vector3d& along, const Vector3d& side) {
  const Vector3d x = unit(along), y = unit(x.cross(side));
  Matrix3d axes;
  axes << x, y, x.cross(y);
  return axes;
}

}  // namespace

LimbTurns reach(const Limb& limb, const Vector3d& bind_side, const Vector3d& root, const Vector3d& target,
                const Vector3d& side) {
  const double upper = std::sqrt((limb.middle - limb.root).squaredNorm()),
               lower = std::sqrt((limb.end - limb.middle).squaredNorm());
  const Vector3d line = target - root;
  const double wanted = std::sqrt(line.squaredNorm());
  LimbTurns turns;
  turns.reaches = wanted <= upper + lower;
  const double span = turns.reaches ? wanted : upper + lower;
  const Vector3d along = line / wanted;
  const Vector3d out = unit(side - along * side.dot(along));
  const double foot = (span * span + upper * upper - lower * lower) / (2.0 * span);
  const double height = std::sqrt(std::max(upper * upper - foot * foot, 0.0));
  const Vector3d to_middle = foot * along + height * out;
  const Vector3d to_end = span * along - to_middle;
  turns.bend = base::exact_acos(to_middle.dot(to_end) / (upper * lower));
  turns.upper = frame(to_middle, side) * frame(limb.middle - limb.root, bind_side).transpose();
  turns.lower = frame(to_end, side) * frame(limb.end - limb.middle, bind_side).transpose();
  return turns;
}

std::uint32_t add_joint(rig::Character& character, const std::string& name, std::int32_t parent,
                        const Vector3d& place) {
  rig::Joint joint;
  joint.name = name;
  joint.parent = parent;
  joint.rest_translation =
      parent < 0 ? place : Vector3d(place - bind_place(character.skeleton[static_cast<std::size_t>(parent)]));
  joint.rest_local.topRightCorner<3, 1>() = joint.rest_translation;
  joint.inverse_bind.topRightCorner<3, 1>() = -place;
  joint.skins = true;
  character.skeleton.push_back(joint);
  return static_cast<std::uint32_t>(character.skeleton.size() - 1);
}

Vector3d bind_place(const rig::Joint& joint) {
  return -joint.inverse_bind.topRightCorner<3, 1>();
}

std::vector<Vector3d> places_of_joints(const rig::Character& character, const WorldPose& pose) {
  std::vector<Vector3d> places;
  for (const rig::Joint& joint : character.skeleton) {
    const auto parent = static_cast<std::size_t>(joint.parent);
    places.push_back(joint.parent < 0
                         ? pose.root
                         : Vector3d(places[parent] + pose.turns[parent] * joint.rest_translation));
  }
  return places;
}

namespace {

// x y z w. Starts from the largest of the four, which the diagonal gives, so that none is lost to rounding.
Eigen::Vector4d quaternion_of(const Matrix3d& m) {
  const std::array<double, 4> squares{1.0 + m(0, 0) - m(1, 1) - m(2, 2), 1.0 - m(0, 0) + m(1, 1) - m(2, 2),
                                      1.0 - m(0, 0) - m(1, 1) + m(2, 2), 1.0 + m(0, 0) + m(1, 1) + m(2, 2)};
  const auto largest = static_cast<int>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double r = std::sqrt(squares[static_cast<std::size_t>(largest)]), s = 0.5 / r;
  Eigen::Vector4d q;
  q[largest] = 0.5 * r;
  if (largest == 3) {
    q.head<3>() = s * Vector3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
  } else {
    const int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
    q[j] = s * (m(i, j) + m(j, i));
    q[k] = s * (m(i, k) + m(k, i));
    q[3] = s * (m(k, j) - m(j, k));
  }
  return q;
}

}  // namespace

rig::Clip clip_of_poses(const rig::Character& character, const std::string& name,
                        const std::vector<double>& times, const std::vector<WorldPose>& poses) {
  rig::Clip clip;
  clip.name = name;
  clip.duration = times.back();
  rig::Channel root{0, rig::ChannelPath::translation, rig::Interpolation::linear, times, {}};
  for (const WorldPose& pose : poses)
    root.values.insert(root.values.end(), pose.root.data(), pose.root.data() + 3);
  clip.channels.push_back(std::move(root));
  for (std::uint32_t j = 0; j < character.skeleton.size(); ++j) {
    rig::Channel turns{j, rig::ChannelPath::rotation, rig::Interpolation::linear, times, {}};
    const std::int32_t parent = character.skeleton[j].parent;
    for (const WorldPose& pose : poses) {
      const Matrix3d local =
          parent < 0 ? pose.turns[j]
                     : Matrix3d(pose.turns[static_cast<std::size_t>(parent)].transpose() * pose.turns[j]);
      Eigen::Vector4d q = quaternion_of(local);
      // Keeps neighbouring keys in the same hemisphere, as some glTF readers expect.
      if (!turns.values.empty()) {
        const double* before = turns.values.data() + turns.values.size() - 4;
        if (((before[0] * q[0] + before[1] * q[1]) + before[2] * q[2]) + before[3] * q[3] < 0.0) q = -q;
      }
      turns.values.insert(turns.values.end(), q.data(), q.data() + 4);
    }
    clip.channels.push_back(std::move(turns));
  }
  return clip;
}

}  // namespace fascicle::made
