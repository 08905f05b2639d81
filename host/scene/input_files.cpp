#include "host/scene/input_files.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <system_error>

#include "host/base/file.h"
#include "host/base/text.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/gltf/convert.h"
#include "host/gltf/gltf.h"
#include "host/made/made_character.h"
#include "host/mesh/mesh_file.h"

namespace fascicle::scene {
namespace {

[[noreturn]] void fail_as_changed(const std::filesystem::path& path) {
  throw InputFileError(path.string() + " changed while it was read; start again once it is saved");
}

// Refuses anything but a regular file, and never blocks on a pipe.
base::File open_file(const std::filesystem::path& path) {
  try {
    return base::File(path, base::FileMode::read);
  } catch (const base::InputError& error) {
    throw InputFileError(path.string() + " " + error.reason);
  } catch (const std::system_error& error) {
    const bool is_missing =
        error.code() == std::errc::no_such_file_or_directory || error.code() == std::errc::not_a_directory;
    throw InputFileError(path.string() +
                         (is_missing ? " does not exist" : " cannot be opened: " + error.code().message()));
  }
}

std::string hash_of_file(const std::filesystem::path& path) {
  const base::File file = open_file(path);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::array<char, 1 << 16> block{};
  std::uint64_t done = 0;
  for (const std::uint64_t size = file.size(); done < size;) {
    const auto part = std::span(block).first(std::min<std::size_t>(block.size(), size - done));
    if (!file.read_at(done, part)) fail_as_changed(path);
    XXH3_64bits_update(state.get(), part.data(), part.size());
    done += part.size();
  }
  return base::hash_text(XXH3_64bits_digest(state.get()));
}

void add_hash(const std::filesystem::path& path, Scene& scene) {
  scene.input_hashes.emplace_back(path.string(), hash_of_file(path));
}

// Reads files and adds their hashes. Fails if a file changes meanwhile: its hash might not match what was
// read.
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

// Takes the geometry and hashes from an earlier read, if there was one; returns whether there was.
bool take_from(const LoadedFiles* files, const std::filesystem::path& path, gltf::Still still, Scene& scene) {
  const Scene* before = files != nullptr ? files->find(path, still) : nullptr;
  if (before == nullptr) return false;
  scene.geometry = before->geometry;
  scene.input_hashes.insert(scene.input_hashes.end(), before->input_hashes.begin(),
                            before->input_hashes.end());
  return true;
}

}  // namespace

std::string hash_of(std::string_view bytes) {
  return base::hash_text(XXH3_64bits(bytes.data(), bytes.size()));
}

std::string hash_of(std::span<const std::string_view> texts) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  for (const std::string_view text : texts) XXH3_64bits_update(state.get(), text.data(), text.size());
  return base::hash_text(XXH3_64bits_digest(state.get()));
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
         (gltf::is_convertible_file(path) ? " needs fascicle-convert, which is not next to this program; "
                                          : " is not supported; ") +
         "characters are glTF (.glb .gltf .vrm). " + gltf::conversion_by_hand(path);
}

std::string read_text_file(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  try {
    return base::read_input(path, most_bytes);
  } catch (const base::InputError& error) {
    throw InputFileError(path.string() + " " + error.reason);
  }
}

void load_mesh(const std::filesystem::path& path, Scene& scene, LoadedFiles* files_before) {
  if (take_from(files_before, path, gltf::Still::left_out, scene)) return;
  if (reads_as_character(path))
    throw InputFileError(path.string() + " is a character; name it under [character]");
  std::vector<std::filesystem::path> files{path};
  if (const std::string extension = base::lower_extension(path);
      extension == ".node" || extension == ".ele") {
    // The reader opens both files, with extensions in the case of the given one.
    const bool upper = path.extension() == ".NODE" || path.extension() == ".ELE";
    files.clear();
    for (const char* each : {upper ? ".NODE" : ".node", upper ? ".ELE" : ".ele"})
      files.push_back(std::filesystem::path(path).replace_extension(each));
  }
  if (mesh::is_tet_mesh_file(path)) {
    read_unchanged(files, scene, [&] { scene.geometry = mesh::read_tet_mesh(path); });
  } else if (mesh::is_surface_mesh_file(path)) {
    read_unchanged(files, scene, [&] { scene.geometry = mesh::read_surface_mesh(path); });
  } else {
    throw InputFileError(
        path.string() + " is not a mesh file; mesh files are .mesh .node .ele .msh .vtu .off .obj .ply .stl");
  }
  if (files_before != nullptr) files_before->keep(path, gltf::Still::left_out, scene);
}

void load_character(const std::filesystem::path& path, Scene& scene, gltf::Still still,
                    LoadedFiles* files_before) {
  if (take_from(files_before, path, still, scene)) return;
  if (const std::string advice = conversion_advice(path, scene.converter); !advice.empty())
    throw InputFileError(advice);
  if (!reads_as_character(path, scene.converter))
    throw InputFileError(path.string() +
                         " is not a character; characters are .glb, .gltf, .vrm, .fbx or .dae");
  std::vector<std::filesystem::path> files{path};
  const auto start = std::filesystem::file_time_type::clock::now();
  read_unchanged({path}, scene,
                 [&] { scene.geometry = gltf::read_gltf(path, &files, scene.converter, still); });
  // Buffers and images that the file references. If one was saved after reading began, it is unclear which
  // version was read.
  for (std::size_t k = 1; k < files.size(); ++k) {
    if (std::filesystem::last_write_time(files[k]) >= start) fail_as_changed(files[k]);
    add_hash(files[k], scene);
  }
  if (files_before != nullptr) files_before->keep(path, still, scene);
}

namespace {

// The file itself, however it is spelled, so that it is kept once.
std::filesystem::path file_at(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path file = std::filesystem::weakly_canonical(path, error);
  return error ? path : file;
}

}  // namespace

const Scene* LoadedFiles::find(const std::filesystem::path& path, gltf::Still still) const {
  const auto found = read_.find({file_at(path), still});
  return found == read_.end() ? nullptr : found->second.get();
}

void LoadedFiles::keep(const std::filesystem::path& path, gltf::Still still, const Scene& loaded) {
  auto kept = std::make_unique<Scene>();
  kept->geometry = loaded.geometry;
  kept->input_hashes = loaded.input_hashes;
  read_[{file_at(path), still}] = std::move(kept);
}

const rig::Character& LoadedFiles::made(const std::string& name) {
  const auto found = made_.find(name);
  return found != made_.end() ? found->second : made_.emplace(name, made::make_character(name)).first->second;
}

const std::string& LoadedFiles::text_of(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  if (const auto given = given_.find(path); given != given_.end()) return given->second;
  const std::filesystem::path file = file_at(path);
  const auto read = texts_.find(file);
  return read != texts_.end() ? read->second
                              : texts_.emplace(file, read_text_file(path, most_bytes)).first->second;
}

void LoadedFiles::give(const std::filesystem::path& path, std::optional<std::string> text) {
  if (text)
    given_[path] = std::move(*text);
  else
    given_.erase(path);
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
