// Skin weights that every viewer reads alike.
#pragma once

#include <filesystem>

#include "host/gltf/gltf_rig.h"

namespace tinygltf {
class Model;
}

namespace fascicle::gltf {

// How far a vertex's weights may be from a sum of 1: more than the rounding errors of 16-bit and float
// weights.
inline constexpr double weight_sum_tolerance = 1e-3;

// Changes the weights in `document`, a copy of the file, as read_gltf does in memory: they get a sum of 1,
// and vertices without weights get those of the nearest connected vertices. Viewers apply weights as they
// stand: a sum of 0 would draw a vertex at the origin, or nowhere. Primitives whose weights need no change
// stay as they are. Throws SceneError.
void repair_weights(const std::filesystem::path& path, const tinygltf::Model& model, GltfDocument& document);

}  // namespace fascicle::gltf
