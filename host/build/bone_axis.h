// The axis of a bone and the skin around it.
#pragma once

#include <cstddef>

#include "host/build/joint_skin.h"
#include "host/build/skin_inside.h"
#include "host/mesh/mesh.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Whether a segment runs inside the skin for at least half of its length.
bool runs_inside(const SkinInside& skin, const scene::Vector3d& from, const scene::Vector3d& to);

// The tip of a bone that ends a chain: from its start into its joint's skin, as far as most of that reaches.
// The joint, or one below it, must move skin. Lengths are metres. `begin` itself if the skin's middle is not
// farther from it than `shortest`.
scene::Vector3d tip_of_chain(const mesh::SurfaceMesh& surface, const SkinOfJoints& skin, std::size_t joint,
                             const scene::Vector3d& begin, double shortest);

// Whether a joint's skin lies around a segment: the skin's middle is much nearer to it than the skin itself.
bool lies_around(const mesh::SurfaceMesh& surface, const SkinOfJoints& skin, std::size_t joint,
                 const scene::Vector3d& from, const scene::Vector3d& to);

}  // namespace fascicle::build
