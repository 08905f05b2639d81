// What each joint of a skeleton does to the skin, and where the skin of two joints meets.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "host/build/body.h"

namespace fascicle::build {

// A piece of skin; a bit of area a and outward normal n counts by the weight w that its joints have in it.
struct SkinPiece {
  double area = 0.0;                   // sum w a, m^2
  Vector3d normal = Vector3d::Zero();  // sum w a n
  Vector3d middle = Vector3d::Zero();  // weighted by w a
};

struct SkinOfJoints {
  std::vector<double> vertex_area;  // of each vertex, m^2
  // Of each vertex: joints, with all above them, and their weights with all below; ascending.
  std::vector<std::vector<std::pair<std::uint32_t, double>>> with_below;
  std::vector<SkinPiece> own;    // a joint: moved by itself
  std::vector<SkinPiece> below;  // by itself and all joints below
  double whole = 0.0;            // area of the skin
};

SkinOfJoints skin_of_joints(const mesh::SurfaceMesh& surface, const rig::Character& character);

// Where the skin that moves with one joint goes over into that of another, which is neither above nor below
// it in the skeleton: a shank and a foot that is an IK target of its own.
struct Meeting {
  std::uint32_t from = 0;              // the joint whose own skin has this in common with
  std::uint32_t to = 0;                // that of this joint and all below it
  double area = 0.0;                   // m^2
  Vector3d middle = Vector3d::Zero();  // of the skin in common
};

// For each joint whose skin has less than a tenth as much in common with the joints above it as with another
// joint, that one, and others with a fifth of that or more; most first. A triangle has the lesser of the two
// joints' shares in common, times its area.
std::vector<Meeting> meetings_of(const mesh::SurfaceMesh& surface, const rig::Character& character);

}  // namespace fascicle::build
