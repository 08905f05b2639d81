// Characters that fascicle-convert turns into glTF: .fbx and .dae.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/base/process.h"

namespace fascicle::gltf {

bool is_convertible_file(const std::filesystem::path& path);
bool can_convert();  // whether fascicle-convert is beside this program or on PATH

// A sentence on how to convert a character by hand, for formats that are not read or failed to convert.
std::string conversion_by_hand(const std::filesystem::path& path);

// Throws std::runtime_error: the machine is to blame, not the file.
[[noreturn]] void fail_to_convert(const std::filesystem::path& input, const std::string& what);

struct Converter {
  std::filesystem::path program = {};  // empty: fascicle-convert beside this program or on PATH
  // The largest characters tested take a quarter of a second and 200 MiB.
  base::ProcessLimits limits = {.seconds = 120.0, .bytes = std::uint64_t{4} << 30};
};

// Converts `input` to GLB. Throws SceneError, or as fail_to_convert; a malicious file cannot bring down this
// process.
void convert_character(const std::filesystem::path& input, const std::filesystem::path& output,
                       const Converter& converter = {});

}  // namespace fascicle::gltf
