#include <algorithm>

#include "host/base/nearest_name.h"
#include "host/scene/muscle_bones.h"
#include "host/scene/scene_keys.h"
#include "host/scene/scene_values.h"

namespace fascicle::scene {
namespace {

Muscle read_muscle(const std::string& name, const toml::table& table, const Surroundings& surroundings,
                   const std::string& path) {
  Muscle muscle;
  muscle.name = name;
  read_keys(table, muscle);
  muscle.where = read_where(table, surroundings, path);
  return muscle;
}

void check_muscle(const Muscle& muscle, const toml::table& table, const std::string& path,
                  const std::vector<Layer>& layers) {
  const auto refuse = [&](const char* key, const std::string& what) {
    fail(table.contains(key) ? table.get(key)->source() : table.source(), join_path(path, key), what);
  };
  if (muscle.joint.empty() && muscle.bone.empty())
    refuse("joint", "is missing; name the joint that bends, or the `bone` of a muscle that only contracts");
  for (const char* key : {"parent", "child", "axis", "activation", "curve"})
    if (muscle.joint.empty() && table.contains(key))
      refuse(key,
             "applies to a muscle that follows a joint, and this one names none; add `joint`, or leave this "
             "out");
  if (!muscle.curve.empty() && table.contains("activation"))
    refuse("curve", "conflicts with activation; give one of them");
  if (!muscle.contraction.empty() && !muscle.contraction_channel.empty())
    refuse("contraction_channel", "conflicts with contraction; give one of them");
  std::vector<std::string> names;
  for (const Layer& layer : layers) names.push_back(layer.name);
  if (!muscle.layer.empty() && std::find(names.begin(), names.end(), muscle.layer) == names.end())
    refuse("layer",
           "there is no layer \"" + muscle.layer + "\"" + base::nearest_name_hint(muscle.layer, names));
}

}  // namespace

void read_muscles(const toml::table& root, const Surroundings& surroundings, Scene& scene) {
  for_each_named(root, "muscle",
                 [&](const std::string& name, const toml::table& table, const std::string& path) {
                   if (!surroundings.has_joints)
                     fail(table.source(), path,
                          "only a [character] has joints and bones that carry muscles; leave it out");
                   scene.muscles.push_back(read_muscle(name, table, surroundings, path));
                   check_muscle(scene.muscles.back(), table, path, scene.layers);
                 });
}

void check_muscle_bones(const toml::table& root, const Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  if (character == nullptr) return;
  for (const Muscle& muscle : scene.muscles) {
    try {
      muscle_bones(*character, muscle);
      if (!muscle.contraction_channel.empty()) contraction_channel(*character, muscle);
    } catch (const SceneError& error) {
      throw SceneError(location(table_at(root, "muscle").get(muscle.name)->source()) + ": " + error.what());
    }
  }
}

}  // namespace fascicle::scene
