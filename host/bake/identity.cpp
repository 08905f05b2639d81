#include "host/bake/identity.h"

#include <algorithm>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <sstream>
#include <string_view>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/formats.h"
#include "host/model/model_arrays.h"
#include "host/scene/scene_json.h"

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
  // The length goes in too: else an element could move from one array to the next unseen.
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
    // The name goes in too: else one such array would hash like another.
    if (!list.empty()) hash.add(std::string(name));
    if (!list.empty()) hash.add(list);
  }
  template <class T>
  void count(const char*, const std::vector<T>& list) {
    hash.add(std::uint64_t{list.size()});
  }
  Hash& hash;
};

// Of what the scene says in all its keys but where it ends, which has an entry of its own.
std::string keys_hash(const scene::Scene& scene) {
  std::string keys = scene::documented_text(scene);
  constexpr std::string_view end = "\nend = ";
  const std::size_t table = keys.find("\n[scene]\n");
  const std::size_t at = table == std::string::npos ? table : keys.find(end, table);
  // Of a later table it would be a force's.
  if (at != std::string::npos && at < keys.find("\n[", table + 1))
    keys.replace(at + 1, keys.find('\n', at + 1) - at - 1, "#end");
  return base::hash_text(XXH3_64bits(keys.data(), keys.size()));
}

constexpr const char *formats_name = "--format", *end_name = "end", *first_frame_name = "--first-frame";

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
                    {"model", base::hash_text(hash)},
                    {"fps", base::number_text(scene.fps)},
                    {"start", base::number_text(scene.start)},
                    {end_name, base::number_text(scene.end)},
                    {"gravity", scene::dump(json_of(scene.gravity))},
                    {"solver.integrator", name_of(scene.solver.integrator)},
                    {"solver.rotation", name_of(scene.solver.rotation)},
                    {"solver.weights", name_of(scene.solver.weights)},
                    {"solver.substeps", base::number_text(substeps_of(scene, options))},
                    {"solver.iterations", base::number_text(iterations_of(scene, options))},
                    {"clip", scene.clip},
                    {"motion", scene::dump(json_of(scene.motion))},
                    {"forces", scene::dump(json_of(scene.forces))},
                    {"colliders", scene::dump(json_of(scene.colliders))}};
  // Files of several folders may have one name.
  std::map<std::string, std::uint32_t> named;
  for (const auto& [file, file_hash] : scene.input_hashes) {
    const std::string name = std::filesystem::path(file).filename().string();
    const std::uint32_t number = ++named[name];
    identity.emplace_back(
        "the content of " + name + (number > 1 ? " (" + base::number_text(number) + ")" : ""), file_hash);
  }
  identity.emplace_back("the scene's keys (hash)", keys_hash(scene));
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
    identity.emplace_back(first_frame_name, base::number_text(first));
  identity.emplace_back("device",
                        options.device.exact ? "exact" : options.device.name + ", " + options.device.driver);
  return identity;
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

std::string text_of(const std::vector<Difference>& differences) {
  const auto quoted = [](const std::string& value) { return value.empty() ? std::string("nothing") : value; };
  std::string text;
  for (const Difference& one : differences)
    text += (text.empty() ? "" : "; ") + one.name + " was " + quoted(one.was) + " and is " + quoted(one.is);
  return text;
}

bool leaves_frames(const Difference& difference, const scene::Scene& scene, std::uint64_t frames_done) {
  if (difference.name == formats_name) {
    const std::vector<std::string> was = listed(difference.was), is = listed(difference.is);
    // What is left out would stay in the folder, of a bake that no longer lists it.
    return std::includes(is.begin(), is.end(), was.begin(), was.end()) &&
           std::all_of(is.begin(), is.end(), [&](const std::string& name) {
             return formats::format_named(name).from_cache ||
                    std::binary_search(was.begin(), was.end(), name);
           });
  }
  if (difference.name == end_name) {
    const scene::Motion& motion = scene.motion;
    return frames_done <= scene::frame_count(scene) && motion.hold == 0.0 && motion.handles == 0 &&
           motion.loop == 1 && !motion.seamless;
  }
  // Files of frames have their numbers in their names.
  return difference.name.starts_with("--") && difference.name != first_frame_name;
}

Identity without_files(Identity identity) {
  for (auto& [name, value] : identity) {
    if (name != formats_name) continue;
    std::vector<std::string> kept = listed(value);
    std::erase_if(kept, [](const std::string& format) { return formats::format_named(format).from_cache; });
    value = in_one_line(kept);
  }
  return identity;
}

}  // namespace fascicle::bake
