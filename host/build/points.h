// Arrays of floats, 3 per vertex, as vectors in double.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace fascicle::build {

inline Eigen::Vector3d vector_at(std::span<const float> values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

}  // namespace fascicle::build
