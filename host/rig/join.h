// Several characters as one, as if somebody had exported them in one file.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/rig/character.h"

namespace fascicle::rig {

// Joints, objects and materials of the character are called `name`/..., so that each can be told from those
// of others.
void name_apart(Character& character, const std::string& name);

// One of several characters. It outlives the call.
struct Placed {
  std::string name;  // of the joint that stands above all of its joints
  const Character* character = nullptr;
  const Clip* clip = nullptr;               // that it plays; null: none
  double start = 0.0;                       // s: when its clip begins
  Vector3d at = Vector3d::Zero();           // m: where its origin stands in every pose
  Eigen::Vector4d turn{0, 0, 0, 1};         // x y z w: how it is turned there
  std::int32_t bearer = -1;                 // a joint of those before it, that it goes with; -1: none
  Vector3d bind_offset = Vector3d::Zero();  // m: how far its bind pose is moved
  std::uint32_t first_node = 0;             // added to SurfacePart::node and WeightChannel::node
  // From its own space to the world, as `at` and `turn` say, or to the bearer's space.
  Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
};

// Each character gives a joint of its name, its own joints below that, its vertices, triangles and parts, one
// after the other; all clips together are one. Throws base::SceneError where two have painted the same name
// with different counts of numbers.
Character joined(std::span<const Placed> characters);

// One more than the largest node that a character's parts and weights name.
std::uint32_t node_count(const Character& character);

}  // namespace fascicle::rig
