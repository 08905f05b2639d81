#include "host/scene/input_files.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <system_error>

#include "host/base/file.h"
#include "host/base/text.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/gltf/convert.h"
#include "host/gltf/gltf.h"
#include "host/mesh/mesh_file.h"

namespace fascicle::scene {
namespace {

void check_regular(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputFileError(path.string() + " does not exist");
  if (!std::filesystem::is_regular_file(status)) throw InputFileError(path.string() + " is not a file");
}

std::ifstream open(const std::filesystem::path& path) {
  check_regular(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputFileError(path.string() + " cannot be opened; check its permissions");
  return in;
}

std::string hash_of_file(const std::filesystem::path& path) {
  std::ifstream in = open(path);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::array<char, 1 << 16> block{};
  while (in.read(block.data(), block.size()), in.gcount() > 0) {
    XXH3_64bits_update(state.get(), block.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) throw InputFileError(path.string() + " cannot be read to its end");
  return base::hash_text(XXH3_64bits_digest(state.get()));
}

void add_hash(const std::filesystem::path& path, Scene& scene) {
  scene.input_hashes.emplace_back(path.string(), hash_of_file(path));
}

[[noreturn]] void fail_as_changed(const std::filesystem::path& path) {
  throw InputFileError(path.string() + " changed while it was read; start again once it is saved");
}

// Reads files, and adds hashes that stand for what was read: of a file that is saved meanwhile they would
// not.
template <class Read>
void read_unchanged(const std::vector<std::filesystem::path>& files, Scene& scene, const Read& read) {
  std::vector<std::string> before;
  for (const auto& file : files) before.push_back(hash_of_file(file));
  read();
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (hash_of_file(files[k]) != before[k]) fail_as_changed(files[k]);
    scene.input_hashes.emplace_back(files[k].string(), before[k]);
  }
}

}  // namespace

std::string hash_of(std::string_view bytes) {
  return base::hash_text(XXH3_64bits(bytes.data(), bytes.size()));
}

bool reads_as_character(const std::filesystem::path& path, const std::filesystem::path& converter) {
  const std::string extension = base::lower_extension(path);
  return extension == ".glb" || extension == ".gltf" || extension == ".vrm" ||
         (gltf::is_convertible_file(path) && (!converter.empty() || gltf::can_convert()));
}

std::string conversion_advice(const std::filesystem::path& path, const std::filesystem::path& converter) {
  static constexpr std::array<const char*, 17> known{".fbx", ".dae",  ".blend", ".bvh",  ".x",      ".abc",
                                                     ".usd", ".usda", ".usdc",  ".usdz", ".ma",     ".mb",
                                                     ".max", ".c4d",  ".pmx",   ".b3d",  ".md5mesh"};
  const std::string extension = base::lower_extension(path);
  const bool is_known = std::find(known.begin(), known.end(), extension) != known.end();
  if (!is_known || reads_as_character(path, converter)) return {};
  return path.string() + ": " + extension +
         (gltf::is_convertible_file(path)
              ? " is not read without fascicle-convert, which is not beside this program; "
              : " is not read; ") +
         "characters are glTF (.glb .gltf .vrm). " + gltf::conversion_by_hand(path);
}

std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  std::ifstream in = open(path);
  std::error_code error;
  if (const std::uintmax_t bytes = std::filesystem::file_size(path, error); !error && bytes > most_bytes) {
    throw InputFileError(path.string() + " has " + std::to_string(bytes) + " bytes; " +
                         std::to_string(most_bytes) + " is the most a scene file can have");
  }
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) throw InputFileError(path.string() + " cannot be read to its end");
  return text;
}

void load_mesh(const std::filesystem::path& path, Scene& scene) {
  if (reads_as_character(path))
    throw InputFileError(path.string() + " is a character; name it under [character]");
  std::vector<std::filesystem::path> files{path};
  if (const std::string extension = base::lower_extension(path);
      extension == ".node" || extension == ".ele") {
    // The reader takes both, in the given extension's case.
    const bool upper = path.extension() == ".NODE" || path.extension() == ".ELE";
    files.clear();
    for (const char* each : {upper ? ".NODE" : ".node", upper ? ".ELE" : ".ele"})
      files.push_back(std::filesystem::path(path).replace_extension(each));
  }
  if (mesh::is_tet_mesh_file(path)) {
    check_regular(path);
    read_unchanged(files, scene, [&] { scene.geometry = mesh::read_tet_mesh(path); });
  } else if (mesh::is_surface_mesh_file(path)) {
    check_regular(path);
    read_unchanged(files, scene, [&] { scene.geometry = mesh::read_surface_mesh(path); });
  } else {
    throw InputFileError(
        path.string() + " is not a mesh file; mesh files are .mesh .node .ele .msh .vtu .off .obj .ply .stl");
  }
}

void load_character(const std::filesystem::path& path, Scene& scene, gltf::Still still) {
  if (const std::string advice = conversion_advice(path, scene.converter); !advice.empty())
    throw InputFileError(advice);
  if (!reads_as_character(path, scene.converter))
    throw InputFileError(path.string() +
                         " is not a character; characters are .glb, .gltf, .vrm, .fbx or .dae");
  check_regular(path);
  std::vector<std::filesystem::path> files{path};
  const auto start = std::filesystem::file_time_type::clock::now();
  read_unchanged({path}, scene,
                 [&] { scene.geometry = gltf::read_gltf(path, &files, scene.converter, still); });
  // Buffers and images, whose names stand in the file. Of one that was saved since the reading began nobody
  // knows which of both was read.
  for (std::size_t k = 1; k < files.size(); ++k) {
    if (std::filesystem::last_write_time(files[k]) >= start) fail_as_changed(files[k]);
    add_hash(files[k], scene);
  }
}

std::filesystem::path character_file(const Scene& scene) {
  if (std::holds_alternative<rig::Character>(scene.geometry) && scene.characters.empty())
    for (const auto& [file, hash] : scene.input_hashes)
      if (reads_as_character(file, scene.converter)) return file;
  return {};
}

bool is_converted(const Scene& scene) {
  return std::any_of(scene.input_hashes.begin(), scene.input_hashes.end(),
                     [](const auto& input) { return gltf::is_convertible_file(input.first); });
}

}  // namespace fascicle::scene
