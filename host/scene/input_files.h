// The files a scene is made of: opened once each by their readers, and hashed for the manifest.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

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

// Set scene.geometry (in the unit of the file) and add to scene.input_hashes; read by scene.converter. Throw
// InputFileError, or the reader's SceneError, which names the file itself.
void load_mesh(const std::filesystem::path& path, Scene& scene);
void load_character(const std::filesystem::path& path, Scene& scene,
                    gltf::Still still = gltf::Still::left_out);

// The glTF file a scene's character was read from; empty if it was made otherwise.
std::filesystem::path character_file(const Scene& scene);

// Whether another program made glTF of something that was read: the input hashes do not say which.
bool is_converted(const Scene& scene);

}  // namespace fascicle::scene
