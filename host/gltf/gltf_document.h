// Adds bytes to a document that is written out again.
#pragma once

#include <cstddef>

#include "host/gltf/gltf_rig.h"

namespace fascicle::gltf {

// Adds a buffer view of these bytes, aligned to 8; returns its index.
std::size_t add_view(GltfDocument& document, const unsigned char* bytes, std::size_t count);

}  // namespace fascicle::gltf
