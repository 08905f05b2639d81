// Converts a model's float arrays, 3 per vertex, to the Oracle's points in double.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace fascicle::cpu_reference {

using Points = std::vector<Eigen::Vector3d>;

inline Eigen::Vector3d vector_at(std::span<const float> values, std::size_t i) {
  return Eigen::Vector3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

inline Points points_of(std::span<const float> values) {
  Points points(values.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = vector_at(values, i);
  return points;
}

}  // namespace fascicle::cpu_reference
