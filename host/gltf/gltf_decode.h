// Decodes what check_gltf passed, with tinygltf, and reads accessors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/gltf/gltf_check.h"

namespace tinygltf {
class Model;
}

namespace fascicle::gltf {

// The decoded document. tinygltf opens no file and sees no image; it gets the bytes that were read and
// checked.
std::shared_ptr<const tinygltf::Model> decode_gltf(const CheckedGltf& checked);

// All components of an accessor, in order; normalised integers become fractions, and sparse values are
// applied. Throws SceneError for non-finite values and for sparse indices out of order or out of range.
std::vector<double> accessor_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                     int accessor);

}  // namespace fascicle::gltf
