// Shared by the Oracle's tests: setting a state, stepping, comparing.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "cpu_reference/oracle/oracle.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

using Points = std::vector<Eigen::Vector3d>;

inline Points rest_points(const model::Model& model) {
  Points points;
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    points.emplace_back(model.rest[3 * i], model.rest[3 * i + 1], model.rest[3 * i + 2]);
  return points;
}

inline std::vector<float> to_floats(const Points& points) {
  std::vector<float> floats;
  for (const Eigen::Vector3d& p : points)
    for (int k = 0; k < 3; ++k) floats.push_back(float(p[k]));
  return floats;
}

// Positions and velocities as given (rounded to float), identity rotations, skinned positions at rest.
inline void set_state(const model::Model& model, cpu_reference::Oracle& oracle, const Points& q,
                      const Points& v) {
  model::State state = oracle.save();
  state.positions = to_floats(q);
  state.velocities = to_floats(v);
  for (std::size_t r = 0; r < model.vertex_count; ++r)
    for (std::size_t k = 0; k < 4; ++k) state.rotations[4 * r + k] = k == 0 ? 1.0f : 0.0f;
  oracle.load(state);
}

inline void advance(cpu_reference::Oracle& oracle, TestDrive& drive, int frames = 1) {
  for (int k = 0; k < frames; ++k) {
    oracle.submit(drive.get(), {});
    oracle.collect();
  }
}

inline double largest_distance(const Points& a, const Points& b) {
  double largest = a.size() == b.size() ? 0.0 : 1e300;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double distance = (a[i] - b[i]).norm();
    if (!(distance <= largest)) largest = distance;  // lets a NaN in and keeps it
  }
  return largest;
}

}  // namespace fascicle::tests
