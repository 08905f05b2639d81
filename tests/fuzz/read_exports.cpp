#include <cstddef>
#include <functional>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/painted_gltf.h"
#include "host/formats/skinned_surface.h"
#include "host/formats/surface.h"
#include "host/formats/surface_objects.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_file.h"
#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr double fps = 60.0;
constexpr std::uint64_t frames = 2;

// A body whose vertices are those of its surface: all that the formats use.
model::Model body_of(const rig::Character& character) {
  model::Model body;
  for (const scene::Vector3d& vertex : character.surface.vertices)
    for (int axis = 0; axis < 3; ++axis) body.rest.push_back(static_cast<float>(vertex[axis]));
  body.vertex_count = static_cast<std::uint32_t>(character.surface.vertices.size());
  for (std::uint32_t vertex = 0; vertex < body.vertex_count; ++vertex) {
    body.surface_vertex.insert(body.surface_vertex.end(), 4, vertex);
    body.surface_weight.insert(body.surface_weight.end(), {1.0f, 0.0f, 0.0f, 0.0f});
  }
  for (const auto& t : character.surface.triangles)
    body.surface_triangle.insert(body.surface_triangle.end(), t.begin(), t.end());
  body.joint_count = static_cast<std::uint32_t>(character.skeleton.size());
  return body;
}

// The body, smaller in each frame.
model::Frame frame_of(const model::Model& body, std::uint64_t k) {
  model::Frame frame{.index = k, .origin = {}, .positions = body.rest, .velocities = {}, .surface = {}};
  for (float& x : frame.positions) x *= 1.0f - 0.25f * static_cast<float>(k);
  frame.velocities = frame.positions;
  frame.surface = formats::embed(body, frame.positions);
  return frame;
}

// One file, or one for each frame, in a format of the render mesh.
bool write_format(const formats::Format& format, formats::BakeInfo info, const model::Frame& initial) {
  return is_taken<base::SceneError, base::BakeError>([&] {
    info.initial = &initial;
    const std::unique_ptr<formats::FrameSink> sink = format.make();
    sink->begin(info);
    for (std::uint64_t k = 0; k <= info.frames; ++k) sink->write(frame_of(*info.model, k));
    sink->finish();
  });
}

// What is written is read again: numbers that are not finite are no JSON, or null.
bool write_glb(const formats::BakeInfo& info, const model::Frame& initial) {
  const fs::path file = info.folder / "surface.glb";
  fs::remove(file);
  if (!write_format(formats::format_named("glb"), info, initial)) return false;
  const nlohmann::json written = fascicle::gltf::check_gltf(fascicle::gltf::read_gltf_file(file)).plain;
  for (const nlohmann::json& accessor : written["accessors"])
    for (const char* bound : {"min", "max"})
      if (accessor.contains(bound))
        for (const nlohmann::json& number : accessor[bound])
          if (!number.is_number()) throw std::logic_error("surface.glb has a bound that is no number");
  return true;
}

// One way to use what `fascicle export` reads.
using Export = std::function<bool(formats::BakeInfo, const model::Frame&)>;

std::vector<Export> all_exports() {
  std::vector<Export> all{[](const formats::BakeInfo& info, const model::Frame&) {
    return is_taken<base::SceneError, base::BakeError>([&] {
      formats::write_textures(info.folder, *info.objects);
      const formats::SkinnedSurface skinned(info.character, *info.model, fps);
      for (std::uint64_t k = 0; k <= frames; ++k) (void)skinned.positions(k);
    });
  }};
  for (const formats::Format& format : formats::named_formats()) {
    // Tetrahedra have no looks.
    if (format.name == "vtu") continue;
    all.push_back([&format](const formats::BakeInfo& info, const model::Frame& initial) {
      return write_format(format, info, initial);
    });
  }
  for (const auto& glb : {formats::GlbOptions{.stride = 2, .error = {}, .tolerance = {}, .compress = {}},
                          formats::GlbOptions{.stride = 1, .error = 0.1, .tolerance = {}, .compress = 0.01}})
    all.push_back([glb](formats::BakeInfo info, const model::Frame& initial) {
      info.glb = glb;
      return write_glb(info, initial);
    });
  return all;
}

// `fascicle export` of a bake with this character.glb.
bool export_bake(const Export& write, const fs::path& kept, const fs::path& folder,
                 const model::Model& body) {
  formats::BakeInfo info{.model = &body,
                         .folder = folder,
                         .scene_name = "a",
                         .fps = fps,
                         .frames = frames,
                         .character = kept,
                         .usd_skel = true};
  const bool is_read = is_taken<base::SceneError, base::BakeError>([&] {
    info.objects = std::make_shared<const formats::SurfaceObjects>(formats::read_surface_objects(body, kept));
  });
  return is_read && write(info, frame_of(body, 0));
}

// Writes the character.glb that a bake of this file writes, and exports it. Of that, the file's bytes may be
// anywhere.
bool export_new_bake(const Export& write, const OneFile& file, const fs::path& folder,
                     const rig::Character& character, const model::Model& body) {
  const fs::path made = file.folder() / "made.glb";
  const bool is_made = is_taken<base::SceneError, base::BakeError>([&] {
    std::vector<std::string> missing;
    scene::Scene scene;
    scene.geometry = character;
    scene.scale = 0.5;
    scene.fps = fps;
    scene.end = static_cast<double>(frames) / fps;
    scene.input_hashes = {{file.path(), "0"}};
    const auto time = [](std::uint64_t k) { return static_cast<double>(k) / fps; };
    base::write_whole(made, formats::character_glb(scene, body, time, missing));
  });
  return is_made && export_bake(write, made, folder, body);
}

// The file with paint.
bool write_painted(const OneFile& file, rig::Character character) {
  return is_taken<base::SceneError, base::BakeError>([&] {
    rig::Paint paint;
    paint.surface = rig::surface_hash(character.surface);
    paint.vertices = character.surface.vertices.size();
    paint.attributes = {{"_RIGID", {0}, {1.0f}}, {"_FIBER", {1}, {0.6f, 0.8f, 0.0f}}};
    rig::lay_over(paint, character);
    std::vector<std::string> missing;
    const fs::path made = file.folder() / "made.glb";
    base::write_whole(made, formats::painted_glb(file.path(), character, paint, missing));
    (void)fascicle::gltf::read_gltf(made);
  });
}

}  // namespace

bool exports(std::string_view bytes) {
  static const OneFile file(formats::character_name);
  static const base::TemporaryFolder exported;
  static const std::vector<Export> all = all_exports();
  if (all.size() > most_exports) throw std::logic_error("no seed has the last export");
  if (bytes.empty()) return false;
  const auto way = static_cast<unsigned char>(bytes[0]);
  const Export& write = all[way / 3 % all.size()];
  file.write(bytes.substr(1));
  rig::Character character;
  if (!is_taken<base::SceneError>([&] { character = fascicle::gltf::read_gltf(file.path()); })) return false;
  const model::Model body = body_of(character);
  const fs::path& folder = exported.path();
  // As a stranger's bake, and as a character to bake.
  if (way % 3 == 0) return export_bake(write, file.path(), folder, body);
  if (way % 3 == 1) return export_new_bake(write, file, folder, character, body);
  return write_painted(file, std::move(character));
}

}  // namespace fascicle::fuzz
