// Scenes.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/module.h"

namespace fascicle_python {
namespace {

using Path = std::filesystem::path;
using Number = std::optional<double>;
using Clip = std::optional<Name>;

// `set` and tables of the scene file as settings such as "layers.fat.alpha=0.2": see fascicle/_settings.py.
std::vector<std::string> settings_of(const py::object& set, const py::kwargs& tables) {
  std::vector<std::string> settings;
  for (const py::handle text : py::module_::import("fascicle._settings").attr("settings")(set, tables))
    settings.push_back(name_bytes(text));
  return settings;
}

std::optional<std::string> bytes_of(const Clip& clip) {
  return clip ? std::optional<std::string>(clip->bytes) : std::nullopt;
}

fascicle::scene load_scene(const Path& name, const py::object& set, const Clip& clip, Number fps,
                           Number start, Number end, Number softness, Number exaggerate,
                           const std::optional<Path>& converter, const py::kwargs& tables) {
  const fascicle::scene_options options{
      settings_of(set, tables), bytes_of(clip), fps, start, end, softness, exaggerate, path_text(converter)};
  return without_lock([&] { return fascicle::scene(name.string(), options); });
}

fascicle::scene parse_scene(const std::string& text, const Path& folder, const py::object& set,
                            const Clip& clip, Number fps, Number start, Number end, Number softness,
                            Number exaggerate, const std::optional<Path>& converter,
                            const py::kwargs& tables) {
  const fascicle::scene_options options{
      settings_of(set, tables), bytes_of(clip), fps, start, end, softness, exaggerate, path_text(converter)};
  return without_lock([&] { return fascicle::scene::parse(text, folder.string(), options); });
}

std::vector<Name> joint_names(const fascicle::scene& scene) {
  std::vector<Name> names;
  for (std::size_t k = 0; k < scene.joint_count(); ++k) names.push_back({scene.joint_name(k)});
  return names;
}

std::vector<std::int32_t> joint_parents(const fascicle::scene& scene) {
  std::vector<std::int32_t> parents;
  for (std::size_t k = 0; k < scene.joint_count(); ++k) parents.push_back(scene.joint_parent(k));
  return parents;
}

std::vector<Name> clip_names(const fascicle::scene& scene) {
  std::vector<Name> names;
  for (std::size_t k = 0; k < scene.clip_count(); ++k) names.push_back({scene.clip_name(k)});
  return names;
}

// A list that the library returns item by item until NULL.
template <class At>
std::vector<std::string> texts_until_null(At at) {
  std::vector<std::string> texts;
  for (const char* text = nullptr; (text = at(texts.size())) != nullptr;) texts.emplace_back(text);
  return texts;
}

constexpr const char* scene_text = R"(A scene, read and checked, with the meshes it names loaded.

Scene(name) reads a scene file (.toml), a mesh, a character (.glb .gltf .vrm, and .fbx .dae where
fascicle-convert is installed) or a built-in scene.

    set         overrides for keys of the scene file: a mapping {"layers.fat.alpha": 0.2}, whose values
                may be mappings too, or a list of strings such as "layers.fat.alpha=0.2"
    clip        the character's clip, by name, by the last part of its name or by number; None: the first
    fps         frames per second
    start, end  of the clip, s
    softness    factor by which all flesh is softer
    exaggerate  factor by which flesh trails further
    converter   the program fascicle-convert; None: found beside the library, in its prefix or on PATH
    **tables    tables of the scene file by name, as in `set`: layers={"fat": {"alpha": 0.2}}

None uses the scene's value. A scene is immutable, so threads may share it.
Raises BadInput if it cannot be used.)";

constexpr const char* parse_text = R"(The same from the text of a scene file. Its file names are relative
to `folder`; "" is the working directory.)";

}  // namespace

void add_scene(py::module_& module) {
  using namespace py::literals;
  const py::none none;
  py::class_<fascicle::scene> scene(module, "Scene", scene_text);
  scene.attr("__module__") = "fascicle";
  define_init(scene, &load_scene, "name"_a, py::kw_only(), "set"_a = none, "clip"_a = none, "fps"_a = none,
              "start"_a = none, "end"_a = none, "softness"_a = none, "exaggerate"_a = none,
              "converter"_a = none, "Reads a scene.");
  scene
      .def_static("parse", &parse_scene, "text"_a, "folder"_a = "", py::kw_only(), "set"_a = none,
                  "clip"_a = none, "fps"_a = none, "start"_a = none, "end"_a = none, "softness"_a = none,
                  "exaggerate"_a = none, "converter"_a = none, parse_text)
      .def_property_readonly(
          "name", [](const fascicle::scene& self) { return Name{self.name()}; },
          "The scene's name, as in the manifest.")
      .def_property_readonly("fps", &fascicle::scene::fps, "Frames per second.")
      .def_property_readonly("frame_count", &fascicle::scene::frame_count, "Frames after frame 0.")
      .def_property_readonly("joint_names", &joint_names,
                             "The character's joints, parents before their children; [] without a skeleton.")
      .def_property_readonly("joint_parents", &joint_parents,
                             "The parent of each joint as an index into joint_names; -1 for a root.")
      .def_property_readonly("clip_names", &clip_names, "The character's clips.")
      .def("__repr__",
           [](const fascicle::scene& self) { return text_object("<fascicle.Scene '" + self.name() + "'>"); });
  module.def(
      "formats", [] { return texts_until_null(fascicle_format_name); },
      "The formats that a bake writes beside its frame cache, manifest and metrics: \"glb\", ...");
  module.def(
      "builtin_scenes", [] { return texts_until_null(fascicle_builtin_scene_name); },
      "The names of the built-in scenes.");
}

}  // namespace fascicle_python
