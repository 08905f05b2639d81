// The part of a look's measurement that does not change from frame to frame: for the render mesh at rest, its
// edges, the body's thickness below it, the joint of each vertex, and the rigid parts.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "host/bake/triangle_tree.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::bake {

struct LookBody {
  std::vector<float> rest;              // render vertices, working units
  std::vector<std::uint32_t> triangle;  // the model's
  std::vector<std::uint32_t> place;     // per render vertex: those at the same place at rest share a number
  // Per render vertex, working units: the skin's mean edge, and the body's thickness: the distance straight
  // inward to skin again, at least two edges of the tetrahedron it is embedded in. If there is no skin (the
  // mesh is open there), the median of all others.
  std::vector<double> edge, thickness;
  std::vector<std::uint32_t> joint;  // per render vertex: the one with the largest skin weight
  std::vector<std::string> joint_names;
  // Parts that the rig moves rigidly: connected triangles of one object and material, not joined to anything
  // else, whose whole weight belongs to one joint. Empty without a character's weights.
  struct RigidPart {
    std::uint32_t joint = 0;
    std::vector<std::uint32_t> triangles;
  };
  std::vector<RigidPart> rigid;
};

// `character`: the one whose render mesh the model carries, or null.
LookBody look_body(const model::Model& model, const rig::Character* character);

}  // namespace fascicle::bake
