// What the look of a bake is measured by and does not change from frame to frame: of the render mesh at rest
// its edges, how thick the body is below it, whose skin it is, and its rigid parts.
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
  std::vector<std::uint32_t> place;     // of a render vertex: those of equal place at rest share a number
  // Of a render vertex, working units: its skin's mean edge, and the body's thickness: how far it is through
  // the body to skin again, straight inward, at least two edges of the tetrahedra it rides on. Where no skin
  // follows (the mesh is open there), the median of all others.
  std::vector<double> edge, thickness;
  std::vector<std::uint32_t> joint;  // of a render vertex: the one with the largest skin weight
  std::vector<std::string> joint_names;
  // Parts that the rig moves rigidly: connected triangles of one object and material with nothing else
  // joined to them, all of whose weight is one joint's. Empty without a character's weights.
  struct RigidPart {
    std::uint32_t joint = 0;
    std::vector<std::uint32_t> triangles;
  };
  std::vector<RigidPart> rigid;
};

// `character`: whose render mesh the model carries; null where there is none.
LookBody look_body(const model::Model& model, const rig::Character* character);

}  // namespace fascicle::bake
