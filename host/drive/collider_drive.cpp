#include "host/drive/collider_drive.h"

#include <algorithm>
#include <variant>

#include "host/base/trigonometry.h"
#include "host/drive/pose_blend.h"
#include "host/drive/pose_bones.h"
#include "host/model/rotation.h"

namespace fascicle::drive {

using Eigen::Matrix3d;
using scene::Solid;
using scene::Vector3d;

namespace {

// 1/s: rate at which flesh that starts inside a solid is lifted out, as a share of its depth. Slow enough
// that such a scene starts without a jolt.
constexpr double lifting_rate = 5.0;

// Interpolates between keys; constant before the first and after the last.
Vector3d between_keys(const std::vector<double>& times, const std::vector<Vector3d>& values, double time) {
  if (values.empty()) return Vector3d::Zero();
  const auto next =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (next == 0) return values.front();
  if (next == times.size()) return values.back();
  const double share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  return values[next - 1] + share * (values[next] - values[next - 1]);
}

// From the body's space (working units relative to `origin`) into the solid's own: three rows of four.
void write_map(const Solid& solid, const Vector3d& origin, double unit, float* rows) {
  const Matrix3d turn = solid.axes.transpose();
  const Vector3d shift = turn * ((origin - solid.center) / unit);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) *rows++ = static_cast<float>(turn(r, c));
    *rows++ = static_cast<float>(shift[r]);
  }
}

}  // namespace

ColliderDrive::ColliderDrive(const scene::Scene& scene, const model::Model& model, double h)
    : scene_(scene),
      unit_(model.unit),
      lifted_(static_cast<float>(1.0 - base::exact_exp(-lifting_rate * h))) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  for (const scene::Collider& collider : scene.colliders) {
    Moved moved{&collider, scene::bound_solid_of(scene, collider), none};
    if (character != nullptr && !collider.joint.empty()) {
      moved.joint = 0;
      while (character->skeleton[moved.joint].name != collider.joint) ++moved.joint;
    }
    moved_.push_back(moved);
  }
}

Solid ColliderDrive::placed(const Moved& moved, const Moment& at) const {
  Solid solid = moved.solid;
  if (moved.joint == none) {
    const scene::Collider& c = *moved.collider;
    solid.center += between_keys(c.times, c.offsets, at.time);
    solid.axes = scene::turned_by(between_keys(c.times, c.turns, at.time)) * solid.axes;
    return solid;
  }
  const auto& joint = std::get<rig::Character>(scene_.geometry).skeleton[moved.joint];
  const Eigen::Matrix4d map = (*at.pose)[moved.joint] * joint.inverse_bind;
  solid.center = map.topLeftCorner<3, 3>() * solid.center + map.topRightCorner<3, 1>() * scene_.scale;
  const model::Matrix3 turn = model::nearest_rotation(rows_of(map));
  solid.axes = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(turn.data()) * solid.axes;
  return solid;
}

std::vector<Solid> ColliderDrive::solids(const Moment& at) const {
  std::vector<Solid> all;
  for (const Moved& moved : moved_) all.push_back(placed(moved, at));
  return all;
}

void ColliderDrive::append(const Moment& before, const Moment& at, const Vector3d& origin,
                           std::vector<shader::Collider>& to) const {
  for (const Moved& moved : moved_) {
    const Solid now = placed(moved, at);
    shader::Collider& c = to.emplace_back();
    write_map(now, origin, unit_, &c.xx);
    write_map(placed(moved, before), origin, unit_, &c.before_xx);
    c.half_x = static_cast<float>(now.half_size[0] / unit_);
    c.half_y = static_cast<float>(now.half_size[1] / unit_);
    c.half_z = static_cast<float>(now.half_size[2] / unit_);
    c.radius = static_cast<float>(now.radius / unit_);
    c.friction = static_cast<float>(moved.collider->friction);
    c.lifted = lifted_;
    c.is_plane = now.is_plane ? 1.0f : 0.0f;
  }
}

}  // namespace fascicle::drive
