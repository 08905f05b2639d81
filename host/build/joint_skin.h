// What each joint of a skeleton does to the skin, and where the skin of two joints meets.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// A piece of skin; a patch of area a and outward normal n counts by the weight w of its joints there.
struct SkinPiece {
  double area = 0.0;                   // sum w a, m^2
  Vector3d normal = Vector3d::Zero();  // sum w a n
  Vector3d middle = Vector3d::Zero();  // weighted by w a
};

struct SkinOfJoints {
  std::vector<double> vertex_area;  // per vertex, m^2
  // Per vertex: joints, including all ancestors, and their weights with all descendants; ascending.
  std::vector<std::vector<std::pair<std::uint32_t, double>>> with_below;
  std::vector<SkinPiece> own;    // per joint: skin moved by the joint itself
  std::vector<SkinPiece> below;  // by the joint and all joints below it
  double whole = 0.0;            // area of the skin, m^2
};

SkinOfJoints skin_of_joints(const mesh::SurfaceMesh& surface, const rig::Character& character);

// A place where the skin of one joint merges into that of another joint that is neither its ancestor nor its
// descendant: a shank and a foot that is a separate IK target.
struct Meeting {
  std::uint32_t from = 0;              // joint whose own skin shares this area with
  std::uint32_t to = 0;                // that of this joint and all below it
  double area = 0.0;                   // m^2
  Vector3d middle = Vector3d::Zero();  // of the shared skin
};

// For each joint whose skin has less than a tenth as much in common with its ancestors as with some unrelated
// joint: that joint, and others with at least a fifth of its amount; largest first. A triangle counts the
// lesser of the two joints' weights, times its area.
std::vector<Meeting> meetings_of(const mesh::SurfaceMesh& surface, const rig::Character& character);

}  // namespace fascicle::build
