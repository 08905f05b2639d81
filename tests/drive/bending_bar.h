// A small generated character: a bar of flesh around two bones, of which the second bends.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

inline constexpr double bar_height = 0.6;  // m, its longest side

// 0.6 x 0.2 x 0.2 m along x, unit 1. Joint 0 is at the origin, joint 1 is its child 0.3 m along x; the
// vertices on the axis are kinematic. A scene of `seconds` at 60 fps and 8 substeps, without clip, lead-in or
// damping relative to the world.
struct BendingBar {
  scene::Scene scene;
  model::Model model;
  rig::Character& character() { return std::get<rig::Character>(scene.geometry); }
};
BendingBar bending_bar(double seconds);

// The z and w of a quaternion x y z w about z.
std::array<double, 2> about_z(double angle);

// A key of the root: its time and translation.
struct RootKey {
  double time;
  Eigen::Vector3d place;
};
rig::Channel root_channel(const std::vector<RootKey>& keys,
                          rig::Interpolation interpolation = rig::Interpolation::linear);
// A channel that rotates `joint` about z.
rig::Channel turn_channel(std::uint32_t joint, const std::vector<double>& times,
                          const std::vector<double>& angles);

// World positions of all vertices in metres, for each frame from 0 on.
using Motion = std::vector<std::vector<Eigen::Vector3d>>;
struct Walked {
  Motion positions, skinned;
  model::State last;
};
// Runs the lead-in and `frames` frames on the CPU.
Walked run(const BendingBar& bar, std::uint64_t frames);

// The largest distance in m between a vertex of `a` and the same vertex of `b` moved by `shift`.
double furthest(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                const Eigen::Vector3d& shift = Eigen::Vector3d::Zero());

}  // namespace fascicle::tests
