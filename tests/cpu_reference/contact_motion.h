// Measures of a body's motion for the contact tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "tests/cpu_reference/oracle_run.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests {

inline Points points_in(const std::vector<float>& values) {
  Points points;
  for (std::uint32_t i = 0; 3 * std::size_t{i} < values.size(); ++i) points.push_back(triple_at(values, i));
  return points;
}

inline double largest_in(const Points& points) {
  double largest = 0.0;
  for (const Eigen::Vector3d& p : points) largest = std::max(largest, p.norm());
  return largest;
}

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
};

inline Momentum momentum_of(const model::Model& m, const Points& places, const Points& velocities) {
  Momentum sum;
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    sum.linear += m.mass[i] * velocities[i];
    sum.angular += m.mass[i] * places[i].cross(velocities[i]);
  }
  return sum;
}

// The blocks moving towards each other along x, 8 mm apart.
inline model::State thrown(const TwoBlocks& blocks, model::State state, double speed) {
  float most = -2.0f, least = 2.0f;
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i) {
    const float x = state.positions[3 * std::size_t{i}];
    if (i < blocks.first_of_second)
      most = std::max(most, x);
    else
      least = std::min(least, x);
  }
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i) {
    const bool second = i >= blocks.first_of_second;
    if (second) state.positions[3 * std::size_t{i}] += most - least + 0.008f;
    state.velocities[3 * std::size_t{i}] = float(second ? -speed : speed);
  }
  return state;
}

}  // namespace fascicle::tests
