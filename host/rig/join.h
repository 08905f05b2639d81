// Joins several characters into one, as if they had been exported in one file.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/rig/character.h"

namespace fascicle::rig {

// Prefixes the names of the character's joints, objects and materials with `name`/, so that they differ from
// those of other characters.
void name_apart(Character& character, const std::string& name);

// One of several characters. Refers to a character that must outlive the call.
struct Placed {
  std::string name;  // of the joint added above all of its joints
  const Character* character = nullptr;
  const Clip* clip = nullptr;               // the clip it plays; null: none
  double start = 0.0;                       // s; when its clip starts
  Vector3d at = Vector3d::Zero();           // m; the position of its origin in every pose
  Eigen::Vector4d turn{0, 0, 0, 1};         // x y z w; its rotation there
  std::int32_t bearer = -1;                 // index of an earlier joint that it follows; -1: none
  Vector3d bind_offset = Vector3d::Zero();  // m; how far its bind pose is moved
  std::uint32_t first_node = 0;             // added to SurfacePart::node and WeightChannel::node
  // Maps its own space to the world, according to `at` and `turn`, or to the bearer's space.
  Eigen::Matrix4d place = Eigen::Matrix4d::Identity();
};

// For each character in turn, appends a joint with its name, its joints below that, its vertices, triangles
// and parts. All clips become one. Painted attributes of the same name get the larger width; throws
// base::SceneError if theirs differ for one of the paint_kinds().
Character joined(std::span<const Placed> characters);

// One more than the largest node index in a character's parts and weights.
std::uint32_t node_count(const Character& character);

}  // namespace fascicle::rig
