// Characters that fascicle-convert turns into glTF: .fbx and .dae.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/base/process.h"

namespace fascicle::gltf {

bool is_convertible_file(const std::filesystem::path& path);
bool can_convert();  // whether there is a fascicle-convert, beside this program or on PATH

// How else a character in a format that is not read, or could not be, becomes glTF: a sentence.
std::string conversion_by_hand(const std::filesystem::path& path);

// Throws SceneError: the machine, not the file, stands in the way.
[[noreturn]] void fail_to_convert(const std::filesystem::path& input, const std::string& what);

struct Converter {
  std::filesystem::path program = {};  // empty: fascicle-convert beside this program or on PATH
  // The largest characters at hand take a quarter of a second and 200 MiB.
  base::ProcessLimits limits = {.seconds = 120.0, .bytes = std::uint64_t{4} << 30};
};

// Writes `input` as a GLB. Throws SceneError; nothing that the file holds ends this process.
void convert_character(const std::filesystem::path& input, const std::filesystem::path& output,
                       const Converter& converter = {});

}  // namespace fascicle::gltf
