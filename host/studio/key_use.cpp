#include "host/studio/key_use.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "host/scene/scene.h"

namespace fascicle::studio {
namespace {

using scene::EditedKey;
using scene::EditedTable;
using scene::Integrator;

// The same lists as in the reader of scene files (scene_file.cpp); a test sets each key and checks that it is
// refused.
constexpr std::array<std::string_view, 2> of_explicit_layers{"alpha", "alpha_outer"};
constexpr std::array<std::string_view, 5> of_implicit_layers{"youngs_modulus", "frequency", "material",
                                                             "damping_ratio", "least_volume"};
constexpr std::array<std::string_view, 3> of_implicit_solver{"iterations", "quality", "viscosity"};
constexpr std::array<std::string_view, 3> of_moving_layers{"frequency", "damping_ratio", "sliding"};

template <std::size_t count>
bool has(const std::array<std::string_view, count>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool has(const std::vector<std::string>& paths, const std::string& path) {
  return std::find(paths.begin(), paths.end(), path) != paths.end();
}

}  // namespace

KeyUse::KeyUse(const std::vector<EditedTable>& tables) {
  bool has_explicit = false, has_implicit = false;
  for (const EditedTable& table : tables)
    for (const EditedKey& key : table.keys) {
      if (!key.is_stated) continue;
      const std::string_view name = key.key->name;
      if (table.path == "solver" && name == "integrator") {
        is_stated_ = true;
        is_implicit_ = key.value == name_of(Integrator::implicit_step);
      }
      if (table.path == "solver" && name == "substeps") has_auto_substeps_ = key.value.is_string();
      if (table.table->name != "layer") continue;
      if (name == "kinematic" && key.value == true) still_layers_.push_back(table.path);
      // least_volume does not define a stiffness.
      const bool is_implicit_stiffness = has(of_implicit_layers, name) && name != "least_volume";
      const bool is_explicit_stiffness = has(of_explicit_layers, name);
      has_implicit = has_implicit || is_implicit_stiffness;
      has_explicit = has_explicit || is_explicit_stiffness;
      if (is_implicit_stiffness || is_explicit_stiffness) layers_with_stiffness_.push_back(table.path);
    }
  if (!is_stated_) is_implicit_ = has_implicit && !has_explicit;
}

std::string KeyUse::why_unused(const EditedTable& table, const EditedKey& key) const {
  if (key.is_stated) return {};
  const std::string_view name = key.key->name;
  if (table.path == "solver") {
    if (has(of_implicit_solver, name) && !is_implicit_)
      return "Only for the implicit integrator; this scene uses the explicit one";
    if (name == "quality" && !has_auto_substeps_) return "Only if solver.substeps is \"auto\"";
    return {};
  }
  if (table.table->name != "layer") return {};
  if (has(of_moving_layers, name) && has(still_layers_, table.path))
    return "Only for flesh that moves by itself";
  // The only layer with a stiffness may state it in the other integrator's keys; that selects the integrator.
  const bool may_change_integrator =
      !is_stated_ && std::all_of(layers_with_stiffness_.begin(), layers_with_stiffness_.end(),
                                 [&](const std::string& path) { return path == table.path; });
  const bool is_of_other = is_implicit_ ? has(of_explicit_layers, name) : has(of_implicit_layers, name);
  // These do not define a stiffness and select no integrator.
  const bool is_no_stiffness = name == "least_volume" || name == "damping_ratio";
  if (is_no_stiffness ? is_implicit_ : !is_of_other || may_change_integrator) return {};
  return is_implicit_ ? "Only for the explicit integrator; here youngs_modulus, frequency or material sets "
                        "the stiffness"
                      : "Only for the implicit integrator; here alpha sets the stiffness";
}

}  // namespace fascicle::studio
