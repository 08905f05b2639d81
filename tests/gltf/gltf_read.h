// Characters read from documents that a test built.
#pragma once

#include <nlohmann/json.hpp>

#include "host/gltf/gltf.h"
#include "host/rig/character.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests::gltf_test {

// Coordinates and weights are floats near 1 in the files.
inline constexpr double float_rounding = 1e-6;

inline rig::Character read(const nlohmann::json& document) {
  const TemporaryFolder folder;
  return gltf::read_gltf(folder.write("character.gltf", document.dump()));
}

inline rig::Character read(const GltfBuilder& builder) {
  return read(builder.with_data_uri());
}

}  // namespace fascicle::tests::gltf_test
