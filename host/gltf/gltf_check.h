// Everything tinygltf believes without looking, checked before it sees the file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/gltf/gltf_file.h"

namespace fascicle::gltf {

struct CheckedGltf {
  std::filesystem::path path;
  // What a character needs of the document and nothing else: images, extensions and extras never reach the
  // decoder. Numbering is that of the file, except that animation channels that move neither a node's
  // transform nor its morph targets are left out.
  nlohmann::json document;
  // The whole document as the file has it, but with compressed geometry made plain; its buffers are numbered
  // as those of `document`.
  nlohmann::json plain;
  // Bytes of the buffers that are not data: URIs, by the name the document now gives as their uri; cut to
  // byteLength.
  std::map<std::string, std::vector<unsigned char>> buffers;
  std::vector<std::filesystem::path> files_read;
};

// Checks types, indices, that every accessor lies in its view and every view in its buffer, that the nodes
// are a forest no deeper than 1024, skins, samplers and channels; reads the buffers. Throws SceneError with a
// JSON pointer.
CheckedGltf check_gltf(GltfFile file);

}  // namespace fascicle::gltf
