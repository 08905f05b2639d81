#include "host/drive/pose_bones.h"

#include <variant>

#include "host/drive/pose_blend.h"
#include "host/model/rotation.h"

namespace fascicle::drive {

using scene::Vector3d;

Vector3d change_of_gravity(const Eigen::Matrix4d& map, const Vector3d& gravity) {
  const auto turned = model::multiply(model::nearest_rotation(rows_of(map)), array_of(gravity));
  return gravity - Vector3d(turned[0], turned[1], turned[2]);
}

Vector3d whole_units(const Vector3d& point, double unit) {
  const Vector3d units = point / unit;
  return (units + Vector3d::Constant(0.5)).array().floor().matrix() * unit;
}

// A pose is in the file's metres, times scale in the scene's; unit and origin give the solver's. With rest
// positions x = (p - rest_origin) / unit a map p -> L p + t becomes x -> L x + (L rest_origin + t - origin) /
// unit.
void append_bones(const scene::Scene& scene, const model::Model& model, const Pose& pose,
                  const Vector3d& origin, std::vector<shader::Bone>& to) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  const Vector3d rest_origin(model.rest_origin[0], model.rest_origin[1], model.rest_origin[2]);
  for (std::size_t j = 0; j < pose.size(); ++j) {
    const Eigen::Matrix4d map = pose[j] * character.skeleton[j].inverse_bind;
    const Eigen::Matrix3d l = map.topLeftCorner<3, 3>();
    const Vector3d t = (l * rest_origin + map.topRightCorner<3, 1>() * scene.scale - origin) / model.unit;
    Vector3d g = Vector3d::Zero();
    if (scene.motion.rest == scene::Rest::sculpted) g = change_of_gravity(map, scene.gravity) / model.unit;
    const auto f = [](double x) { return static_cast<float>(x); };
    to.push_back({f(l(0, 0)), f(l(0, 1)), f(l(0, 2)), f(t[0]),  //
                  f(l(1, 0)), f(l(1, 1)), f(l(1, 2)), f(t[1]),  //
                  f(l(2, 0)), f(l(2, 1)), f(l(2, 2)), f(t[2]),  //
                  f(g[0]), f(g[1]), f(g[2]), 0.0f});
  }
}

}  // namespace fascicle::drive
