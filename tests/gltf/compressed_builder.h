// The column of gltf_builder.h, compressed by the codecs' own encoders.
#pragma once

#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {

inline constexpr const char* meshopt = "EXT_meshopt_compression";
inline constexpr const char* draco_name = "KHR_draco_mesh_compression";

// Every view of the column compressed; the plain bytes stand nowhere.
nlohmann::json with_meshopt(const GltfBuilder& b, const char* extension = meshopt);

// Its geometry as Draco has it; `method` is a draco::MeshEncoderMethod.
GltfBuilder with_draco(int method);

}  // namespace fascicle::tests
