// How much is read of a glTF file: a small file may name one accessor very many times.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "host/gltf/gltf_parts.h"

namespace fascicle::gltf {

// Bytes of the buffers that the file holds, not decoded ones and each file beside it once.
std::size_t stored_bytes(const tinygltf::Model& model);

// The measure of a file's size on which limits depend: the bytes of all buffers, but at most four times those
// stored. Compressed meshes take a half to an eighth, and limits leave room for several times as much;
// hostile ones take a thousandth.
std::size_t measured_bytes(const tinygltf::Model& model);

// Adds up what a reader of the parts will hold, before anything is decoded.
class PartLimits {
 public:
  // Keeps references to both.
  PartLimits(const std::filesystem::path& path, const tinygltf::Model& model);
  // Throws SceneError if the parts so far have more in all than is read of a file of this size.
  void add(const GltfPart& part);

 private:
  void count(std::size_t& sum, std::size_t more, std::size_t most, const std::string& what,
             const std::string& pointer) const;

  const std::filesystem::path& path_;
  const tinygltf::Model& model_;
  std::size_t most_vertices_ = 0;
  std::size_t parts_ = 0, vertices_ = 0, corners_ = 0, targets_ = 0, influence_sets_ = 0, bind_matrices_ = 0;
};

// Adds up the numbers of a file's clips, before any is decoded: nearly every channel holds its own copy of
// its keys.
class KeyLimits {
 public:
  // Keeps references to both.
  KeyLimits(const std::filesystem::path& path, const tinygltf::Model& model);
  // One more copy of this accessor's numbers, for this animation. Throws SceneError if there are too many for
  // a file of this size.
  void add(std::size_t animation, int accessor);

 private:
  const std::filesystem::path& path_;
  const tinygltf::Model& model_;
  std::size_t numbers_ = 0, most_ = 0;
};

}  // namespace fascicle::gltf
