// Converts a pose for solvers: the bones' maps in working units.
#pragma once

#include <array>
#include <vector>

#include "host/drive/timeline.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::drive {

inline std::array<double, 3> array_of(const scene::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

// g - R g with R the rotation of a joint's map: the change of gravity in the joint's frame.
scene::Vector3d change_of_gravity(const Eigen::Matrix4d& map, const scene::Vector3d& gravity);

// A point rounded to whole working units, metres. The unit is a power of two, so this rounding and
// differences of origins are exact.
scene::Vector3d whole_units(const scene::Vector3d& point, double unit);

// Appends one bone per joint of the scene's character, relative to `origin` (metres of the scene).
void append_bones(const scene::Scene& scene, const model::Model& model, const Pose& pose,
                  const scene::Vector3d& origin, std::vector<shader::Bone>& to);

}  // namespace fascicle::drive
