#include "host/bake/identity.h"

#include <algorithm>
#include <map>
#include <memory>
#include <new>
#include <span>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "host/base/text.h"
#include "host/base/version.h"
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

std::string text_hash(const std::string& text) {
  return base::hash_text(XXH3_64bits(text.data(), text.size()));
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
                    {"end", base::number_text(scene.end)},
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
  identity.emplace_back("the scene's text (hash)", text_hash(scene.text));
  std::vector<std::string> formats = options.formats;
  std::sort(formats.begin(), formats.end());
  std::string list;
  for (const std::string& format : formats) list += (list.empty() ? "" : ",") + format;
  identity.emplace_back("--format", list);
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
  identity.emplace_back("device",
                        options.device.exact ? "exact" : options.device.name + ", " + options.device.driver);
  return identity;
}

std::string differences(const Identity& before, const Identity& now) {
  const std::map<std::string, std::string> old(before.begin(), before.end());
  const std::map<std::string, std::string> current(now.begin(), now.end());
  const auto quoted = [](const std::string& value) { return value.empty() ? std::string("nothing") : value; };
  std::string text;
  const auto say = [&](const std::string& name, const std::string& was, const std::string& is) {
    text += (text.empty() ? "" : "; ") + name + " was " + was + " and is " + is;
  };
  for (const auto& [name, value] : current) {
    const auto match = old.find(name);
    if (match == old.end())
      say(name, "absent", quoted(value));
    else if (match->second != value)
      say(name, quoted(match->second), quoted(value));
  }
  for (const auto& [name, value] : old)
    if (!current.contains(name)) say(name, quoted(value), "absent");
  return text;
}

}  // namespace fascicle::bake
