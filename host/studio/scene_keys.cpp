#include "host/studio/scene_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "host/studio/body_messages.h"
#include "host/studio/key_use.h"

namespace fascicle::studio {
namespace {

using scene::EditedKey;
using scene::EditedTable;
using scene::KeyType;

// Range and unit of a key's slider. A key without an entry has only its own range.
struct Slider {
  std::string_view table, key;  // table: its name in the list of keys
  std::string_view unit;
  double least = 0.0, most = 0.0;  // both 0: none
  bool logarithmic = false;
};
constexpr std::array sliders{
    Slider{"layer", "alpha", "", 0.0, 1.0},
    Slider{"layer", "alpha_outer", "", 0.0, 1.0},
    Slider{"layer", "youngs_modulus", "Pa", 100.0, 1e7, true},
    Slider{"layer", "frequency", "Hz", 0.5, 100.0, true},
    Slider{"layer", "beta", "", 0.0, 1.0},
    Slider{"layer", "damping", "1/s", 0.0, 60.0},
    Slider{"layer", "damping_ratio", "", 0.0, 2.0},
    Slider{"layer", "density", "kg/m^3", 200.0, 4000.0, true},
    Slider{"layer", "inertia_scale", "", 0.0, 4.0},
    Slider{"layer", "volume", "", 0.0, 1.0},
    Slider{"layer", "least_volume", "", 0.0, 0.9},
    Slider{"solver", "viscosity", "s", 0.0, 0.002},
    Slider{"flesh", "softness", "", 0.1, 10.0, true},
    Slider{"flesh", "exaggerate", "", 0.0, 4.0},
    Slider{"muscle", "gain", "", 0.0, 5.0},
    Slider{"muscle", "twist", "", -1.0, 1.0},
    Slider{"contact", "friction", "", 0.0, 2.0},
    Slider{"contact", "distance", "m", 0.001, 1.0, true},
    Slider{"collider", "friction", "", 0.0, 2.0},
    Slider{"collider", "thickness", "m", 0.0, 0.1},
    Slider{"collider", "radius", "m", 0.0, 2.0},
    Slider{"depth", "minimum", "", 0.0, 1.0},
    Slider{"depth", "maximum", "", 0.0, 1.0},
    Slider{"volume_share", "minimum", "", 0.0, 1.0},
    Slider{"volume_share", "maximum", "", 0.0, 1.0},
    Slider{"bone_distance", "minimum", "m", 0.0, 0.5},
    Slider{"bone_distance", "maximum", "m", 0.0, 0.5},
    Slider{"half_space", "fraction", "", 0.0, 1.0},
    Slider{"half_space", "value", "m"},
    Slider{"joint_set", "share", "", 0.01, 1.0},
    Slider{"painted", "minimum", "", 0.0, 1.0},
    Slider{"painted", "maximum", "", 0.0, 1.0},
    Slider{"skeleton", "least_share", "", 0.0, 0.1},
    Slider{"scene", "gravity", "m/s^2", -20.0, 20.0},
    Slider{"scene", "fps", "1/s", 12.0, 120.0},
    Slider{"scene", "start", "s"},
    Slider{"scene", "end", "s"},
    Slider{"motion", "preroll", "s", 0.0, 2.0},
    Slider{"motion", "settle", "s", 0.0, 5.0},
    Slider{"motion", "hold", "s", 0.0, 5.0},
    Slider{"motion", "acceleration_limit", "m/s^2", 1.0, 1000.0, true},
    Slider{"force", "start", "s"},
    Slider{"force", "end", "s"},
};

const Slider* slider_of(std::string_view table, std::string_view key) {
  const auto found = std::find_if(sliders.begin(), sliders.end(),
                                  [&](const Slider& s) { return s.table == table && s.key == key; });
  return found == sliders.end() ? nullptr : &*found;
}

const char* kind_of(const scene::Key& key) {
  switch (key.type) {
    case KeyType::number:
      return "number";
    case KeyType::integer:
      return "integer";
    case KeyType::text:
      return "text";
    case KeyType::boolean:
      return "boolean";
    case KeyType::vector:
    case KeyType::integer_vector:
      return "vector";
    case KeyType::texts:
      return "texts";
    default:
      return "other";
  }
}

Json key_json(const EditedTable& table, const EditedKey& edited, const KeyUse& use) {
  const scene::Key& key = *edited.key;
  Json json{{"path", edited.path},
            {"name", key.name},
            {"doc", key.doc},
            {"kind", kind_of(key)},
            {"value", edited.value},
            {"is_set", edited.is_stated},
            {"fallback", key.fallback},
            {"rivals", edited.rivals},
            {"effect", needs_new_body(edited.path) ? "rebuild" : "live"}};
  if (std::string why = use.why_unused(table, edited); !why.empty()) json["why_unused"] = std::move(why);
  if (std::isfinite(key.range.minimum)) {
    json["minimum"] = key.range.minimum;
    json["minimum_excluded"] = key.range.minimum_excluded;
  }
  if (std::isfinite(key.range.maximum)) json["maximum"] = key.range.maximum;
  if (!key.allowed.empty()) json["allowed"] = key.allowed;
  if (const Slider* slider = slider_of(table.table->name, key.name)) {
    if (!slider->unit.empty()) json["unit"] = slider->unit;
    if (slider->least < slider->most) {
      json["soft_minimum"] = slider->least;
      json["soft_maximum"] = slider->most;
      json["logarithmic"] = slider->logarithmic;
    }
  }
  return json;
}

// ---- Presets

const EditedKey* find(const std::vector<EditedTable>& tables, std::string_view path) {
  for (const EditedTable& table : tables)
    for (const EditedKey& key : table.keys)
      if (key.path == path) return &key;
  return nullptr;
}

double number_at(const std::vector<EditedTable>& tables, std::string_view path, double otherwise) {
  const EditedKey* key = find(tables, path);
  return key != nullptr && key->value.is_number() ? key->value.get<double>() : otherwise;
}

// Rounded as a person would write it, so that the scene file stays readable.
double rounded(double value) {
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, 2.0 - std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

class Wish {
 public:
  Wish(const RunningBody& body, const std::vector<EditedTable>& tables) : body_(body), tables_(tables) {}

  // Multiplies the current value, within the bounds.
  void scale(const std::string& path, double factor, double least, double most) {
    const double now = number_at(tables_, path, 1.0);
    const double then = std::clamp(rounded(now * factor), least, most);
    if (then != now) changes_.push_back({path, Json(then)});
  }
  // Scales the damping of all free layers, in the form that each states.
  void scale_damping(double factor) {
    for_each_free([&](const std::string& path) {
      const EditedKey* ratio = find(tables_, path + ".damping_ratio");
      const bool by_ratio = ratio != nullptr && ratio->is_stated;
      scale(path + (by_ratio ? ".damping_ratio" : ".damping"), factor, 0.0, by_ratio ? 100.0 : 1e4);
    });
  }
  void scale_density(double factor) {
    for_each_free([&](const std::string& path) {
      // A material has its own density.
      const EditedKey* density = find(tables_, path + ".density");
      double now = density != nullptr && density->is_stated ? density->value.get<double>() : 0.0;
      for (const scene::Layer& layer : body_.scene().layers)
        if (now == 0.0 && path == "layers." + layer.name) now = layer.density;
      changes_.push_back({path + ".density", Json(std::min(rounded(now * factor), 1e5))});
    });
  }
  // The limit on flesh.exaggerate at which no layer exceeds the largest inertia scale.
  double most_exaggeration() const {
    double largest = 1e-6;
    for (const scene::Layer& layer : body_.scene().layers)
      if (!layer.kinematic) largest = std::max(largest, layer.inertia_scale / body_.scene().flesh.exaggerate);
    return std::min(scene::most_inertia, std::floor(scene::most_inertia / largest * 100.0) / 100.0);
  }
  void exaggerate(double factor) {
    if (body_.model().has_skeleton() && body_.scene().flesh.exaggerate > 0.0)
      scale("flesh.exaggerate", factor, 0.0, most_exaggeration());
  }
  // Explicit flesh is stiffest at alpha 1.
  void soften(double factor) {
    double least = 0.01;
    if (body_.scene().solver.integrator == scene::Integrator::explicit_step)
      for (const scene::Layer& layer : body_.scene().layers)
        if (!layer.kinematic)
          least = std::max(
              least, std::max(layer.alpha, layer.alpha_outer.value_or(0.0)) * body_.scene().flesh.softness);
    scale("flesh.softness", factor, std::min(least, 100.0), 100.0);
  }
  void only(const std::vector<std::string>& joints, const std::vector<std::string>& held) {
    changes_.push_back({"skeleton.only", Json(joints)});
    changes_.push_back({"skeleton.kinematic", held.empty() ? std::nullopt : std::optional<Json>(held)});
  }
  std::vector<scene::KeyChange> take() { return std::move(changes_); }

 private:
  template <class Visit>
  void for_each_free(Visit visit) const {
    for (const scene::Layer& layer : body_.scene().layers)
      if (!layer.kinematic) visit("layers." + layer.name);
  }

  const RunningBody& body_;
  const std::vector<EditedTable>& tables_;
  std::vector<scene::KeyChange> changes_;
};

std::string lowered(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// By joint name, the number of free vertices for which this joint has the largest weight.
std::map<std::string, std::size_t> flesh_of_joints(const RunningBody& body) {
  const model::Model& model = body.model();
  std::map<std::string, std::size_t> flesh;
  if (!model.has_skeleton()) return flesh;
  const std::vector<std::uint32_t> joints = strongest_joints(model);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i) && joints[i] < body.built().report.joints.size())
      ++flesh[body.built().report.joints[joints[i]].name];
  return flesh;
}

// The joint whose name has one of the words; earlier words take precedence, then the amount of flesh. A spine
// has many joints, and the belly hangs on one of them.
std::optional<std::size_t> joint_called(const std::vector<rig::Joint>& skeleton,
                                        const std::map<std::string, std::size_t>& flesh,
                                        std::initializer_list<std::string_view> words) {
  for (const std::string_view word : words) {
    std::optional<std::size_t> best;
    std::size_t most = 0;
    for (std::size_t j = 0; j < skeleton.size(); ++j) {
      if (lowered(skeleton[j].name).find(word) == std::string::npos) continue;
      const auto found = flesh.find(skeleton[j].name);
      const std::size_t count = found == flesh.end() ? 0 : found->second;
      if (best && count <= most) continue;
      best = j;
      most = count;
    }
    if (best) return best;
  }
  return std::nullopt;
}

const std::vector<rig::Joint>* skeleton_of(const RunningBody& body) {
  const auto* character = std::get_if<rig::Character>(&body.scene().geometry);
  return character == nullptr ? nullptr : &character->skeleton;
}

// Only the joint's own skin and flesh; that of the joints below it follows the skeleton.
Preset only_joint(const RunningBody& body, const std::vector<EditedTable>& tables, Preset preset,
                  std::initializer_list<std::string_view> words, bool with_below, const char* what) {
  const std::vector<rig::Joint>* skeleton = skeleton_of(body);
  const std::optional<std::size_t> joint =
      skeleton == nullptr
          ? std::nullopt
          : joint_called(*skeleton, with_below ? std::map<std::string, std::size_t>() : flesh_of_joints(body),
                         words);
  if (!joint) {
    preset.why_not = std::string("No joint has ") + what + " in its name; name one in skeleton.only";
    return preset;
  }
  std::vector<std::string> held;
  if (!with_below)
    for (const rig::Joint& one : *skeleton)
      if (one.parent == static_cast<std::int32_t>(*joint)) held.push_back(one.name);
  Wish wish(body, tables);
  wish.only({(*skeleton)[*joint].name}, held);
  preset.changes = wish.take();
  return preset;
}

Preset wished(Preset preset, Wish wish) {
  preset.changes = wish.take();
  if (preset.changes.empty()) preset.why_not = "Already at the limit";
  return preset;
}

}  // namespace

bool needs_new_body(std::string_view path) {
  for (const std::string_view table : {"bar.", "mesh.", "body.", "bones.", "skeleton."})
    if (path.starts_with(table)) return true;
  // A clip does not change the body.
  return path.starts_with("character") && !path.ends_with(".clip");
}

std::map<std::string, std::string> paint_files(const std::vector<EditedTable>& tables) {
  std::map<std::string, std::string> files;
  for (const EditedTable& table : tables) {
    if (!table.path.starts_with("character")) continue;
    for (const EditedKey& key : table.keys)
      if (key.key->name == "paint" && key.value.is_string() && key.value != "")
        files[key.path] = key.value.get<std::string>();
  }
  return files;
}

Json keys_json(const std::vector<EditedTable>& tables) {
  const KeyUse use(tables);
  Json groups = Json::array();
  for (const EditedTable& table : tables) {
    Json keys = Json::array();
    for (const EditedKey& key : table.keys) keys.push_back(key_json(table, key, use));
    groups.push_back(
        {{"path", table.path}, {"title", table.path}, {"doc", table.table->doc}, {"keys", std::move(keys)}});
  }
  return groups;
}

std::vector<Preset> presets_of(const RunningBody& body, const std::vector<EditedTable>& tables) {
  std::vector<Preset> presets;
  const auto add = [&](const char* name, const char* title, const char* doc, auto fill) {
    Wish wish(body, tables);
    fill(wish);
    presets.push_back(wished({name, title, doc, {}, {}}, std::move(wish)));
  };
  add("more-jiggle", "More jiggle", "Softer flesh that trails further and swings longer.", [](Wish& wish) {
    wish.soften(1.1);
    wish.scale_damping(0.85);
  });
  add("firmer", "Firmer", "Stiffer flesh that comes to rest sooner.", [](Wish& wish) {
    wish.soften(1.0 / 1.25);
    wish.scale_damping(1.25);
  });
  add("heavier", "Heavier", "Denser flesh of the same stiffness: it sags more and swings more slowly.",
      [](Wish& wish) { wish.scale_density(1.25); });
  presets.push_back(only_joint(body, tables,
                               {"only-belly",
                                "Only the belly",
                                "Only the belly's flesh moves; the rest follows the skeleton.",
                                {},
                                {}},
                               {"belly", "abdomen", "stomach", "spine", "torso"}, false,
                               "belly, abdomen, stomach, spine or torso"));
  presets.push_back(only_joint(
      body, tables,
      {"only-tail", "Only the tail", "Only the tail's flesh moves; the rest follows the skeleton.", {}, {}},
      {"tail"}, true, "tail"));
  // Softer flesh that feels more of the motion swings further, but it wrinkles when a bear lands. More
  // damping removes the wrinkles and leaves most of the swing.
  add("cartoon", "Cartoon", "Softer flesh with exaggerated motion, as in a cartoon.", [](Wish& wish) {
    wish.soften(1.15);
    wish.exaggerate(1.1);
    wish.scale_damping(1.2);
  });
  return presets;
}

Json presets_json(const std::vector<Preset>& presets) {
  Json list = Json::array();
  for (const Preset& preset : presets) {
    Json changes = Json::object();
    for (const scene::KeyChange& change : preset.changes)
      changes[change.path] = change.value ? *change.value : Json(nullptr);
    Json json{
        {"name", preset.name}, {"title", preset.title}, {"doc", preset.doc}, {"changes", std::move(changes)}};
    if (!preset.why_not.empty()) json["why_not"] = preset.why_not;
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace fascicle::studio
