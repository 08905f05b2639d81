// A hand that pulls flesh: an external force on the vertices around one. The solver treats it like any force
// of a scene. Nothing else in the model changes, and flesh swings freely after its release.
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

// The free vertices around `vertex`, with each one's share of the pull: 1 in the middle, falling to 0 at
// `radius` (m, at rest). Found by walking along edges, so that a hand on a thigh does not grab a nearby arm.
// Ascending; empty if no vertex there is free.
using Held = std::vector<std::pair<std::uint32_t, float>>;
Held held_around(const model::Model& model, std::uint32_t vertex, double radius);

// The model with one additional force, the last, which accelerates each vertex by its share.
model::Model with_hand(const model::Model& model, const Held& held);

// The hand's force, frame by frame. It models the flesh it holds, and everything attached, as a mass on a
// spring. From the last frames it estimates m, how many times the held mass moves with it, and K, the
// spring's stiffness. With x the flesh's displacement, v its velocity and w the wanted displacement, the
// acceleration is
//   soft flesh    K (x + 0.3 (w - x)) + m (144/s^2 (w - x) - 24/s v),
//   stiff flesh   each frame, 0.3 of the way from the previous value to K w.
// Stiff flesh swings faster than the frames can resolve, so its swing is left to die out. In between, the two
// are blended.
class Hand {
 public:
  // `place`: where the hand takes hold, m. `frame`: the current frame.
  Hand(const model::Model& model, Held held, const model::Frame& frame, const Vector3d& place);

  const Held& held() const { return held_; }
  // Sets the target of the held flesh, m; replaces a force.
  void move(const Vector3d& place);
  // Sets a force in newtons; replaces a target.
  void push(const Vector3d& force);

  // Updates the estimates and the force after a frame. `seconds`: frame time.
  void see(const model::Frame& frame, double seconds);

  // The drive's forces, with the hand's appended for each substep. The hand's force is interpolated from the
  // last frame's to this frame's.
  std::vector<shader::Force> forces(const model::Drive& drive, std::uint32_t forces_of_scene) const;

 private:
  // Weighted mean over the held vertices, in metres, of values with three numbers per vertex.
  Vector3d mean(const std::vector<float>& values) const;
  Vector3d middle(const std::vector<float>& positions, const std::array<double, 3>& origin) const;
  void learn(const Vector3d& faster, const Vector3d& way, const Vector3d& pulled, double seconds);

  double unit_;
  Held held_;
  double share_ = 0.0;                    // sum of all shares
  double mass_ = 0.0;                     // kg, weighted by share
  double reach_ = 0.0;                    // m: the longest pull
  Vector3d grip_ = Vector3d::Zero();      // m: from the middle to where the hand took hold
  Vector3d lag_ = Vector3d::Zero();       // m: offset of the middle from skinning before the pull
  Vector3d still_ = Vector3d::Zero();     // m: without a skeleton, the middle before the pull
  std::optional<Vector3d> free_;          // m: the middle in the previous frame if nothing pulled
  Vector3d velocity_ = Vector3d::Zero();  // m/s: the middle's in the previous frame, relative to free_
  // Normal equations of m and K (times frame time squared), with exponentially decaying weights.
  double mass_mass_ = 0.0, mass_spring_ = 0.0, spring_spring_ = 0.0, mass_pull_ = 0.0, spring_pull_ = 0.0;
  std::optional<Vector3d> wanted_;  // m
  // m/s^2: at the end of this frame, and of the previous one.
  Vector3d acceleration_ = Vector3d::Zero(), before_ = Vector3d::Zero();
  double moved_ = 1.0;  // m
  double stiffness_;    // K, 1/s^2
};

}  // namespace fascicle::studio
