#include <cmath>

#include "host/base/nearest_name.h"
#include "host/gltf/gltf.h"
#include "host/mesh/mesh_file.h"
#include "host/scene/bare_scenes.h"
#include "host/scene/input_files.h"
#include "host/scene/overrides.h"
#include "host/scene/parse_toml.h"
#include "host/scene/scene_file.h"
#include "host/scene/scene_paint.h"
#include "host/scene/scene_table.h"

namespace fascicle::scene {
namespace {

Scene load_scene_file(const std::filesystem::path& path, const SceneOverrides& overrides) {
  const std::string text = read_text_file(path, most_toml_bytes);
  Scene scene = parse_scene({path.stem().string(), path.string(), text, path.parent_path()}, overrides);
  scene.input_hashes.insert(scene.input_hashes.begin(), {path.string(), hash_of(text)});
  return scene;
}

[[noreturn]] void fail_unknown_scene(const std::string& name) {
  if (name.empty()) throw SceneError("the scene's name is empty; leave it out, or give one");
  if (const std::string advice = conversion_advice(name); !advice.empty()) throw SceneError(advice);
  std::vector<std::string> names;
  for (const BuiltinScene& builtin : builtin_scenes()) names.push_back(builtin.name);
  throw SceneError(name +
                   ": no such scene; give a scene file (.toml), a mesh (.mesh .node .ele .msh .vtu .off .obj "
                   ".ply .stl), a "
                   "character (.glb .gltf .vrm .fbx .dae) or a built-in scene" +
                   base::nearest_name_hint(name, names));
}

}  // namespace

std::uint32_t stated_substeps(const Scene& scene) {
  if (scene.solver.auto_substeps)
    throw std::invalid_argument(scene.source + ": the substeps are open; they depend on the model");
  return scene.solver.substeps;
}

std::uint64_t cycle_frames(const Scene& scene) {
  return static_cast<std::uint64_t>(std::llround((scene.end - scene.start) * scene.fps));
}

std::uint64_t frame_count(const Scene& scene) {
  return scene.motion.loop * cycle_frames(scene) +
         static_cast<std::uint64_t>(std::llround(scene.motion.hold * scene.fps));
}

// --set's mesh.scale, or 1 if that is not a valid scale; reading the scene reports it then.
double scale_in(const SceneOverrides& overrides) {
  const auto text = overridden(overrides, "mesh.scale");
  if (!text) return 1.0;
  try {
    const auto scale = parse_toml("scale = " + *text, "mesh.scale")["scale"].value<double>();
    return scale && *scale > 0.0 && std::isfinite(*scale) ? *scale : 1.0;
  } catch (const SceneError&) {
    return 1.0;
  }
}

Scene load_scene(const std::string& name, const SceneOverrides& overrides) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    if (builtin.name != name) continue;
    const std::string source = "builtin:" + name;
    Scene scene = parse_scene({name, source, builtin.text, {}}, overrides);
    scene.input_hashes.emplace_back(source, hash_of(builtin.text));
    return scene;
  }
  const std::filesystem::path path(name);
  const std::string stem = path.stem().string();
  try {
    if (path.extension() == ".toml") return load_scene_file(path, overrides);
    if (mesh::is_tet_mesh_file(path) || mesh::is_surface_mesh_file(path)) {
      // The mesh is read twice, like a character: the default substeps depend on its size.
      const Geometry mesh = mesh::is_tet_mesh_file(path) ? Geometry(mesh::read_tet_mesh(path))
                                                         : Geometry(mesh::read_surface_mesh(path));
      return parse_scene({stem, name, scene_for_mesh(path, mesh, scale_in(overrides)), {}}, overrides);
    }
    if (reads_as_character(path, overrides.converter)) {
      // The character is read twice: the default layers depend on its size, and the text must be complete
      // before it is parsed.
      Scene sized;
      sized.converter = overrides.converter;
      load_character(path, sized);
      auto& character = std::get<rig::Character>(sized.geometry);
      try {
        const std::string paint = overridden(overrides, "character.paint").value_or("");
        if (!paint.empty()) lay_paint_over(paint, nullptr, sized, character);
      } catch (const InputFileError&) {
        // Found again, and reported with its location, when the scene is read.
      }
      return parse_scene({stem,
                          name,
                          scene_for_character(path, character,
                                              stiffness_for(overridden(overrides, "solver.integrator"),
                                                            overridden(overrides, "solver.weights"))),
                          {}},
                         overrides);
    }
  } catch (const InputFileError& error) {
    throw SceneError(error.what());
  }
  fail_unknown_scene(name);
}

}  // namespace fascicle::scene
