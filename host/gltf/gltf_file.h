// The outside of a glTF file: the container, the JSON text and the buffers, each bounded before memory is
// taken.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::gltf {

inline constexpr std::uint64_t gltf_largest_file = std::uint64_t{1}
                                                   << 30;  // bytes, of each file and of all buffers together

struct GltfFile {
  std::filesystem::path path;
  nlohmann::json document;
  bool has_binary = false;            // a GLB with a BIN chunk
  std::vector<unsigned char> binary;  // that chunk
  std::vector<std::string> notes;     // what a conversion lost
};

// Throws SceneError "FILE: POINTER: what"; `pointer` is a JSON pointer, or a byte for the container.
[[noreturn]] void gltf_error(const std::filesystem::path& path, const std::string& pointer,
                             const std::string& what);

// Reads a .glb (told by its first bytes) or .gltf, or what fascicle-convert makes of other formats. Bounded:
// file size, nesting and number of the JSON's values. `converter`: that program; empty: found beside this one
// or on PATH.
GltfFile read_gltf_file(const std::filesystem::path& path, const std::filesystem::path& converter = {});

// The bytes of an external buffer. `uri` must lead to a regular file inside the folder of `gltf`: no scheme,
// no absolute path, no "..", no percent-encoded separators, no symbolic link out of the folder. Appends its
// path to `files_read`.
std::vector<unsigned char> read_gltf_buffer(const std::filesystem::path& gltf, const std::string& pointer,
                                            const std::string& uri,
                                            std::vector<std::filesystem::path>& files_read);

}  // namespace fascicle::gltf
