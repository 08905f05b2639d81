// A small made character: a bar of flesh around two bones, the second of which bends.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

inline constexpr double bar_height = 0.6;  // m, its longest side

// 0.6 x 0.2 x 0.2 m, unit 1, along x. Joint 0 stands at the origin, joint 1 is its child 0.3 m along; the
// vertices on the axis are kinematic. A scene of `seconds` at 60 fps and 8 substeps, without clip, lead-in
// or damping relative to the world.
struct BendingBar {
  scene::Scene scene;
  model::Model model;
  rig::Character& character() { return std::get<rig::Character>(scene.geometry); }
};
BendingBar bending_bar(double seconds);

// The last two numbers of a quaternion x y z w about z.
std::array<double, 2> about_z(double angle);

// Root keys: times, and for each an angle about z and a translation.
struct RootKey {
  double time;
  Eigen::Vector3d place;
};
rig::Channel root_channel(const std::vector<RootKey>& keys,
                          rig::Interpolation interpolation = rig::Interpolation::linear);
// A channel that turns `joint` about z.
rig::Channel turn_channel(std::uint32_t joint, const std::vector<double>& times,
                          const std::vector<double>& angles);

// World positions of all vertices, metres, after each frame; frame 0 first.
using Motion = std::vector<std::vector<Eigen::Vector3d>>;
struct Walked {
  Motion positions, skinned;
  model::State last;
};
// Through lead-in and `frames` frames on the CPU.
Walked run(const BendingBar& bar, std::uint64_t frames);

// m, the furthest that a vertex of `a` is from its place in `b` moved by `shift`.
double furthest(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                const Eigen::Vector3d& shift = Eigen::Vector3d::Zero());

}  // namespace fascicle::tests
