// Runs shared by several tests of the solvers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/model/solver.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

// Moves the joints, contracts and twists the muscles and varies the forces, along and about all axes, so that
// every path of a random model is used.
struct Sway {
  TestDrive drive;
  explicit Sway(const model::Model& model, double h = 1.0 / 480.0)
      : drive(quiet_drive(model, h, 3, {0.3, -9.81, 0.2})) {}
  model::Drive at(std::uint64_t frame) {
    const auto wave = [&](std::size_t k) {
      return static_cast<float>(std::sin(0.1 * static_cast<double>(frame) + 0.03 * static_cast<double>(k)));
    };
    for (std::size_t k = 0; k < drive.bones.size(); ++k) {
      drive.bones[k].xt = 0.02f * wave(k);
      drive.bones[k].xy = 0.05f * wave(k + 9);
      drive.bones[k].yx = -drive.bones[k].xy;
      drive.bones[k].zt = 0.02f * wave(k + 5);
      drive.bones[k].yz = 0.05f * wave(k + 14);
      drive.bones[k].zy = -drive.bones[k].yz;
    }
    for (std::size_t k = 0; k < drive.muscles.size(); ++k)
      drive.muscles[k] = {0.4f * wave(k + 3), 0.8f * wave(k), 0.4f * wave(k + 4), 0.5f * wave(k + 1),
                          wave(k + 2)};
    for (std::size_t k = 0; k < drive.forces.size(); ++k)
      drive.forces[k] = {wave(k), 0.5f * wave(k + 3), 0.7f * wave(k + 6), 0.0f};
    return drive.get();
  }
};

// How far a free body at rest moves in 2,000 substeps of 1/600 s, in working units.
inline double drift_at_rest(const model::Model& model, model::Solver& solver) {
  const model::State before = solver.save();
  TestDrive quiet = quiet_drive(model, 1.0 / 600.0, 20);
  for (int k = 0; k < 100; ++k) solver.submit(quiet.get(), {});
  const model::State after = solver.save();
  double largest = 0.0;
  for (std::size_t k = 0; k < before.positions.size(); ++k)
    largest = std::max(largest, static_cast<double>(std::abs(after.positions[k] - before.positions[k])));
  return largest;
}

}  // namespace fascicle::tests
