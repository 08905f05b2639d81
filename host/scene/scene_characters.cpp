// [character] and [character.NAME]: reading the characters, and joining several into one.
#include "host/scene/scene_characters.h"

#include <algorithm>
#include <cmath>

#include "host/base/nearest_name.h"
#include "host/base/trigonometry.h"
#include "host/made/made_character.h"
#include "host/mesh/mesh_file.h"
#include "host/rig/join.h"
#include "host/rig/paint.h"
#include "host/rig/pose.h"
#include "host/rig/pose_interpolation.h"
#include "host/rig/rig_math.h"
#include "host/rig/smooth_clip.h"
#include "host/scene/bearers.h"
#include "host/scene/input_files.h"
#include "host/scene/overrides.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_paint.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {
namespace {

// The rotation of turned_by as a quaternion, in the order x y z w.
Eigen::Vector4d quaternion_about(const Vector3d& degrees) {
  const double angle = degrees.norm() * (3.14159265358979323846 / 180.0);
  if (!(angle > 0.0)) return {0.0, 0.0, 0.0, 1.0};
  const Vector3d axis = degrees.normalized() * base::exact_sin(angle / 2.0);
  return {axis[0], axis[1], axis[2], base::exact_cos(angle / 2.0)};
}

struct Bounds {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  Vector3d middle() const { return (low + high) / 2.0; }
};

Bounds bounds_of(const rig::Character& character) {
  const std::vector<Vector3d>& points = character.surface.vertices;
  if (points.empty()) return {};
  Bounds bounds{points.front(), points.front()};
  for (const Vector3d& p : points) {
    bounds.low = bounds.low.cwiseMin(p);
    bounds.high = bounds.high.cwiseMax(p);
  }
  return bounds;
}

// Places the bind poses on a square grid on the ground, more than a whole body's extent apart, so that no
// mesher joins them and contact treats them as distant.
void place_bind_poses(double contact_distance, std::vector<PlacedCharacter>& characters) {
  constexpr double gap_in_distances = 4.0;
  double largest = 0.0;
  for (const PlacedCharacter& character : characters) {
    const Bounds bounds = bounds_of(character.own);
    largest = std::max(largest, (bounds.high - bounds.low).maxCoeff());
  }
  const double pitch = 2.0 * largest + gap_in_distances * contact_distance;
  std::size_t columns = 1;
  while (columns * columns < characters.size()) ++columns;
  const Vector3d first = bounds_of(characters.front().own).middle();
  for (std::size_t k = 1; k < characters.size(); ++k) {
    const Vector3d middle = bounds_of(characters[k].own).middle();
    const std::size_t row = k / columns;
    characters[k].bind_offset = {first[0] - middle[0] + pitch * static_cast<double>(k % columns), 0.0,
                                 first[2] - middle[2] + pitch * static_cast<double>(row)};
  }
}

// A still mesh as a character: a single joint carries all of it, and no clip moves the joint.
rig::Character character_of_mesh(mesh::SurfaceMesh mesh) {
  rig::Character character;
  rig::Joint joint;
  joint.name = "mesh";
  joint.skins = true;
  character.skeleton.push_back(joint);
  character.joints.resize(mesh.vertices.size());
  character.weights.resize(mesh.vertices.size(), {1.0});
  character.surface = std::move(mesh);
  return character;
}

// Loads the file into `loaded`. Geometry without animation becomes a character only if `rigid`, because it
// cannot drive flesh.
void load_file(const std::filesystem::path& file, bool rigid, LoadedFiles* files, Scene& loaded) {
  if (!mesh::is_surface_mesh_file(file))
    return load_character(file, loaded, rigid ? gltf::Still::carried : gltf::Still::left_out, files);
  if (!rigid)
    throw InputFileError(file.string() +
                         " is a mesh without a skeleton; for a solid prop, set rigid = true in its "
                         "[character.NAME]; for a body of flesh, use [mesh]");
  load_mesh(file, loaded, files);
  loaded.geometry = character_of_mesh(std::move(std::get<mesh::SurfaceMesh>(loaded.geometry)));
}

rig::Character made_character(const std::string& name, LoadedFiles* files) {
  return files != nullptr ? files->made(name) : made::make_character(name);
}

// The character from its file or generator, without paint; adds the file's hashes to the scene.
rig::Character load_unpainted(const toml::table& table, const std::string& path,
                              const std::filesystem::path& folder, LoadedFiles* files, Scene& scene) {
  if (table.contains("made")) return made_character(*table["made"].value<std::string>(), files);
  Scene loaded;
  loaded.converter = scene.converter;
  try {
    load_file(folder / *table["file"].value<std::string>(), table["rigid"].value_or(false), files, loaded);
  } catch (const InputFileError& error) {
    fail(table.get("file")->source(), join_path(path, "file"), error.what());
  }
  for (const auto& input : loaded.input_hashes)
    if (std::find(scene.input_hashes.begin(), scene.input_hashes.end(), input) == scene.input_hashes.end())
      scene.input_hashes.push_back(input);
  return std::move(std::get<rig::Character>(loaded.geometry));
}

// Loads a character as its table specifies, and appends what a paint file paints on it to `paint`.
rig::Character load_one(const toml::table& table, const std::string& path,
                        const std::filesystem::path& folder, LoadedFiles* files, Scene& scene,
                        std::vector<FilePaint>& paint) {
  rig::Character character = load_unpainted(table, path, folder, files, scene);
  const std::string file = table["paint"].value_or(std::string());
  if (file.empty()) return character;
  const toml::source_region& source = table.get("paint")->source();
  const std::string key = join_path(path, "paint");
  try {
    paint.push_back(file_paint(lay_paint_over(folder / file, files, scene, character), source, key));
  } catch (const InputFileError& error) {
    fail(source, key, error.what());
  }
  return character;
}

// Names in [skeleton] must start with a character's name. Whether the rest exists is checked after the body
// is built.
void check_skeleton_names(const toml::table& root, const Scene& scene) {
  const rig::Character& character = std::get<rig::Character>(scene.geometry);
  std::vector<std::string> known;
  for (const rig::Joint& joint : character.skeleton) known.push_back(joint.name);
  for (const rig::SurfacePart& part : character.parts) {
    known.push_back(part.object);
    known.push_back(part.material);
  }
  for (const auto& [key, node] : in_order(table_at(root, "skeleton"))) {
    const toml::array* names = node->as_array();
    for (std::size_t k = 0; names != nullptr && k < names->size(); ++k) {
      const std::string& name = (*names)[k].as_string()->get();
      const bool has_owner =
          std::any_of(scene.characters.begin(), scene.characters.end(),
                      [&](const PlacedCharacter& one) { return name.starts_with(one.settings.name + "/"); });
      if (!has_owner)
        fail((*names)[k].source(), join_path("skeleton", key->str()),
             "\"" + one_line(name) + "\" does not name its character; names begin with a character's, as \"" +
                 scene.characters.front().settings.name + "/...\"" + base::nearest_name_hint(name, known));
    }
  }
}

// Unpainted flesh counts as 0, which is hardly ever intended for a whole character, unless it has a value of
// its own.
void check_paint(const toml::table& root, const Scene& scene, const std::string& channel, bool of_rigid) {
  if (channel.empty()) return;
  const std::string attribute = channel.substr(0, channel.find('.'));
  const PlacedCharacter *with = nullptr, *without = nullptr;
  for (const PlacedCharacter& one : scene.characters) {
    if (one.settings.rigid && !of_rigid) continue;
    const bool has = std::any_of(one.own.painted.begin(), one.own.painted.end(),
                                 [&](const rig::PaintedAttribute& a) { return a.name == attribute; });
    (has ? with : without) = &one;
  }
  if (with == nullptr || without == nullptr || rig::value_elsewhere(attribute) != 0.0) return;
  const std::string& name = without->settings.name;
  fail(root["character"][name].node()->source(), join_path("character", name),
       "has no `" + attribute + "`, which is painted on " + with->settings.name +
           " and which the scene uses; paint both, or remove it from the scene");
}

void read_named_characters(const toml::table& root, const std::filesystem::path& folder, LoadedFiles* files,
                           Scene& scene) {
  std::vector<FilePaint> paint;
  for_each_named(
      root, "character", [&](const std::string& name, const toml::table& table, const std::string& path) {
        PlacedCharacter character;
        character.settings.name = name;
        read_keys(table, character.settings);
        if (character.settings.thickness > 0.0 && !character.settings.rigid)
          fail(table.get("thickness")->source(), join_path(path, "thickness"),
               "is only for a prop; set rigid = true, or leave it out");
        if (!character.settings.file.empty()) character.file = folder / character.settings.file;
        character.own = load_one(table, path, folder, files, scene, paint);
        rig::name_apart(character.own, name);
        const toml::node* clip = table.get("clip");
        try {
          rig::find_clip(character.own, character.settings.clip);
        } catch (const SceneError& error) {
          fail(clip != nullptr ? clip->source() : table.source(), join_path(path, "clip"), error.what());
        }
        scene.characters.push_back(std::move(character));
      });
  put_bearers_first(root, scene);
  try {
    join_characters(scene);
  } catch (const SceneError& error) {
    fail(root.get("character")->source(), "character", error.what());
  }
  check_skeleton_names(root, scene);
  let_paint_act(paint, scene);
  for (const Layer& layer : scene.layers) check_paint(root, scene, layer.alpha_attribute, false);
  check_paint(root, scene, scene.contact.attribute, true);
}

}  // namespace

void read_character(const toml::table& root, const std::filesystem::path& folder, LoadedFiles* files,
                    Scene& scene) {
  if (has_named_characters(root)) return read_named_characters(root, folder, files, scene);
  const toml::table& table = table_at(root, "character");
  read_character_keys(table, scene);
  std::vector<FilePaint> paint;
  scene.geometry = load_one(table, "character", folder, files, scene, paint);
  let_paint_act(paint, scene);
}

void join_characters(Scene& scene) {
  place_bind_poses(scene.contact.distance.value_or(0.0), scene.characters);
  std::vector<rig::Placed> placed;
  std::uint32_t joints = 0, nodes = 0;
  for (PlacedCharacter& character : scene.characters) {
    character.first_joint = joints;
    character.first_node = nodes;
    joints += 1 + static_cast<std::uint32_t>(character.own.skeleton.size());
    nodes += rig::node_count(character.own);
    const CharacterSettings& settings = character.settings;
    const Eigen::Vector4d turn = quaternion_about(settings.turn);
    place(scene.characters, rig::local_transform(settings.at, turn, Vector3d::Ones()), character);
    placed.push_back({.name = settings.name,
                      .character = &character.own,
                      .clip = rig::find_clip(character.own, settings.clip),
                      .start = settings.start,
                      .at = settings.at,
                      .turn = turn,
                      .bearer = character.bearer ? static_cast<std::int32_t>(*character.bearer) : -1,
                      .bind_offset = character.bind_offset,
                      .first_node = character.first_node,
                      .place = character.place});
  }
  scene.geometry = rig::joined(placed);
}

void smooth_clips(Scene& scene, bool repeats) {
  const auto smooth = [&](rig::Character& character, const std::string& clip, double start) {
    const rig::Clip* played = rig::find_clip(character, clip);
    if (played == nullptr) return;
    rig::Clip& own = character.clips[static_cast<std::size_t>(played - character.clips.data())];
    std::vector<rig::WeightChannel> weights = std::move(own.weights);
    own = rig::smooth_clip(own, repeats, scene.start - start, scene.end - start);
    own.weights = std::move(weights);
  };
  for (PlacedCharacter& character : scene.characters)
    smooth(character.own, character.settings.clip, character.settings.start);
  if (scene.characters.empty())
    smooth(std::get<rig::Character>(scene.geometry), scene.clip, 0.0);
  else
    join_characters(scene);
}

bool is_still_mesh(const PlacedCharacter& character) {
  return mesh::is_surface_mesh_file(character.file);
}

bool is_still_prop(const PlacedCharacter& character) {
  return character.settings.rigid && character.own.clips.empty();
}

Eigen::Matrix4d back_from(const PlacedCharacter& character) {
  if (character.bearer) return rig::affine_inverse(character.place);
  const Eigen::Matrix3d turn = character.place.topLeftCorner<3, 3>().transpose();
  Eigen::Matrix4d back = Eigen::Matrix4d::Identity();
  back.topLeftCorner<3, 3>() = turn;
  back.topRightCorner<3, 1>() = -(turn * character.settings.at);
  return back;
}

std::vector<std::size_t> characters_with_flesh(const Scene& scene) {
  std::vector<std::size_t> all, with_flesh;
  for (std::size_t k = 0; k < std::max<std::size_t>(scene.characters.size(), 1); ++k) {
    all.push_back(k);
    if (scene.characters.empty() || !scene.characters[k].settings.rigid) with_flesh.push_back(k);
  }
  return with_flesh.empty() ? all : with_flesh;
}

std::vector<std::uint32_t> first_joints(const Scene& scene) {
  std::vector<std::uint32_t> joints;
  for (const PlacedCharacter& character : scene.characters) joints.push_back(character.first_joint);
  return joints;
}

std::size_t character_of_joint(const Scene& scene, std::size_t joint) {
  std::size_t k = 0;
  while (k + 1 < scene.characters.size() && scene.characters[k + 1].first_joint <= joint) ++k;
  return k;
}

std::vector<rig::Character> characters_to_be(const toml::table& root, const std::filesystem::path& folder,
                                             LoadedFiles* files, const SceneOverrides& overrides) {
  std::vector<rig::Character> all;
  std::vector<bool> is_prop;
  // Accepts still meshes everywhere; reading the character checks whether one is allowed.
  const auto load = [&](const toml::table& table, const std::string& path) {
    const auto stated = [&](const char* key) { return overridden(overrides, join_path(path, key)); };
    Scene loaded;
    loaded.converter = overrides.converter;
    try {
      if (const auto file = stated("file")) {
        load_file(folder / *file, true, files, loaded);
        all.push_back(std::move(std::get<rig::Character>(loaded.geometry)));
      } else if (const auto made = stated("made")) {
        all.push_back(made_character(*made, files));
      } else if (const auto in_table = table["file"].value<std::string>()) {
        load_file(folder / *in_table, true, files, loaded);
        all.push_back(std::move(std::get<rig::Character>(loaded.geometry)));
      } else if (const auto name = table["made"].value<std::string>()) {
        all.push_back(made_character(*name, files));
      } else {
        return;
      }
      const auto rigid = stated("rigid");
      is_prop.push_back(rigid ? *rigid == "true" : table["rigid"].value_or(false));
      const auto paint = stated("paint");
      const std::string file = paint ? *paint : table["paint"].value_or(std::string());
      if (!file.empty()) lay_paint_over(folder / file, files, loaded, all.back());
    } catch (const std::runtime_error&) {
      // Found again, and reported with its location, when the character is read.
    }
  };
  const toml::table* table = root["character"].as_table();
  if (table == nullptr) return all;
  if (!has_named_characters(root)) {
    load(*table, "character");
  } else {
    for (const auto& [name, node] : in_order(*table))
      load(*node->as_table(), join_path("character", name->str()));
  }
  if (all.empty()) all.emplace_back();
  // The layers of flesh do not go by the size of the house that it lives in.
  is_prop.resize(all.size(), false);
  if (std::find(is_prop.begin(), is_prop.end(), false) != is_prop.end())
    for (std::size_t k = 0; k < all.size(); ++k)
      if (is_prop[k]) all[k].surface.vertices.clear();
  return all;
}

}  // namespace fascicle::scene
