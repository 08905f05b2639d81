// Building blocks of generated clips: curves over time, rotations, two-bone IK, and keys. Uses only + - * /
// sqrt and trigonometry.h, so that every machine produces the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/rig/character.h"

namespace fascicle::made {

using Eigen::Vector3d;

// A smooth curve through keys that never leaves the range of the two surrounding keys (monotone cubics, after
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

// Motion along a line with given position, velocity and acceleration at its keys; quintics between them.
struct MotionKey {
  double time, place, velocity, acceleration;
};
double motion_at(const std::vector<MotionKey>& keys, double time);

inline constexpr double degree = 0.017453292519943295;  // rad

Vector3d unit(const Vector3d& v);                                         // the same direction, length 1
Eigen::Matrix3d turn_about(const Vector3d& axis, double radians);         // axis of length 1
Eigen::Matrix3d shortest_turn(const Vector3d& from, const Vector3d& to);  // both of length 1, not opposite

// Rotations of the two bones of a limb, in the space its joints were bound in, that move its end from its
// bind position to a target. The middle joint stays in the plane of the limb and `side`, on that side.
struct Limb {
  Vector3d root, middle, end;  // in the bind pose
};
struct LimbTurns {
  Eigen::Matrix3d upper, lower;
  double bend = 0.0;    // angle between the two bones, radians; 0: straight
  bool reaches = true;  // false: straight, and still too short
};
LimbTurns reach(const Limb& limb, const Vector3d& bind_side, const Vector3d& root, const Vector3d& target,
                const Vector3d& side);

// Adds a joint whose axes are the world's in the bind pose; parent -1: none. Returns its index.
std::uint32_t add_joint(rig::Character& character, const std::string& name, std::int32_t parent,
                        const Vector3d& place);
Vector3d bind_place(const rig::Joint& joint);

// A pose of such a skeleton: the rotation of each joint from the bind pose in world axes, and the position of
// the root.
struct WorldPose {
  Vector3d root;
  std::vector<Eigen::Matrix3d> turns;
};
std::vector<Vector3d> places_of_joints(const rig::Character& character, const WorldPose& pose);

// Converts poses, one per key, to a clip: rotations of all joints, and the first joint's translation.
rig::Clip clip_of_poses(const rig::Character& character, const std::string& name,
                        const std::vector<double>& times, const std::vector<WorldPose>& poses);

}  // namespace fascicle::made
