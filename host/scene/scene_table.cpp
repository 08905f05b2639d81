#include "host/scene/scene_table.h"

#include "host/scene/scene_keys.h"

namespace fascicle::scene {

const Table& scene_table() {
  static const Table root{
      .name = "root",
      .doc = "A fascicle scene. Metres, kilograms, seconds, Y up.",
      .keys =
          {{.name = "scene",
            .type = KeyType::table,
            .doc = "Settings for the whole scene.",
            .table = &general_table()},
           {.name = "bar", .type = KeyType::table, .doc = "The body: a bar.", .table = &bar_table()},
           {.name = "mesh", .type = KeyType::table, .doc = "The body: a mesh file.", .table = &mesh_table()},
           {.name = "character",
            .type = KeyType::table,
            .doc = "The body: a character.",
            .table = &character_table(),
            .named = &placed_character_table()},
           {.name = "body",
            .type = KeyType::table,
            .doc = "How a surface or a character is filled with tetrahedra.",
            .table = &body_table()},
           {.name = "bones", .type = KeyType::named_tables, .doc = "Bones by name.", .table = &bone_table()},
           {.name = "skeleton",
            .type = KeyType::table,
            .doc = "Roles of the joints.",
            .table = &skeleton_table()},
           {.name = "flesh",
            .type = KeyType::table,
            .doc = "Adjustments to all flesh.",
            .table = &flesh_table()},
           {.name = "contact",
            .type = KeyType::table,
            .doc = "Contact between flesh and flesh.",
            .table = &contact_table()},
           {.name = "layers",
            .type = KeyType::named_tables,
            .doc = "Layers by name, at least one. Default for a character: fat, muscle and bone by depth.",
            .table = &layer_table()},
           {.name = "fibres",
            .type = KeyType::named_tables,
            .doc = "Fibre curves by name.",
            .table = &fibre_curve_table()},
           {.name = "muscle",
            .type = KeyType::named_tables,
            .doc = "Muscles by name.",
            .table = &muscle_table()},
           {.name = "solver",
            .type = KeyType::table,
            .doc = "Time stepping and accuracy.",
            .table = &solver_table()},
           {.name = "motion",
            .type = KeyType::table,
            .doc = "Playback of the clip, and gravity in the rest shape.",
            .table = &motion_table()},
           {.name = "pin",
            .type = KeyType::named_tables,
            .doc = "Pinned vertices by name.",
            .table = &pin_table()},
           {.name = "probe",
            .type = KeyType::named_tables,
            .doc = "Probes by name.",
            .table = &probe_table()},
           {.name = "force",
            .type = KeyType::named_tables,
            .doc = "Forces by name.",
            .table = &force_table()},
           {.name = "collider",
            .type = KeyType::named_tables,
            .doc = "Solids that flesh cannot enter, by name; at most 32.",
            .table = &collider_table()}},
      .choices = {{"bar", "mesh", "character"}}};
  return root;
}

const Key* find_key(const Table& table, std::string_view name) {
  for (const Key& key : table.keys) {
    if (key.name == name) return &key;
  }
  return nullptr;
}

std::vector<std::string> key_names(const Table& table) {
  std::vector<std::string> names;
  names.reserve(table.keys.size());
  for (const Key& key : table.keys) names.push_back(key.name);
  return names;
}

bool is_valid_name(std::string_view name) {
  if (name.empty() || name.size() > longest_name) return false;
  for (const char c : name) {
    const bool good =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    if (!good) return false;
  }
  return true;
}

}  // namespace fascicle::scene
