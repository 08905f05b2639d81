// The files a scene is made of: opened once each by their readers, and hashed for the manifest.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "host/gltf/gltf.h"
#include "host/scene/scene.h"

namespace fascicle::scene {

// A file that cannot be used at all; what() lacks the place in the scene file that named it.
struct InputFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// XXH3-64, 16 hex digits.
std::string hash_of(std::string_view bytes);

// By its name: glTF, and what is converted where there is a converter, here and below that one or, empty, one
// that is found.
bool reads_as_character(const std::filesystem::path& path, const std::filesystem::path& converter = {});
// What to do with a character in a format that is not read (.blend, ..., without a converter .fbx too); empty
// for all other files.
std::string conversion_advice(const std::filesystem::path& path, const std::filesystem::path& converter = {});

// base::read_input, which throws InputFileError here.
std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes);

// What meshes and characters were read as, for scenes that are read again and again with other keys. A file
// is read once: one that changes meanwhile stays as it was.
class LoadedFiles {
 public:
  // Null where it was not read yet.
  const Scene* find(const std::filesystem::path& path, gltf::Still still) const;
  // Of `loaded` the geometry and the input hashes.
  void keep(const std::filesystem::path& path, gltf::Still still, const Scene& loaded);

  // A character made in code, which is made once.
  const rig::Character& made(const std::string& name);

  // Of a file of text: what is given for it, else what was read first. Throws InputFileError.
  const std::string& text_of(const std::filesystem::path& path, std::uintmax_t most_bytes);
  // What stands for a file of text, whether it is there or not; nothing: the file itself.
  void give(const std::filesystem::path& path, std::optional<std::string> text);

 private:
  std::map<std::pair<std::filesystem::path, gltf::Still>, std::unique_ptr<const Scene>> read_;
  std::map<std::string, rig::Character> made_;
  std::map<std::filesystem::path, std::string> texts_, given_;
};

// Set scene.geometry (in the unit of the file) and add to scene.input_hashes; read by scene.converter. Throw
// InputFileError, or the reader's SceneError, which names the file itself. `files` may be null.
void load_mesh(const std::filesystem::path& path, Scene& scene, LoadedFiles* files = nullptr);
void load_character(const std::filesystem::path& path, Scene& scene,
                    gltf::Still still = gltf::Still::left_out, LoadedFiles* files = nullptr);

// The glTF file a scene's character was read from; empty if it was made otherwise.
std::filesystem::path character_file(const Scene& scene);

// Whether another program made glTF of something that was read: the input hashes do not say which.
bool is_converted(const Scene& scene);

}  // namespace fascicle::scene
