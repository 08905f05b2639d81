#include "host/scene/scene_values.h"

namespace fascicle::scene {

double number_of(const toml::node& node) {
  const auto* integer = node.as_integer();
  return integer != nullptr ? static_cast<double>(integer->get()) : node.as_floating_point()->get();
}

Vector3d vector_of(const toml::node& node) {
  const toml::array& array = *node.as_array();
  return {number_of(array[0]), number_of(array[1]), number_of(array[2])};
}

void read(const toml::table& table, const char* key, double& out) {
  if (const toml::node* node = table.get(key)) out = number_of(*node);
}

void read(const toml::table& table, const char* key, std::optional<double>& out) {
  if (const toml::node* node = table.get(key)) out = number_of(*node);
}

void read(const toml::table& table, const char* key, std::uint32_t& out) {
  if (const toml::node* node = table.get(key)) out = static_cast<std::uint32_t>(node->as_integer()->get());
}

void read(const toml::table& table, const char* key, std::uint64_t& out) {
  if (const toml::node* node = table.get(key)) out = static_cast<std::uint64_t>(node->as_integer()->get());
}

void read(const toml::table& table, const char* key, bool& out) {
  if (const toml::node* node = table.get(key)) out = node->as_boolean()->get();
}

void read(const toml::table& table, const char* key, std::string& out) {
  if (const toml::node* node = table.get(key)) out = node->as_string()->get();
}

void read(const toml::table& table, const char* key, Vector3d& out) {
  if (const toml::node* node = table.get(key)) out = vector_of(*node);
}

void read(const toml::table& table, const char* key, std::vector<std::string>& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const toml::node& text : *node->as_array()) out.push_back(text.as_string()->get());
}

void read(const toml::table& table, const char* key, NameLists& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const toml::node& list : *node->as_array()) {
    out.emplace_back();
    for (const toml::node& text : *list.as_array()) out.back().push_back(text.as_string()->get());
  }
}

void read(const toml::table& table, const char* key, std::optional<std::uint32_t>& out) {
  if (!table.contains(key)) return;
  read(table, key, out.emplace());
}

void read(const toml::table& table, const char* key, std::optional<Vector3d>& out) {
  if (const toml::node* node = table.get(key)) out = vector_of(*node);
}

void read(const toml::table& table, const char* key, std::array<std::uint32_t, 3>& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (std::size_t axis = 0; axis < 3; ++axis)
    out[axis] = static_cast<std::uint32_t>((*node->as_array())[axis].as_integer()->get());
}

void read(const toml::table& table, const char* key, std::vector<double>& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const toml::node& number : *node->as_array()) out.push_back(number_of(number));
}

void read(const toml::table& table, const char* key, std::vector<Vector3d>& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const toml::node& point : *node->as_array()) out.push_back(vector_of(point));
}

void read(const toml::table& table, const char* key, PerBone& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const auto& [name, value] : in_order(*node->as_table()))
    out.emplace_back(std::string(name->str()), number_of(*value));
}

void read(const toml::table& table, const char* key, KeyedCurve& out) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return;
  for (const toml::node& pair : *node->as_array())
    out.emplace_back(number_of((*pair.as_array())[0]), number_of((*pair.as_array())[1]));
}

const toml::table& table_at(const toml::table& table, const char* key) {
  static const toml::table empty;
  const toml::node* node = table.get(key);
  return node != nullptr ? *node->as_table() : empty;
}

}  // namespace fascicle::scene
