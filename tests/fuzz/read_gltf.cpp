#include <algorithm>

#include "host/base/errors.h"
#include "host/formats/character_file.h"
#include "host/formats/glb_compress.h"
#include "host/formats/glb_document.h"
#include "host/formats/joined_document.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/surface_objects.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

// What the files for other programs are made from: the document of several characters, and a compressed one.
bool write_documents(const std::filesystem::path& path, const fascicle::gltf::Rig& rig) {
  return is_taken<base::SceneError, base::BakeError>([&] {
    std::vector<std::string> missing;
    fascicle::gltf::GltfDocument document = fascicle::gltf::pack_gltf(path, missing);
    fascicle::gltf::GltfDocument both{.json = {{"scenes", {nlohmann::json::object()}}}, .binary = {}};
    for (const char* name : {"left", "right"})
      formats::add_document(both, document,
                            {.name = name, .transform = nlohmann::json::object(), .parent = std::nullopt});
    const std::vector<std::size_t> meshes = formats::own_meshes(document.json, rig);
    if (document.json["animations"].is_array()) formats::drop_weight_channels(document.json, meshes, 0);
    const std::vector<double> stretch(rig.parts.size(), 1.0);
    constexpr double bound = 0.01;  // m; coarse enough for 16 bits
    formats::GlbCompression compression(rig, document.json, stretch, bound);
    compression.quantise(document, meshes);
    compression.pack(document, 0);
  });
}

// What exports read again from a bake's own character.glb.
bool read_surface(const std::filesystem::path& path, const rig::Character& character) {
  return is_taken<base::SceneError, base::BakeError>([&] {
    fascicle::model::Model model;
    model.surface_vertex.resize(4 * character.surface.vertices.size());
    for (const auto& t : character.surface.triangles)
      model.surface_triangle.insert(model.surface_triangle.end(), t.begin(), t.end());
    (void)formats::read_surface_objects(model, path);
    const formats::ShapedSurface shaped(path, model, 60.0);
    std::vector<float> surface(3 * character.surface.vertices.size());
    if (!shaped.empty()) shaped.add_to(1, surface);
  });
}

}  // namespace

bool gltf(std::string_view bytes) {
  static const OneFile file("a.glb");
  file.write(bytes);
  // What each of them reads first. Most fuzzed files are refused here.
  nlohmann::json raw;
  if (!is_taken<base::SceneError>([&] { raw = fascicle::gltf::read_gltf_file(file.path()).document; }))
    return false;
  (void)formats::has_baked_clip(raw);
  rig::Character character;
  const bool is_character = is_taken<base::SceneError>([&] {
    character = fascicle::gltf::read_gltf(file.path(), nullptr, {}, fascicle::gltf::Still::carried);
  });
  // Also of a file that is no character: a page reads the rig of a bake's character.glb on its own.
  fascicle::gltf::Rig rig;
  const bool is_rig = is_taken<base::SceneError>([&] {
    rig = fascicle::gltf::read_rig(file.path(), {}, fascicle::gltf::Still::carried);
    fascicle::gltf::read_looks(file.path(), rig);
  });
  const bool is_document = write_documents(file.path(), is_rig ? rig : fascicle::gltf::Rig{});
  const bool is_surface = is_character && read_surface(file.path(), character);
  return is_character && is_rig && is_document && is_surface;
}

}  // namespace fascicle::fuzz
