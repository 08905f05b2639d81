// Appends data to a glTF document, and writes .glb.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// Appends a buffer view of new bytes; returns its index.
std::size_t add_view(gltf::GltfDocument& document, std::string_view bytes);

// Appends an accessor of new bytes; returns its index. `width`: values per element; 1 SCALAR, 3 VEC3, 4 VEC4,
// 16 MAT4. `with_bounds`: adds min and max.
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const float> values, std::size_t width,
                         bool with_bounds = false);
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint16_t> values,
                         std::size_t width);
// `count` zero vectors; takes no bytes.
std::size_t add_still_accessor(nlohmann::json& document, std::size_t count);
// Triangle indices; SCALAR.
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint32_t> indices);

// What precedes the binary chunk's bytes in a .glb: the header, the JSON chunk with `text`, and the binary
// chunk's header. `binary_bytes` is a multiple of 4. Throws BakeError if the file would exceed the format's 4
// GiB.
std::string glb_head(std::string text, std::uint64_t binary_bytes);

// Throws BakeError if a number in the JSON is not finite: a .glb cannot hold it.
void require_finite(const nlohmann::json& value);

// A complete .glb. Throws BakeError as the two above.
std::string glb_text(gltf::GltfDocument document);

}  // namespace fascicle::formats
