// The outer layer of a glTF file: the container, the JSON text and the buffers. Sizes are checked before
// memory is allocated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace fascicle::gltf {

// Bytes, for each file and for all buffers together.
inline constexpr std::uint64_t gltf_largest_file = std::uint64_t{1} << 30;

struct GltfFile {
  std::filesystem::path path;
  nlohmann::json document;
  bool has_binary = false;            // a GLB with a BIN chunk
  std::vector<unsigned char> binary;  // the BIN chunk
  std::vector<std::string> notes;     // what the conversion lost
};

// Throws SceneError "FILE: POINTER: what", one line whatever the file contains; `pointer` is a JSON pointer,
// or a byte offset for the container.
[[noreturn]] void gltf_error(const std::filesystem::path& path, const std::string& pointer,
                             const std::string& what);

// Reads a .glb (detected by its magic number) or .gltf; other formats go through fascicle-convert. Limits the
// file size, the JSON's nesting and its number of values. `converter`: path of fascicle-convert; empty:
// beside this program or on PATH.
GltfFile read_gltf_file(const std::filesystem::path& path, const std::filesystem::path& converter = {});

// The canonical path of an external buffer or image. `uri` must lead to a file inside the folder of `gltf`:
// no scheme, no absolute path, no "..", no percent-encoded separators, no symbolic link out of the folder.
// Throws SceneError.
std::filesystem::path gltf_buffer_file(const std::filesystem::path& gltf, const std::string& pointer,
                                       const std::string& uri);

// Its contents; it must be a regular file. Appends its path to `files_read`.
std::vector<unsigned char> read_gltf_buffer(const std::filesystem::path& gltf, const std::string& pointer,
                                            const std::string& uri,
                                            std::vector<std::filesystem::path>& files_read);

}  // namespace fascicle::gltf
