// A hand that pulls flesh: a force on the vertices around one, which the solver takes as it takes any force
// of a scene. Nothing else of the model changes, and the flesh that is let go swings as it would.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::studio {

using Eigen::Vector3d;

// The free vertices around `vertex`, with the share of the pull that each takes: 1 in the middle, falling to
// 0 at `radius` (m, at rest). Reached from vertex to vertex, so that a hand on a thigh does not hold the arm
// beside it. Ascending; empty where none is free.
using Held = std::vector<std::pair<std::uint32_t, float>>;
Held held_around(const model::Model& model, std::uint32_t vertex, double radius);

// The model with one force more, the last, which gives each vertex its share as an acceleration.
model::Model with_hand(const model::Model& model, const Held& held);

// The hand's force, frame by frame. What it holds, with all that hangs on it, is taken for a mass on a
// spring: by the last frames the hand finds how many times its own mass moves with it, m, and how stiff the
// spring is, K. With x the way that the flesh has gone, v its speed and w the wanted way its acceleration is,
// of
//   soft flesh    K (x + 0.3 (w - x)) + m (144/s^2 (w - x) - 24/s v),
//   stiff flesh   0.3 of the way from what it was to K w each frame:
// what swings faster than frames tell is left to come to rest by itself. Between them it goes over.
class Hand {
 public:
  // `place`: where the hand takes hold, m. `frame`: the flesh now.
  Hand(const model::Model& model, Held held, const model::Frame& frame, const Vector3d& place);

  const Held& held() const { return held_; }
  // Where the flesh that it holds shall go, m; replaces a force.
  void move(const Vector3d& place);
  // A force in newtons in place of a place.
  void push(const Vector3d& force);

  // After a frame: looks where the flesh has gone. `seconds`: of a frame.
  void see(const model::Frame& frame, double seconds);

  // The drive's forces with the hand's at the end of each substep's, which goes over from the last frame's to
  // this one's.
  std::vector<shader::Force> forces(const model::Drive& drive, std::uint32_t forces_of_scene) const;

 private:
  // The mean of what it holds, by share: of a vertex's three numbers, in metres.
  Vector3d mean(const std::vector<float>& values) const;
  Vector3d middle(const std::vector<float>& positions, const std::array<double, 3>& origin) const;
  void learn(const Vector3d& faster, const Vector3d& way, const Vector3d& pulled, double seconds);

  double unit_;
  Held held_;
  double share_ = 0.0;                    // the sum of all
  double mass_ = 0.0;                     // kg, by share
  double reach_ = 0.0;                    // m: no pull wants to go further
  Vector3d grip_ = Vector3d::Zero();      // m: from the middle to where the hand took hold
  Vector3d lag_ = Vector3d::Zero();       // m: of the middle from skinning, before it pulled
  Vector3d still_ = Vector3d::Zero();     // m: the middle without a skeleton, before it pulled
  std::optional<Vector3d> free_;          // m: where the middle would be if nobody pulled, a frame ago
  Vector3d velocity_ = Vector3d::Zero();  // m/s: the middle's, relative to that, a frame ago
  // Of the last frames, the older the less: the normal equations of m and K (times a frame's time squared).
  double mass_mass_ = 0.0, mass_spring_ = 0.0, spring_spring_ = 0.0, mass_pull_ = 0.0, spring_pull_ = 0.0;
  std::optional<Vector3d> wanted_;  // m
  // m/s^2: at the end of this frame, and of the last.
  Vector3d acceleration_ = Vector3d::Zero(), before_ = Vector3d::Zero();
  double moved_ = 1.0;  // m
  double stiffness_;    // K, 1/s^2
};

}  // namespace fascicle::studio
