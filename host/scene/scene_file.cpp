#include "host/scene/scene_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "host/made/made_bunny.h"
#include "host/scene/bare_scenes.h"
#include "host/scene/input_files.h"
#include "host/scene/material.h"
#include "host/scene/overrides.h"
#include "host/scene/parse_toml.h"
#include "host/scene/scene_characters.h"
#include "host/scene/scene_check.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_text.h"
#include "host/scene/scene_values.h"
#include "host/scene/scene_writer.h"

namespace fascicle::scene {
namespace {

constexpr std::array<const char*, 4> implicit_keys{"youngs_modulus", "frequency", "material",
                                                   "damping_ratio"};
// With this, soft tissue survives the jump of a heavy man (docs/design/crushed-flesh.md).
constexpr double least_volume_of_character = 0.3;
constexpr std::array<const char*, 2> explicit_keys{"alpha", "alpha_outer"};

// For error messages about a key that only one integrator has.
std::string takes(Integrator integrator) {
  return std::string("takes solver.integrator = \"") + name_of(integrator) + '"';
}

// The stated integrator, or else the one that the layers' keys imply.
Integrator integrator_of(const toml::table& root) {
  if (const auto stated = root["solver"]["integrator"].value<std::string>())
    return base::named<Integrator>(*stated).value();
  bool has_implicit = false, has_explicit = false;
  for_each_named(root, "layers", [&](const std::string&, const toml::table& layer, const std::string&) {
    const auto states = [&](const char* key) { return layer.contains(key); };
    has_implicit = has_implicit || std::any_of(implicit_keys.begin(), implicit_keys.end(), states);
    has_explicit = has_explicit || std::any_of(explicit_keys.begin(), explicit_keys.end(), states);
  });
  return has_implicit && !has_explicit ? Integrator::implicit_step : SolverSettings{}.integrator;
}

// Checks that a layer's stiffness keys fit the integrator (alpha for the explicit one, the others for the
// implicit one), and applies the material. check_scene has already rejected combinations.
void fix_stiffness(const toml::table& table, const std::string& path, bool implicit, Layer& layer) {
  const auto refuse = [&](const char* key, const std::string& what) {
    if (const toml::node* node = table.get(key)) fail(node->source(), join_path(path, key), what);
  };
  for (const char* key : implicit_keys)
    if (!implicit)
      refuse(key, takes(Integrator::implicit_step) + "; set that, or use " +
                      std::string(key == std::string_view("damping_ratio") ? "damping" : "alpha") +
                      " instead");
  for (const char* key : explicit_keys)
    if (implicit)
      refuse(
          key,
          takes(Integrator::explicit_step) +
              "; use youngs_modulus, frequency or material instead, or flesh.softness to change all layers");
  if (const Material* material = find_material(layer.material)) {
    layer.youngs_modulus = material->youngs_modulus;
    if (!table.contains("density")) layer.density = material->density;
  }
  if (layer.kinematic)
    for (const char* key : {"frequency", "damping_ratio"})
      refuse(key, "is for a layer that swings, and a kinematic layer does not; leave it out");
  if (implicit && !layer.kinematic && !layer.youngs_modulus && !layer.frequency)
    fail(table.source(), path,
         "has no stiffness; the implicit integrator takes one of youngs_modulus, frequency, material");
}

void check_sliding(const toml::table& table, const std::string& path, const Layer& layer) {
  if (layer.sliding && layer.kinematic)
    fail(table.get("sliding")->source(), join_path(path, "sliding"),
         "is for flesh that moves by itself, and a kinematic layer does not; leave one of them out");
}

void fix_least_volume(const toml::table& table, const std::string& path, const Surroundings& surroundings,
                      bool implicit, Layer& layer) {
  const bool is_stated = table.contains("least_volume");
  if (!is_stated && implicit && surroundings.has_joints && !layer.kinematic)
    layer.least_volume = least_volume_of_character;
  if (!implicit && layer.least_volume > 0.0)
    fail(table.get("least_volume")->source(), join_path(path, "least_volume"),
         takes(Integrator::implicit_step) +
             "; leave it out, or give the stiffness as youngs_modulus, frequency or material");
}

void read_layers(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  const bool implicit = scene.solver.integrator == Integrator::implicit_step;
  std::string rest_of_body;
  for_each_named(root, "layers",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   Layer layer;
                   layer.name = name;
                   read_keys(table, layer);
                   if (!layer.alpha_attribute.empty() && !surroundings.has_joints)
                     fail(table.get("alpha_attribute")->source(), join_path(path, "alpha_attribute"),
                          "only a [character] has painted values; leave it out");
                   check_sliding(table, path, layer);
                   fix_stiffness(table, path, implicit, layer);
                   fix_least_volume(table, path, surroundings, implicit, layer);
                   if (const toml::node* node = table.get("fibre")) {
                     const Vector3d fibre = vector_of(*node);
                     // Scaled first, because squares of very small doubles underflow to 0.
                     const double largest = fibre.cwiseAbs().maxCoeff();
                     if (largest == 0.0)
                       fail(node->source(), join_path(path, "fibre"),
                            "has no length; give a direction, or leave it out");
                     layer.fibre = (fibre / largest).normalized();
                     if (layer.fibre_field)
                       fail(node->source(), join_path(path, "fibre"),
                            "conflicts with fibre_field = true; give one of them");
                   }
                   layer.where = read_where(table, surroundings, path);
                   if (layer.where.empty()) {
                     if (!rest_of_body.empty()) {
                       fail(table.source(), join_path(path, "where"),
                            "is missing, and layers." + rest_of_body +
                                " has none either; only one layer can be the rest of the body");
                     }
                     rest_of_body = name;
                   }
                   scene.layers.push_back(std::move(layer));
                 });
}

void read_contact(const toml::table& table, const Surroundings& surroundings, ContactSettings& contact) {
  read_keys(table, contact);
  if (!contact.attribute.empty() && !surroundings.has_joints)
    fail(table.get("attribute")->source(), join_path("contact", "attribute"),
         "only a [character] has painted values; leave it out");
}

// Must follow the layers, whose values it changes.
void read_flesh(const toml::table& root, Scene& scene) {
  const toml::table& table = table_at(root, "flesh");
  FleshSettings& flesh = scene.flesh;
  read_keys(table, flesh);
  const auto refuse = [&](const char* key, const std::string& what) {
    fail(table.get(key)->source(), join_path("flesh", key), what);
  };
  for (Layer& layer : scene.layers) {
    if (layer.kinematic) continue;
    if (layer.youngs_modulus) *layer.youngs_modulus /= flesh.softness;
    if (layer.frequency) *layer.frequency /= std::sqrt(flesh.softness);
    if (scene.solver.integrator == Integrator::explicit_step && flesh.softness != 1.0) {
      const double stiffest = std::max(layer.alpha, layer.alpha_outer.value_or(0.0)) / flesh.softness;
      if (stiffest > 1.0)
        refuse("softness", "makes alpha of layers." + layer.name + " " + shortest(stiffest) +
                               ", and 1 is the most; set more substeps instead, or integrator = \"" +
                               name_of(Integrator::implicit_step) + '"');
      layer.alpha /= flesh.softness;
      if (layer.alpha_outer) *layer.alpha_outer /= flesh.softness;
    }
    layer.inertia_scale *= flesh.exaggerate;
    if (layer.inertia_scale > most_inertia)
      refuse("exaggerate", "makes inertia_scale of layers." + layer.name + " " +
                               shortest(layer.inertia_scale) + ", and " + shortest(most_inertia) +
                               " is the most; lower one of them");
  }
}

void read_forces(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  for_each_named(
      root, "force", [&](const std::string& name, const toml::table& table, const std::string& path) {
        Force force;
        force.name = name;
        read_keys(table, force);
        force.where = read_where(table, surroundings, path);
        if (force.kind == ForceKind::wind && !force.where.empty()) {
          fail(table.get("where")->source(), join_path(path, "where"),
               "wind blows on the whole surface; leave where out");
        }
        if (force.kind == ForceKind::point && force.where.empty()) {
          fail(table.source(), join_path(path, "where"),
               "is missing; choose the vertices that the force acts on");
        }
        if (!(force.end > force.start))
          fail(table.source(), join_path(path, "end"), "is not after start; the force would never act");
        scene.forces.push_back(std::move(force));
      });
}

void read_bones(const toml::table& root, Scene& scene) {
  for_each_named(root, "bones",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   BoneSegment bone{name, Vector3d::Zero(), Vector3d::Zero()};
                   read_keys(table, bone);
                   if (bone.from == bone.to)
                     fail(table.source(), path, "from and to are the same point; a bone needs a length");
                   scene.bones.push_back(std::move(bone));
                 });
}

void read_skeleton_settings(const toml::table& root, Scene& scene) {
  const toml::node* node = root.get("skeleton");
  if (node == nullptr) return;
  const toml::table& table = *node->as_table();
  if (!root.contains("character"))
    fail(table.source(), "skeleton", "only a [character] has a skeleton; leave it out");
  read_keys(table, scene.skeleton);
}

void read_fibres(const toml::table& root, Scene& scene) {
  for_each_named(root, "fibres",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   FibreCurve curve;
                   curve.name = name;
                   read_keys(table, curve);
                   for (std::size_t k = 1; k < curve.points.size(); ++k)
                     if (curve.points[k] == curve.points[k - 1])
                       fail((*table.get("points")->as_array())[k].source(), join_path(path, "points"),
                            "has the same point twice in a row; leave one out");
                   scene.fibres.push_back(std::move(curve));
                 });
}

// "20000" is a number of vertices, "20 mm" an edge length. Overrides the resolution of the mesh or character.
void read_resolution(const toml::table& table, Scene& scene) {
  const toml::node* node = table.get("resolution");
  if (node == nullptr) return;
  std::string text;
  read(table, "resolution", text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
  const bool is_number = error == std::errc{} && std::isfinite(value);
  constexpr double fewest = 10.0, most = 1e7, longest = 1e4;
  const double metres = unit == "m"    ? value
                        : unit == "cm" ? value / 100.0
                        : unit == "mm" ? value / 1000.0
                                       : 0.0;
  if (is_number && unit.empty() && value >= fewest && value <= most && std::floor(value) == value) {
    scene.body.vertices = static_cast<std::uint32_t>(value);
  } else if (is_number && metres > 0.0 && metres <= longest) {
    scene.resolution = metres;
  } else {
    fail(node->source(), "body.resolution",
         "\"" + text +
             "\" is neither a number of vertices from 10 to 10 million, as \"20000\", nor a length "
             "with its unit, as \"20 mm\", \"2 cm\" or \"0.02 m\"");
  }
}

void read_body(const toml::table& root, Scene& scene) {
  const toml::table& table = table_at(root, "body");
  read_keys(table, scene.body);
  read_resolution(table, scene);
  const auto given = root.find("body");
  if (given == root.end()) return;
  // If an option created the table, only its key has a source location.
  if (std::holds_alternative<Bar>(scene.geometry))
    fail(given->first.source(), "body", "a bar's tetrahedra are set by bar.vertices; leave this table out");
  if (std::holds_alternative<mesh::TetMesh>(scene.geometry))
    fail(given->first.source(), "body",
         "the mesh file already contains tetrahedra, which are used unchanged; leave this table out");
}

void read_bar(const toml::table& table, Scene& scene) {
  Bar bar;
  read_keys(table, bar);
  constexpr double most_vertices = 1e8;
  if (double{1} * bar.vertices[0] * bar.vertices[1] * bar.vertices[2] > most_vertices)
    fail(table.get("vertices")->source(), "bar.vertices",
         "asks for more than 100 million vertices; make it coarser");
  scene.geometry = bar;
}

void read_mesh(const toml::table& table, const std::filesystem::path& folder, LoadedFiles* files,
               Scene& scene) {
  read_mesh_keys(table, scene);
  if (table.contains("made")) {
    std::string name;
    read(table, "made", name);
    scene.geometry = made::make_surface(name);
    return;
  }
  std::string file;
  read(table, "file", file);
  try {
    load_mesh(folder / file, scene, files);
  } catch (const InputFileError& error) {
    fail(table.get("file")->source(), "mesh.file", error.what());
  }
}

void read_steps(const toml::table& table, bool has_joints, SolverSettings& solver) {
  const bool implicit = solver.integrator == Integrator::implicit_step;
  const toml::node* substeps = table.get("substeps");
  solver.auto_substeps = substeps != nullptr && substeps->is_string();
  if (!solver.auto_substeps) read(table, "substeps", solver.substeps);
  for (const char* key : {"quality", "iterations", "viscosity"})
    if (table.contains(key) && !implicit)
      fail(table.get(key)->source(), std::string("solver.") + key,
           takes(Integrator::implicit_step) + "; leave it out");
  if (const toml::node* iterations = table.get("iterations"); iterations && !iterations->is_string())
    read(table, "iterations", solver.iterations);
  solver.has_stated_viscosity = table.contains("viscosity");
  if (implicit && has_joints && !solver.has_stated_viscosity) solver.viscosity = viscosity_of_character;
  if (table.contains("quality") && !solver.auto_substeps)
    fail(table.get("quality")->source(), "solver.quality",
         "applies only with solver.substeps = \"auto\"; set that, or leave it out");
  if (solver.auto_substeps && solver.iterations && *solver.iterations < 2)
    fail(table.get("iterations")->source(), "solver.iterations",
         "is 1, which resolves no stiffness, so \"auto\" finds no substeps; give 2 or more, or substeps as a "
         "number");
  if (implicit && solver.weights != WeightForm::symmetric)
    fail(table.get("weights")->source(), "solver.weights",
         std::string("\"") + name_of(solver.weights) + "\" " + takes(Integrator::explicit_step) +
             "; leave it out");
}

// Adds default layers to a character whose scene defines none, as for a character without a scene file;
// returns whether it did. Comes before overrides, which may change them.
bool add_layers(toml::table& root, const SceneText& input, const SceneOverrides& overrides) {
  if (root.contains("layers")) return false;
  const std::vector<rig::Character> characters = characters_to_be(root, input.folder, input.files, overrides);
  if (characters.empty()) return false;
  const auto of_solver = [&](const char* key) {
    const auto set = overridden(overrides, std::string("solver.") + key);
    return set ? set : root["solver"][key].value<std::string>();
  };
  const rig::Character character = what_layers_go_by(characters);
  const Stiffness stiffness = stiffness_for(of_solver("integrator"), of_solver("weights"));
  toml::table defaults =
      parse_toml(layers_for_character(character, stiffness, input.source), "default layers");
  root.insert("layers", defaults["layers"]);
  // If `solver` is not a table, the checker reports it.
  if (toml::table* solver = root.insert("solver", toml::table{}).first->second.as_table())
    for (const char* key : {"integrator", "substeps"})
      if (const toml::node* value = defaults["solver"].as_table()->get(key))
        value->visit([&](const auto& node) { solver->insert(key, node); });
  return true;
}

}  // namespace

Scene parse_scene(const SceneText& input, const SceneOverrides& overrides) {
  toml::table root = parse_toml(input.text, input.source);
  const bool has_added = add_layers(root, input, overrides);
  apply_overrides(root, overrides);
  check_scene(root);
  if (!root.contains("layers")) fail(root.source(), "layers", "is missing; give at least one [layers.NAME]");
  if (const toml::table& layers = table_at(root, "layers"); layers.empty())
    fail(layers.source(), "layers", "is empty; give at least one [layers.NAME]");

  Scene scene;
  scene.converter = overrides.converter;
  scene.name = input.name;
  scene.source = input.source;
  scene.text = has_added || has_overrides(overrides) ? write_scene(root) : input.text;

  const toml::table& solver = table_at(root, "solver");
  scene.solver.integrator = integrator_of(root);
  read_keys(solver, scene.solver);
  read_general_keys(table_at(root, "scene"), scene);

  read_bones(root, scene);
  const bool has_character = root.contains("character");
  const Surroundings surroundings{!scene.bones.empty() || has_character, has_character};
  read_steps(solver, surroundings.has_joints, scene.solver);
  read_skeleton_settings(root, scene);
  read_layers(root, surroundings, scene);
  read_flesh(root, scene);
  read_contact(table_at(root, "contact"), surroundings, scene.contact);
  read_fibres(root, scene);
  read_muscles(root, surroundings, scene);
  for_each_named(root, "pin",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   scene.pins.push_back({name, read_where(table, surroundings, path)});
                 });
  for_each_named(root, "probe",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   scene.probes.push_back({name, read_where(table, surroundings, path)});
                 });
  read_forces(root, surroundings, scene);
  read_colliders(root, surroundings, scene);

  // Meshes last: they can be large, and a mistake in the scene file should be reported at once.
  if (root.contains("bar")) {
    read_bar(table_at(root, "bar"), scene);
  } else if (root.contains("mesh")) {
    read_mesh(table_at(root, "mesh"), input.folder, input.files, scene);
  } else {
    read_character(root, input.folder, input.files, scene);
  }
  check_muscle_bones(root, scene);
  check_collider_joints(root, scene);
  read_body(root, scene);
  read_time(root, scene);
  read_motion(root, scene);
  return scene;
}

std::vector<std::pair<std::string, std::string>> keys_without_end(const Scene& scene) {
  toml::table root = parse_toml(scene.text, scene.source);
  if (toml::table* table = root["scene"].as_table()) {
    table->erase("end");
    if (table->empty()) root.erase("scene");
  }
  return keys_and_values(root);
}

std::string documented_text(const Scene& scene) {
  const toml::table root = parse_toml(scene.text, scene.source);
  // Leave out keys that the scene would reject: those for the other integrator or for another kind of body.
  std::vector<const char*> left_out{"iterations", "quality", "viscosity"};
  if (scene.solver.integrator == Integrator::implicit_step)
    left_out.assign(explicit_keys.begin(), explicit_keys.end());
  if (scene.solver.integrator == Integrator::implicit_step && !scene.solver.auto_substeps)
    left_out.push_back("quality");
  if (!std::holds_alternative<rig::Character>(scene.geometry)) left_out.push_back("skeleton");
  if (std::holds_alternative<Bar>(scene.geometry) || std::holds_alternative<mesh::TetMesh>(scene.geometry))
    left_out.push_back("body");
  return write_documented_scene(root, left_out);
}

}  // namespace fascicle::scene
