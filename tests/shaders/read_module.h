// Reads a compiled shader from the build folder.
#pragma once

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "shaders/spirv_exact/module.h"

namespace fascicle::tests {

inline spirv_exact::Words read_module(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  EXPECT_TRUE(file.good()) << path;
  if (!file) return {};
  spirv_exact::Words words(static_cast<std::size_t>(file.tellg()) / sizeof(std::uint32_t));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(words.data()),
            static_cast<std::streamsize>(words.size() * sizeof(std::uint32_t)));
  return words;
}

// One of our shaders as glslangValidator writes it, before spirv_exact.
inline spirv_exact::Words read_raw_module(const std::string& name) {
  return read_module(std::string(FASCICLE_BINARY_DIR) + "/shaders/" + name + ".raw.spv");
}

}  // namespace fascicle::tests
