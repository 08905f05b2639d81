// Converts checked TOML to values; shared by the readers of the scene file. check_scene has checked the
// types.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/scene/scene.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {

double number_of(const toml::node& node);
Vector3d vector_of(const toml::node& node);

// These set `out` if the key is present, and otherwise leave it.
void read(const toml::table& table, const char* key, double& out);
void read(const toml::table& table, const char* key, std::optional<double>& out);
void read(const toml::table& table, const char* key, std::optional<std::uint32_t>& out);
void read(const toml::table& table, const char* key, std::uint32_t& out);
void read(const toml::table& table, const char* key, std::uint64_t& out);
void read(const toml::table& table, const char* key, bool& out);
void read(const toml::table& table, const char* key, std::string& out);
void read(const toml::table& table, const char* key, Vector3d& out);
void read(const toml::table& table, const char* key, std::vector<std::string>& out);
void read(const toml::table& table, const char* key, NameLists& out);
void read(const toml::table& table, const char* key, std::optional<Vector3d>& out);
void read(const toml::table& table, const char* key, std::array<std::uint32_t, 3>& out);
void read(const toml::table& table, const char* key, std::vector<double>& out);
void read(const toml::table& table, const char* key, std::vector<Vector3d>& out);
void read(const toml::table& table, const char* key, KeyedCurve& out);
void read(const toml::table& table, const char* key, PerBone& out);

// Calls put with the index in key.allowed of the key's word; does nothing if the key is absent.
template <class Put>
void read_word(const toml::table& table, const Key& key, const Put& put) {
  const toml::node* node = table.get(key.name);
  if (node == nullptr) return;
  const std::string& word = node->as_string()->get();
  put(static_cast<std::size_t>(std::find(key.allowed.begin(), key.allowed.end(), word) -
                               key.allowed.begin()));
}

// An empty table if there is none.
const toml::table& table_at(const toml::table& table, const char* key);

// Calls use(name, table, path) for each table of a named_tables key, in the file's order.
template <class Use>
void for_each_named(const toml::table& root, const char* key, const Use& use) {
  for (const auto& [name, node] : in_order(table_at(root, key))) {
    use(std::string(name->str()), *node->as_table(), join_path(key, name->str()));
  }
}

// What shapes may refer to in this scene.
struct Surroundings {
  bool has_bones = false;
  bool has_joints = false;
};

// The shapes under `where` of the table at `path`; empty if the key is absent.
Where read_where(const toml::table& owner, const Surroundings& surroundings, const std::string& path);

// Adds [muscle.NAME] to the scene. Its layers must have been read.
void read_muscles(const toml::table& root, const Surroundings& surroundings, Scene& scene);

// Adds [collider.NAME] to the scene. Joints that colliders follow are checked once the character has been
// read.
void read_colliders(const toml::table& root, const Surroundings& surroundings, Scene& scene);
void check_collider_joints(const toml::table& root, const Scene& scene);

// [scene] fps, start and end, and [motion]: the clip that plays, and its timing. The geometry and the forces
// must have been read. Smooths the clip if the scene says so.
void read_time(const toml::table& root, Scene& scene);
void read_motion(const toml::table& root, Scene& scene);

// Rejects muscles whose keys do not match the joints of the scene's character.
void check_muscle_bones(const toml::table& root, const Scene& scene);

}  // namespace fascicle::scene
