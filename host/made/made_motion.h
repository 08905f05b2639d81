// Clips made in code: curves over time, turns, legs that reach for a place, and keys. Only + - * / sqrt and
// the trigonometry of trigonometry.h, so that every machine makes the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

using Eigen::Vector3d;

// A smooth curve through keys that never leaves the range of the two keys around it (monotone cubics, after
// Fritsch and Butland 1984); constant outside.
struct Key1 {
  double time, value;
};
class Curve {
 public:
  Curve(std::vector<Key1> keys);
  double at(double time) const;

 private:
  std::vector<Key1> keys_;
  std::vector<double> slopes_;
};

// Motion along a line with given place, velocity and acceleration at its keys; quintics between them.
struct MotionKey {
  double time, place, velocity, acceleration;
};
double motion_at(const std::vector<MotionKey>& keys, double time);

inline constexpr double degree = 0.017453292519943295;  // rad

Vector3d unit(const Vector3d& v);                                         // the same direction, length 1
Eigen::Matrix3d turn_about(const Vector3d& axis, double radians);         // axis of length 1
Eigen::Matrix3d shortest_turn(const Vector3d& from, const Vector3d& to);  // both of length 1, not opposite

// The turns of the two bones of a limb, in the space its joints were bound in, that bring its end from where
// it is in the bind pose to a place. The middle joint stays in the plane of the limb and `side`, on that
// side.
struct Limb {
  Vector3d root, middle, end;  // in the bind pose
};
struct LimbTurns {
  Eigen::Matrix3d upper, lower;
  double bend = 0.0;    // between the two bones, radians; 0: straight
  bool reaches = true;  // false: straight, and too short
};
LimbTurns reach(const Limb& limb, const Vector3d& bind_side, const Vector3d& root, const Vector3d& target,
                const Vector3d& side);

// A joint whose axes stand along the world's in the bind pose; -1: no parent. Returns its number.
std::uint32_t add_joint(rig::Character& character, const std::string& name, std::int32_t parent,
                        const Vector3d& place);
Vector3d bind_place(const rig::Joint& joint);

// A pose of such a skeleton: how far each joint is turned from the bind pose in the world's axes, and where
// the root stands.
struct WorldPose {
  Vector3d root;
  std::vector<Eigen::Matrix3d> turns;
};
std::vector<Vector3d> places_of_joints(const rig::Character& character, const WorldPose& pose);

// Turns poses, one a key, into a clip: rotations of all joints, and the first joint's translation.
rig::Clip clip_of_poses(const rig::Character& character, const std::string& name,
                        const std::vector<double>& times, const std::vector<WorldPose>& poses);

}  // namespace fascicle::made
