// Checks everything that tinygltf trusts blindly, before tinygltf sees the file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_file.h"

namespace fascicle::gltf {

// Names of buffers in CheckedGltf::document that the file does not hold: decoded from others, or read from a
// file that another buffer was read from. All others have no name.
inline constexpr const char* decoded_buffer = "decoded";
inline constexpr const char* repeated_buffer = "repeated";

struct CheckedGltf {
  std::filesystem::path path;
  // Only what a character needs: images, extensions and extras never reach the decoder. Indices match the
  // file's, except that animation channels are dropped if they move neither a node's transform nor its morph
  // targets.
  nlohmann::json document;
  // The file's whole document, with compressed geometry decoded; its buffers have the same indices as those
  // of `document`. All accessors of attributes and targets and all buffer views of images are there, and
  // lists consist of objects: what is not needed for a character and breaks this is left out.
  nlohmann::json plain;
  // Contents of the buffers that are not data: URIs, cut to byteLength. The key is the uri that `document`
  // now gives.
  std::map<std::string, std::vector<unsigned char>> buffers;
  std::vector<std::filesystem::path> files_read;
};

// Reads the buffers and checks types and indices, that every accessor fits its view and every view its
// buffer, that the nodes form a forest no deeper than 1024, and skins, samplers and channels. Throws
// SceneError with a JSON pointer.
CheckedGltf check_gltf(GltfFile file);

}  // namespace fascicle::gltf
