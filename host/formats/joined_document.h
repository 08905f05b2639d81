// Several glTF documents as one, each below a node of its own.
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Adds what the part's scene shows below a new node `name`, with all that it needs; nodes and clips are
// called `name`/... from now on, if they are not yet. What names nodes by number outside the format's core
// (VRM's bones, variants of materials, constraints) is left out. Returns the new node's number; node n of the
// part has become that + 1 + n.
std::size_t add_document(gltf::GltfDocument& to, gltf::GltfDocument part, const std::string& name,
                         const Eigen::Vector3d& translation, const Eigen::Vector4d& rotation);

}  // namespace fascicle::formats
