// Adding to a glTF document, and its binary form.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "host/gltf/gltf_rig.h"

namespace fascicle::formats {

// One view more over new bytes; its number.
std::size_t add_view(gltf::GltfDocument& document, std::string_view bytes);

// One accessor more over new bytes; its number. `width` values an element: 1 SCALAR, 3 VEC3, 4 VEC4, 16 MAT4.
// Floats with least and greatest values where asked for.
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const float> values, std::size_t width,
                         bool with_bounds = false);
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint16_t> values,
                         std::size_t width);
// Of as many moves by nothing; it takes no bytes.
std::size_t add_still_accessor(nlohmann::json& document, std::size_t count);
// Of triangles; SCALAR.
std::size_t add_accessor(gltf::GltfDocument& document, std::span<const std::uint32_t> indices);

// What stands before the binary chunk's bytes in a .glb: header, JSON chunk with `text`, the binary chunk's
// own head. `binary_bytes` is a multiple of 4. Throws BakeError if the file would pass the form's 4 GiB.
std::string glb_head(std::string text, std::uint64_t binary_bytes);

// A whole .glb.
std::string glb_text(gltf::GltfDocument document);

}  // namespace fascicle::formats
