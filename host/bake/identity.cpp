#include "host/bake/identity.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/base/content_hash.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/formats.h"
#include "host/model/model_arrays.h"
#include "host/scene/input_files.h"
#include "host/scene/scene_json.h"
#include "host/scene/scene_text.h"

namespace fascicle::bake {

using scene::json_of;

namespace {

class Hash {
 public:
  Hash() : state_(XXH3_createState()) {
    if (!state_) throw std::bad_alloc();
    XXH3_64bits_reset(state_.get());
  }
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T value) { XXH3_64bits_update(state_.get(), &value, sizeof value); }
  // Includes the length: else an element could move from one array to the next unnoticed.
  template <class T>
  void add_array(std::span<const T> values) {
    add(std::uint64_t{values.size()});
    XXH3_64bits_update(state_.get(), values.data(), values.size_bytes());
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add_array(std::span<const T>(values));
  }
  void add(const std::string& text) { add_array(std::span<const char>(text)); }
  std::uint64_t value() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

struct FieldHash {
  template <class T>
  void operator()(const char*, const T& field) {
    hash.add(field);
  }
  void operator()(const char*, const std::array<double, 3>& field) {
    hash.add_array(std::span<const double>(field));
  }
  template <class T>
  void optional(const char* name, const std::vector<T>& list) {
    // Includes the name: else another such array could give the same hash.
    if (!list.empty()) hash.add(std::string(name));
    if (!list.empty()) hash.add(list);
  }
  template <class T>
  void count(const char*, const std::vector<T>& list) {
    hash.add(std::uint64_t{list.size()});
  }
  Hash& hash;
};

constexpr const char* end_name = "end";
constexpr const char* model_name = "model";
// For keys in the scene's text; other names are for values derived from it.
constexpr const char* key_prefix = "the key ";
constexpr const char *self_contact_name = "contact of the body with itself", *self_contact_kept = "kept";
constexpr const char* formats_name = "--format";
// Only in checkpoints: formats whose files are missing or incomplete.
constexpr const char* anew_name = "begun anew";
// These affect only how files are written, and a bake can rewrite those from its frames.
constexpr std::array<std::string_view, 5> options_of_files{"--glb-stride", "--glb-error", "--glb-compress",
                                                           "--glb-tolerance", "--usd-skel"};

std::string in_one_line(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ",") + name;
  return list;
}

std::vector<std::string> listed(const std::string& names) {
  std::vector<std::string> list;
  std::istringstream words(names);
  for (std::string word; std::getline(words, word, ',');) list.push_back(word);
  return list;
}

// Of what moves the skin: rest poses, keys and their interpolation.
std::string hash_of_motion(const rig::Character& character) {
  base::ContentHash hash;
  const auto add_matrix = [&](const Eigen::Matrix4d& matrix) {
    hash.add_array(std::span<const double>(matrix.data(), 16));
  };
  add_matrix(character.root);
  hash.add(std::uint64_t{character.skeleton.size()});
  for (const rig::Joint& joint : character.skeleton) {
    hash.add(std::string_view(joint.name));
    hash.add(joint.parent);
    add_matrix(joint.rest_local);
    add_matrix(joint.inverse_bind);
  }
  hash.add(std::uint64_t{character.clips.size()});
  for (const rig::Clip& clip : character.clips) {
    hash.add(std::string_view(clip.name));
    hash.add(clip.duration);
    hash.add(std::uint64_t{clip.channels.size()});
    for (const rig::Channel& channel : clip.channels) {
      hash.add(channel.joint);
      hash.add(channel.path);
      hash.add(channel.interpolation);
      hash.add_array(std::span<const double>(channel.times));
      hash.add_array(std::span<const double>(channel.values));
      hash.add_array(std::span<const char>(channel.straight));
    }
    hash.add(std::uint64_t{clip.weights.size()});
    for (const rig::WeightChannel& channel : clip.weights) {
      hash.add(channel.node);
      hash.add(channel.interpolation);
      hash.add_array(std::span<const double>(channel.times));
      hash.add_array(std::span<const double>(*channel.values));
    }
  }
  return hash.text();
}

}  // namespace

std::uint64_t model_hash(const model::Model& model) {
  Hash hash;
  FieldHash visitor{hash};
  model::visit_fields(model, visitor);
  return hash.value();
}

Identity identity_of(const scene::Scene& scene, std::uint64_t hash, const BakeOptions& options) {
  Identity identity{{"the version of fascicle", base::fascicle_version},
                    {"the solver's version", base::number_text(base::solver_version)},
                    {model_name, base::hash_text(hash)},
                    {"fps", base::number_text(scene.fps)},
                    {"start", base::number_text(scene.start)},
                    {end_name, base::number_text(scene.end)},
                    {"gravity", scene::dump(json_of(scene.gravity))},
                    {"solver.integrator", name_of(scene.solver.integrator)},
                    {"solver.rotation", name_of(scene.solver.rotation)},
                    {"solver.weights", name_of(scene.solver.weights)},
                    {"solver.substeps", base::number_text(substeps_of(scene, options))},
                    {"solver.iterations", base::number_text(iterations_of(scene, options))},
                    {"solver.viscosity", base::number_text(scene.solver.viscosity)},
                    {"clip", scene.clip},
                    {"motion", scene::dump(json_of(scene.motion))},
                    {"forces", scene::dump(json_of(scene.forces))},
                    {"colliders", scene::dump(json_of(scene.colliders))}};
  // Files in different folders may have the same name.
  std::map<std::string, std::uint32_t> named;
  for (const auto& [file, file_hash] : scene.input_hashes) {
    const std::string name = std::filesystem::path(file).filename().string();
    const std::uint32_t number = ++named[name];
    identity.emplace_back(
        "the content of " + name + (number > 1 ? " (" + base::number_text(number) + ")" : ""), file_hash);
  }
  // Another version of fascicle-convert may read the same file differently.
  if (const auto* character = std::get_if<rig::Character>(&scene.geometry);
      character != nullptr && scene::is_converted(scene))
    identity.emplace_back("the converted motion", hash_of_motion(*character));
  for (auto& [key, value] : scene::keys_without_end(scene))
    identity.emplace_back(key_prefix + key, std::move(value));
  std::vector<std::string> formats = options.formats;
  std::sort(formats.begin(), formats.end());
  identity.emplace_back(formats_name, in_one_line(formats));
  if (std::find(formats.begin(), formats.end(), "glb") != formats.end()) {
    identity.emplace_back("--glb-stride", base::number_text(options.glb.stride));
    if (options.glb.error) identity.emplace_back("--glb-error", base::number_text(*options.glb.error));
    if (options.glb.compress)
      identity.emplace_back("--glb-compress", base::number_text(*options.glb.compress));
    identity.emplace_back("--glb-tolerance",
                          options.glb.tolerance ? base::number_text(*options.glb.tolerance) : std::string());
  }
  if (options.usd_skel) identity.emplace_back("--usd-skel", "given");
  if (const std::uint64_t first = number_of_first(scene, options); first != 0)
    identity.emplace_back("--first-frame", base::number_text(first));
  if (scene.contact.unless_torn)
    identity.emplace_back(self_contact_name,
                          options.contact_left_out.empty() ? self_contact_kept : options.contact_left_out);
  identity.emplace_back("device", identity_of(options.device));
  return identity;
}

std::string identity_of(const DeviceDescription& device) {
  return device.exact ? "exact" : device.name + ", " + device.driver;
}

std::optional<std::string> contact_left_out(const Identity& identity) {
  const auto found = std::find_if(identity.begin(), identity.end(),
                                  [](const auto& entry) { return entry.first == self_contact_name; });
  if (found == identity.end()) return std::nullopt;
  return found->second == self_contact_kept ? std::string() : found->second;
}

std::vector<Difference> differences(const Identity& before, const Identity& now) {
  const std::map<std::string, std::string> old(before.begin(), before.end());
  const std::map<std::string, std::string> current(now.begin(), now.end());
  std::vector<Difference> found;
  for (const auto& [name, value] : current) {
    const auto match = old.find(name);
    if (match == old.end())
      found.push_back({name, "absent", value});
    else if (match->second != value)
      found.push_back({name, match->second, value});
  }
  for (const auto& [name, value] : old)
    if (!current.contains(name)) found.push_back({name, value, "absent"});
  return found;
}

namespace {

// The differences that follow from that of a key: if scene.fps differs, fps need not be reported.
std::set<std::string_view> explained_by_keys(const std::vector<Difference>& differences) {
  std::set<std::string_view> others, explained;
  for (const Difference& one : differences)
    if (!one.name.starts_with(key_prefix)) others.insert(one.name);
  const auto explain = [&](std::string_view name) {
    if (others.contains(name)) explained.insert(name);
  };
  for (const Difference& one : differences) {
    if (!one.name.starts_with(key_prefix)) continue;
    explain(model_name);
    const std::string_view key = std::string_view(one.name).substr(std::string_view(key_prefix).size());
    explain(key);
    // The tables that it is in, and its ends. A file may give any text, but no scene's key has more dots.
    constexpr int deepest = 64;
    std::size_t dot = key.find('.');
    for (int depth = 0; dot != std::string_view::npos && depth < deepest; ++depth) {
      explain(key.substr(0, dot));
      explain(key.substr(dot + 1));
      dot = key.find('.', dot + 1);
    }
  }
  return explained;
}

// A list of numbers may be as long as a mesh, and a file may give any text.
std::string shown(const std::string& value, std::size_t longest = 80) {
  if (value.size() <= longest) return base::shown_text(value);
  std::size_t end = longest;
  while (end > 0 && (static_cast<unsigned char>(value[end]) & 0xc0u) == 0x80u) --end;
  return base::shown_text(value.substr(0, end)) + "...";
}
std::string shown_value(const std::string& value) {
  return value.empty() ? "nothing" : shown(value);
}

}  // namespace

std::string text_of(const std::vector<Difference>& differences) {
  constexpr std::size_t longest_name = 200, most = 20;
  const std::set<std::string_view> explained = explained_by_keys(differences);
  std::string text;
  std::size_t count = 0;
  for (const Difference& one : differences)
    if (!explained.contains(one.name) && ++count <= most)
      text += (text.empty() ? "" : "; ") + shown(one.name, longest_name) + " was " + shown_value(one.was) +
              " and is " + shown_value(one.is);
  return count > most ? text + "; and " + base::number_text(std::uint64_t{count - most}) + " more" : text;
}

namespace {

std::vector<std::string> listed_in(const Identity& identity, const char* name) {
  const auto found =
      std::find_if(identity.begin(), identity.end(), [&](const auto& entry) { return entry.first == name; });
  return found == identity.end() ? std::vector<std::string>() : listed(found->second);
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

bool leaves_frames(const Difference& difference, const scene::Scene& scene, std::uint64_t frames_done) {
  if (difference.name == formats_name) {
    const std::vector<std::string> was = listed(difference.was), is = listed(difference.is);
    // Files of a dropped format would stay in the folder, and the bake would no longer list them.
    return std::includes(is.begin(), is.end(), was.begin(), was.end()) &&
           std::all_of(is.begin(), is.end(), [&](const std::string& name) {
             return has(was, name) || formats::format_named(name).from_cache;
           });
  }
  if (difference.name == end_name) {
    const scene::Motion& motion = scene.motion;
    // Muscles find their hinges from the whole motion.
    return frames_done <= scene::frame_count(scene) && scene.muscles.empty() && motion.hold == 0.0 &&
           motion.handles == 0 && motion.loop == 1 && !motion.seamless;
  }
  return difference.name == anew_name || std::find(options_of_files.begin(), options_of_files.end(),
                                                   difference.name) != options_of_files.end();
}

std::vector<std::string> formats_begun_anew(const Identity& before, const Identity& now) {
  const std::vector<std::string> was = listed_in(before, formats_name),
                                 unfinished = listed_in(before, anew_name);
  std::vector<std::string> anew = listed_in(now, formats_name);
  std::erase_if(anew, [&](const std::string& name) {
    const formats::Format& format = formats::format_named(name);
    // Files with one frame each do not depend on the end.
    const bool stays = has(was, name) && !has(unfinished, name) && format.file.ends_with('/');
    return stays || !format.from_cache;
  });
  return anew;
}

Identity while_begun_anew(Identity identity, const std::vector<std::string>& formats) {
  // Even if there is none: files other than those of formats may have to be rewritten.
  identity.emplace_back(anew_name, in_one_line(formats));
  return identity;
}

}  // namespace fascicle::bake
