// Scenes and bakes of the C API.
#include <cmath>
#include <limits>
#include <variant>

#include "host/api/boundary.h"
#include "host/api/handles.h"
#include "host/scene/input_files.h"
#include "host/scene/scene_file.h"

namespace fascicle::api {
namespace {

scene::SceneOverrides overrides_of(const fascicle_scene_options& options) {
  scene::SceneOverrides overrides;
  overrides.set = texts_of(options.set, options.set_count, "options.set");
  for (const std::string& text : overrides.set)
    if (text.find('=') == std::string::npos || text.starts_with('='))
      throw BadArgument("options.set: \"" + text + "\" is not KEY=VALUE");
  if (options.clip != nullptr) overrides.clip = options.clip;
  const auto given = [](double value) {
    return std::isnan(value) ? std::nullopt : std::optional<double>(value);
  };
  overrides.fps = given(options.fps);
  overrides.start = given(options.start);
  overrides.end = given(options.end);
  overrides.softness = given(options.softness);
  overrides.exaggerate = given(options.exaggerate);
  overrides.converter = text_of(options.converter);
  return overrides;
}

const rig::Character* character_of(const fascicle_scene* scene) {
  return scene == nullptr ? nullptr : std::get_if<rig::Character>(&scene->scene.geometry);
}

}  // namespace
}  // namespace fascicle::api

using namespace fascicle;

void fascicle_scene_options_init(fascicle_scene_options* options, size_t struct_size) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  api::fill(options, struct_size,
            {.struct_size = 0,
             .set = nullptr,
             .set_count = 0,
             .clip = nullptr,
             .fps = none,
             .start = none,
             .end = none,
             .softness = none,
             .exaggerate = none,
             .converter = nullptr});
}

fascicle_status fascicle_scene_load(const char* name, const fascicle_scene_options* options,
                                    fascicle_scene** scene) {
  return api::guarded_make(scene, [&] {
    api::must_have(name, "name");
    const auto taken = api::taken(options, fascicle_scene_options_init, "options");
    return std::make_unique<fascicle_scene>(
        fascicle_scene{scene::load_scene(name, api::overrides_of(taken))});
  });
}

fascicle_status fascicle_scene_parse(const char* text, const char* folder,
                                     const fascicle_scene_options* options, fascicle_scene** scene) {
  return api::guarded_make(scene, [&] {
    api::must_have(text, "text");
    const auto taken = api::taken(options, fascicle_scene_options_init, "options");
    auto made = std::make_unique<fascicle_scene>(fascicle_scene{
        scene::parse_scene({"scene", "text", text, api::text_of(folder)}, api::overrides_of(taken))});
    // As for a scene file: the source comes first.
    auto& hashes = made->scene.input_hashes;
    hashes.insert(hashes.begin(), {"text", scene::hash_of(text)});
    return made;
  });
}

void fascicle_scene_destroy(fascicle_scene* scene) {
  delete scene;
}

const char* fascicle_scene_name(const fascicle_scene* scene) {
  return scene == nullptr ? nullptr : scene->scene.name.c_str();
}

double fascicle_scene_fps(const fascicle_scene* scene) {
  return scene == nullptr ? 0.0 : scene->scene.fps;
}

uint64_t fascicle_scene_frame_count(const fascicle_scene* scene) {
  return scene == nullptr ? 0 : scene::frame_count(scene->scene);
}

size_t fascicle_scene_joint_count(const fascicle_scene* scene) {
  const rig::Character* character = api::character_of(scene);
  return character == nullptr ? 0 : character->skeleton.size();
}

const char* fascicle_scene_joint_name(const fascicle_scene* scene, size_t joint) {
  if (joint >= fascicle_scene_joint_count(scene)) return nullptr;
  return api::character_of(scene)->skeleton[joint].name.c_str();
}

int32_t fascicle_scene_joint_parent(const fascicle_scene* scene, size_t joint) {
  if (joint >= fascicle_scene_joint_count(scene)) return -1;
  return api::character_of(scene)->skeleton[joint].parent;
}

size_t fascicle_scene_clip_count(const fascicle_scene* scene) {
  const rig::Character* character = api::character_of(scene);
  return character == nullptr ? 0 : character->clips.size();
}

const char* fascicle_scene_clip_name(const fascicle_scene* scene, size_t clip) {
  if (clip >= fascicle_scene_clip_count(scene)) return nullptr;
  return api::character_of(scene)->clips[clip].name.c_str();
}

const char* fascicle_builtin_scene_name(size_t index) {
  return api::text_or_null([&] {
    const auto& scenes = scene::builtin_scenes();
    return index < scenes.size() ? scenes[index].name.c_str() : nullptr;
  });
}
