#include "host/drive/felt_acceleration.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fascicle::drive {

using scene::Vector3d;

namespace {

struct Bounds {
  Vector3d low = Vector3d::Constant(INFINITY), high = Vector3d::Constant(-INFINITY);
};

Vector3d image(const Eigen::Matrix4d& map, const Vector3d& p) {
  return map.topLeftCorner<3, 3>() * p + map.topRightCorner<3, 1>();
}

}  // namespace

std::uint64_t substeps_of_window(double h) {
  const double most = static_cast<double>(most_substeps_of_window);
  return static_cast<std::uint64_t>(std::clamp(std::round(felt_window / h), 1.0, most));
}

std::uint32_t main_joint(const model::Model& model, std::uint32_t i) {
  std::uint32_t best = model.skin_offset[i];
  for (std::uint32_t k = best; k < model.skin_offset[i + 1]; ++k)
    if (model.skin_weight[k] > model.skin_weight[best]) best = k;
  return model.skin_joint[best];
}

FeltAcceleration::FeltAcceleration(const scene::Scene& scene, const rig::Character& character,
                                   const model::Model& model)
    : scale_(scene.scale), corners_(character.skeleton.size()) {
  const std::vector<double> extents = model::extents(model, scene::first_joints(scene));
  for (std::size_t j = 0; j < corners_.size(); ++j) {
    // With linear interpolation, the acceleration at a key depends on the step length.
    const double by_size = scene.motion.interpolation == scene::KeyInterpolation::smooth
                               ? default_acceleration_limit * extents[scene::character_of_joint(scene, j)]
                               : INFINITY;
    limit_.push_back(scene.motion.acceleration_limit.value_or(by_size));
  }
  std::vector<Bounds> bounds(character.skeleton.size());
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i) || model.skin_offset[i] == model.skin_offset[i + 1]) continue;
    const std::uint32_t j = main_joint(model, i);
    Vector3d rest;
    for (int a = 0; a < 3; ++a)
      rest[a] = (double{model.rest[3 * std::size_t{i} + static_cast<std::size_t>(a)]} * model.unit +
                 model.rest_origin[static_cast<std::size_t>(a)]) /
                scale_;
    const Vector3d p = image(character.skeleton[j].inverse_bind, rest);
    bounds[j].low = bounds[j].low.cwiseMin(p);
    bounds[j].high = bounds[j].high.cwiseMax(p);
  }
  for (std::size_t j = 0; j < bounds.size(); ++j) {
    if (!(bounds[j].low[0] <= bounds[j].high[0])) continue;
    for (unsigned corner = 0; corner < 8; ++corner) {
      Vector3d p;
      for (int a = 0; a < 3; ++a) p[a] = (corner >> a & 1u) != 0 ? bounds[j].high[a] : bounds[j].low[a];
      corners_[j].push_back(p);
    }
  }
}

double FeltAcceleration::of_joint(std::size_t j, const Substeps& substeps) const {
  const Eigen::Matrix4d change =
      (substeps.last_to[j] - substeps.last_from[j]) - (substeps.first_to[j] - substeps.first_from[j]);
  double largest = 0.0;
  for (const Vector3d& p : corners_[j]) largest = std::max(largest, image(change, p).squaredNorm());
  return std::sqrt(largest) * scale_ / (substeps.h * substeps.apart);
}

Vector3d FeltAcceleration::in_middle(std::size_t j, const Pose& before, const Pose& at, const Pose& after,
                                     double h) const {
  const Eigen::Matrix4d change = (after[j] - at[j]) - (at[j] - before[j]);
  return image(change, 0.5 * (corners_[j].front() + corners_[j].back())) * (scale_ / (h * h));
}

}  // namespace fascicle::drive
