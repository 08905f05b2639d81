// From checked TOML to values: what the readers of the scene file share. check_scene has seen the types.
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

// These take the value if the key is there and else leave what stands.
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

// Calls put with the number of the word, in key.allowed, that the key has; not at all where it is absent.
template <class Put>
void read_word(const toml::table& table, const Key& key, const Put& put) {
  const toml::node* node = table.get(key.name);
  if (node == nullptr) return;
  const std::string& word = node->as_string()->get();
  put(static_cast<std::size_t>(std::find(key.allowed.begin(), key.allowed.end(), word) -
                               key.allowed.begin()));
}

// Empty where there is none.
const toml::table& table_at(const toml::table& table, const char* key);

// Calls use(name, table, path) for each table of a named_tables key, in the file's order.
template <class Use>
void for_each_named(const toml::table& root, const char* key, const Use& use) {
  for (const auto& [name, node] : in_order(table_at(root, key))) {
    use(std::string(name->str()), *node->as_table(), join_path(key, name->str()));
  }
}

// What shapes may refer to.
struct Surroundings {
  bool has_bones = false;
  bool has_joints = false;
};

// The shapes under `where` of the table at `path`; none where there is no such key.
Where read_where(const toml::table& owner, const Surroundings& surroundings, const std::string& path);

// Adds [muscle.NAME] to the scene, whose layers have been read.
void read_muscles(const toml::table& root, const Surroundings& surroundings, Scene& scene);

// Adds [collider.NAME] to the scene. Whether the joint that one goes with is there is asked once the
// character has been read.
void read_colliders(const toml::table& root, const Surroundings& surroundings, Scene& scene);
void check_collider_joints(const toml::table& root, const Scene& scene);

// [scene] fps, start and end, and [motion]: the clip that plays, and how time runs around it. The geometry
// and the forces have been read. Makes the clip smooth if that is said.
void read_time(const toml::table& root, Scene& scene);
void read_motion(const toml::table& root, Scene& scene);

// Refuses muscles whose words fit no joints of the scene's character.
void check_muscle_bones(const toml::table& root, const Scene& scene);

}  // namespace fascicle::scene
