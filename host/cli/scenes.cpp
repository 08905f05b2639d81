// fascicle scenes: lists the built-in scenes or prints them as files; prints the default scene of a mesh or a
// character with all keys.
#include <iostream>
#include <memory>
#include <set>

#include "host/build/bone_choice.h"
#include "host/build/join_bodies.h"
#include "host/cli/command.h"
#include "host/cli/part_names.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

using scene::Vector3d;

// Names from files may contain anything, including a line break, which would end the comment.
std::string in_comment(const std::string& text) {
  return shown_text(text);
}

std::string extent_text(const std::vector<Vector3d>& vertices, double scale) {
  if (vertices.empty()) return "nothing";
  Vector3d low = vertices.front(), high = vertices.front();
  for (const Vector3d& p : vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3d size = scale * (high - low);
  return number_text(size[0], 3) + " x " + number_text(size[1], 3) + " x " + number_text(size[2], 3) + " m";
}

std::string names_text(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + in_comment(name);
  return text;
}

std::string use_text(const build::JointReport& joint) {
  if (joint.is_bone) return joint.is_kinematic ? "bone that ends a chain; its flesh follows it" : "bone";
  return joint.is_kinematic ? "no bone; its flesh follows it" : "no bone; its flesh is soft";
}

// Prints measurements of a character, as comments.
void print_character(const scene::Scene& scene, const rig::Character& character) {
  const auto& [objects, materials] = names_of_parts(scene);
  std::cout << "# Extent: " << extent_text(character.surface.vertices, scene.scale) << " (x, y, z); "
            << count_text(character.surface.vertices.size()) << " vertices, "
            << count_text(character.surface.triangles.size()) << " triangles\n";
  if (!objects.empty()) std::cout << "# Objects: " << names_text(objects) << "\n";
  if (!materials.empty()) std::cout << "# Materials: " << names_text(materials) << "\n";
  for (const rig::PaintedAttribute& painted : character.painted)
    std::cout << "# Painted: " << in_comment(painted.name) << ", " << painted.width << " to a vertex\n";
  for (std::size_t k = 0; k < character.clips.size(); ++k) {
    const rig::Clip& clip = character.clips[k];
    std::cout << "# Clip: " << (clip.name.empty() ? "number " + std::to_string(k) : in_comment(clip.name))
              << ", " << number_text(clip.duration, 4) << " s\n";
  }
  std::vector<build::JointReport> joints;
  if (scene.characters.empty()) joints = build::bones_of(character, scene).report;
  for (std::size_t k = 0; k < scene.characters.size(); ++k) {
    const scene::Scene own = build::scene_of_character(scene, k);
    const build::BoneChoice choice =
        build::bones_of(scene.characters[k].own, own, scene.characters[k].settings.rigid);
    joints.insert(joints.end(), choice.report.begin(), choice.report.end());
  }
  for (const build::JointReport& joint : joints)
    if (joint.share > 0.0)
      std::cout << "# Joint: " << in_comment(joint.name) << ", with those below "
                << number_text(100.0 * joint.share, 3) << " % of the skin; " << use_text(joint) << "\n";
}

void print_documented(const scene::Scene& scene) {
  std::cout << "# " << in_comment(scene.name)
            << ": its scene with every key. Keys behind a # without a space are "
               "at their defaults:\n# take the # away to change them. Metres, kilograms, seconds, Y up.\n#\n";
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry))
    print_character(scene, *character);
  else if (const auto* surface = std::get_if<mesh::SurfaceMesh>(&scene.geometry))
    std::cout << "# Extent: " << extent_text(surface->vertices, scene.scale) << " (x, y, z)\n";
  else if (const auto* mesh = std::get_if<mesh::TetMesh>(&scene.geometry))
    std::cout << "# Extent: " << extent_text(mesh->vertices, scene.scale) << " (x, y, z)\n";
  std::cout << scene::documented_text(scene);
}

ExitCode scenes(const SceneArguments& arguments) {
  if (arguments.name.empty()) {
    std::vector<std::pair<std::string, std::string>> rows;
    for (const scene::BuiltinScene& scene : scene::builtin_scenes())
      rows.emplace_back(scene.name,
                        scene.description + (scene.name == scene::default_scene ? " (default)" : ""));
    std::cout << columns_text(rows);
    return ExitCode::done;
  }
  if (!scene::has_overrides(arguments.overrides))
    for (const scene::BuiltinScene& scene : scene::builtin_scenes())
      if (scene.name == arguments.name) {
        std::cout << scene.text;
        if (!scene.text.ends_with('\n')) std::cout << '\n';
        return ExitCode::done;
      }
  print_documented(load(arguments));
  return ExitCode::done;
}

}  // namespace

void add_scenes(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand(
      "scenes",
      "List the built-in scenes, or print the scene of a built-in name, mesh or character as a file to edit");
  const auto arguments = std::make_shared<SceneArguments>();
  add_scene_options(*subcommand, *arguments, "Built-in name, mesh, character or scene file", false);
  add_log_options(*subcommand, command.log);
  subcommand->callback(
      [arguments, &command] { command.run = [arguments](Log&) { return scenes(*arguments); }; });
}

}  // namespace fascicle::cli
