// Checks shared by the tests of glTF files with false contents.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::tests {

// Expects a message of one line that begins with the file and names the place.
inline void expect_file_refused(const std::filesystem::path& path, const std::string& place) {
  try {
    gltf::read_gltf(path);
    ADD_FAILURE() << "was read";
  } catch (const base::SceneError& error) {
    const std::string what = error.what();
    EXPECT_EQ(what.rfind(path.string() + ": ", 0), 0u) << what;
    EXPECT_NE(what.find(": " + place + ": "), std::string::npos) << "wanted " << place << ", got " << what;
    EXPECT_LT(what.size(), 700u);
    EXPECT_EQ(what.find_first_of("\n\r\x1b"), std::string::npos) << what;
  }
}

// The first primitive of the first mesh.
inline nlohmann::json& primitive(GltfBuilder& b) {
  return b.document["meshes"][0]["primitives"][0];
}

}  // namespace fascicle::tests
