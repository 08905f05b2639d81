// tinygltf, fed with nothing but what check_gltf let through, and the numbers in its accessors.
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

// The decoded document. tinygltf opens no file and sees no image: it is handed the bytes that were read and
// checked.
std::shared_ptr<const tinygltf::Model> decode_gltf(const CheckedGltf& checked);

// All components of an accessor in order; normalised integers as fractions, sparse replacements done. Throws
// SceneError for what is not finite and for sparse indices out of order or range.
std::vector<double> accessor_numbers(const std::filesystem::path& path, const tinygltf::Model& model,
                                     int accessor);

}  // namespace fascicle::gltf
