// The column of gltf_builder.h, compressed by the codecs' own encoders.
#pragma once

#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {

inline constexpr const char* meshopt = "EXT_meshopt_compression";
inline constexpr const char* draco_name = "KHR_draco_mesh_compression";

// The column with all views compressed, without the uncompressed bytes.
nlohmann::json with_meshopt(const GltfBuilder& b, const char* extension = meshopt);

// The column's geometry as Draco; `method` is a draco::MeshEncoderMethod.
GltfBuilder with_draco(int method);

}  // namespace fascicle::tests
