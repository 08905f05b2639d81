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

// The hand's force, frame by frame. It finds out how stiff the flesh is by pulling: what it pulls with is
// what would hold the flesh at the wanted place, as far as the last frames tell.
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
  // The acceleration that the next frame has, m/s^2, and the force that this is, N.
  const Vector3d& acceleration() const { return acceleration_; }
  Vector3d force() const { return mass_ * acceleration_; }

  // The drive's forces with the hand's at the end of each substep's. Valid until the next call.
  std::vector<shader::Force> forces(const model::Drive& drive, std::uint32_t forces_of_scene) const;

 private:
  // Of what it holds, by share, m: where it is, and where skinning alone has it.
  Vector3d middle(const std::vector<float>& positions, const std::array<double, 3>& origin) const;

  double unit_;
  Held held_;
  double share_ = 0.0;                 // the sum of all
  double mass_ = 0.0;                  // kg, by share
  double reach_ = 0.0;                 // m: no pull wants to go further
  Vector3d grip_ = Vector3d::Zero();   // m: from the middle to where the hand took hold
  Vector3d lag_ = Vector3d::Zero();    // m: of the middle from skinning, before it pulled
  Vector3d still_ = Vector3d::Zero();  // m: the middle without a skeleton, before it pulled
  Vector3d last_ = Vector3d::Zero();   // m: the middle, relative to where it would be
  std::optional<Vector3d> wanted_;     // m
  Vector3d acceleration_ = Vector3d::Zero();
  double stiffness_;  // 1/s^2
};

}  // namespace fascicle::studio
