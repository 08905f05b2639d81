// The input files of a scene. Each reader opens its file once, and hashes it for the manifest.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "host/gltf/gltf.h"
#include "host/scene/scene.h"

namespace fascicle::scene {

// A file that cannot be used at all. what() does not include the place in the scene file that named it.
struct InputFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// XXH3-64, 16 hex digits. That of several texts is the hash of all one after the other.
std::string hash_of(std::string_view bytes);
std::string hash_of(std::span<const std::string_view> texts);

// Decides by the file name: glTF, or a convertible format if a converter is available. An empty `converter`,
// here and below, means to look for one.
bool reads_as_character(const std::filesystem::path& path, const std::filesystem::path& converter = {});
// Advice for a character in a format that is not read (.blend and others; .fbx too without a converter).
// Empty for all other files.
std::string conversion_advice(const std::filesystem::path& path, const std::filesystem::path& converter = {});

// base::read_input, but throws InputFileError.
std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes);

// Cache of meshes and characters, for scenes that are parsed repeatedly with different keys. A file is read
// once; later changes to it have no effect.
class LoadedFiles {
 public:
  // Null if it has not been read yet.
  const Scene* find(const std::filesystem::path& path, gltf::Still still) const;
  // Keeps the geometry and the input hashes of `loaded`.
  void keep(const std::filesystem::path& path, gltf::Still still, const Scene& loaded);

  // A character made in code, generated on first use.
  const rig::Character& made(const std::string& name);

  // Contents of a text file: what give() set, or else what was read first. Throws InputFileError.
  const std::string& text_of(const std::filesystem::path& path, std::uintmax_t most_bytes);
  // Replaces a text file's contents, whether the file exists or not. nullopt: back to the file itself.
  void give(const std::filesystem::path& path, std::optional<std::string> text);

 private:
  std::map<std::pair<std::filesystem::path, gltf::Still>, std::unique_ptr<const Scene>> read_;
  std::map<std::string, rig::Character> made_;
  std::map<std::filesystem::path, std::string> texts_, given_;
};

// Set scene.geometry (in the file's unit) and append to scene.input_hashes, using scene.converter. Throw
// InputFileError, or the reader's SceneError, which names the file. `files` may be null.
void load_mesh(const std::filesystem::path& path, Scene& scene, LoadedFiles* files = nullptr);
void load_character(const std::filesystem::path& path, Scene& scene,
                    gltf::Still still = gltf::Still::left_out, LoadedFiles* files = nullptr);

// The glTF file that the scene's character was read from; empty if there is none.
std::filesystem::path character_file(const Scene& scene);

// Whether an input was converted to glTF by another program. The input hashes do not identify that program.
bool is_converted(const Scene& scene);

}  // namespace fascicle::scene
