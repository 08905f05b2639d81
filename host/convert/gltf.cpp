#include "host/convert/gltf.h"

#include <algorithm>
#include <cmath>

#include "host/convert/document.h"
#include "host/convert/failure.h"
#include "host/convert/looks.h"
#include "host/convert/meshes.h"

namespace fascicle::convert {
namespace {

using nlohmann::json;

std::vector<double> numbers(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json node_of(const Node& node) {
  const Parts parts = parts_of(node.local);
  const Eigen::Vector4d q = parts.rotation.coeffs();
  return {{"name", node.name.empty() ? "metres" : node.name},
          {"translation", numbers(parts.translation)},
          {"rotation", {q.x(), q.y(), q.z(), q.w()}},
          {"scale", numbers(parts.scale)}};
}

void add_nodes(Character& character, Document& document) {
  json& nodes = document.json["nodes"];
  json tops = json::array();
  // Nodes of the scene come first and keep their numbers; those that place meshes come after.
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    nodes.push_back(node_of(character.nodes[n]));
    const int parent = character.nodes[n].parent;
    (parent < 0 ? tops : nodes[static_cast<std::size_t>(parent)]["children"]).push_back(n);
  }
  document.json["scene"] = 0;
  document.json["scenes"] = json::array({{{"nodes", tops}}});
  bool has_mesh = false;
  for (std::size_t n = 0; n < character.nodes.size(); ++n) {
    if (character.nodes[n].meshes.empty()) continue;
    const std::optional<PlacedMesh> placed = add_mesh(character, n, document);
    if (!placed) continue;
    has_mesh = true;
    std::size_t at = n;
    if (!placed->skin && !character.nodes[n].geometry.isIdentity(0.0)) {
      Node inner;
      inner.name = character.nodes[n].name + " geometry";
      inner.local = character.nodes[n].geometry;
      at = nodes.size();
      nodes.push_back(node_of(inner));
      nodes[n]["children"].push_back(at);
    }
    nodes[at]["mesh"] = placed->mesh;
    if (placed->skin) nodes[at]["skin"] = *placed->skin;
  }
  if (!has_mesh) throw Failure(unreadable, "holds no mesh of polygons");
}

// glTF's times are single and rise.
struct Times {
  std::vector<float> seconds;
  std::vector<std::size_t> key;  // of the track
};

Times times_of(const std::vector<double>& times) {
  Times result;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto seconds = static_cast<float>(times[k]);
    if (!(seconds >= 0.0f) || (!result.seconds.empty() && seconds <= result.seconds.back())) continue;
    result.seconds.push_back(seconds);
    result.key.push_back(k);
  }
  return result;
}

class Animation {
 public:
  Animation(Document& document, const std::string& name) : document_(document), name_(name) {}

  void add(const Times& times, const std::vector<float>& values, int width, std::size_t node,
           const char* path) {
    // Times that tracks share are written once.
    if (times.seconds != last_times_) {
      last_times_ = times.seconds;
      input_ = add_accessor(document_, std::span<const float>(times.seconds), 1, true);
    }
    samplers_.push_back({{"input", input_},
                         {"output", add_accessor(document_, std::span<const float>(values), width)},
                         {"interpolation", "LINEAR"}});
    channels_.push_back({{"sampler", samplers_.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  void finish() {
    if (!channels_.empty())
      document_.json["animations"].push_back(
          {{"name", name_}, {"samplers", samplers_}, {"channels", channels_}});
  }

 private:
  Document& document_;
  std::string name_;
  std::vector<float> last_times_;
  std::size_t input_ = 0;
  json samplers_ = json::array(), channels_ = json::array();
};

// Rounding of single precision, of a rotation or relative to the size of what it is about.
constexpr double rounding = 1e-6;

bool is_same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm() <= rounding * std::max(a.norm(), b.norm());
}
bool is_same(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm()) <= rounding;
}

// Assimp gives all three of a node that moves in one, and of nodes that a file keys without moving them. What
// stays where the node rests is left out, and so such a node is none that a clip moves.
template <typename Value>
void add_part(const Track& track, const Times& times, const Value& rest, Value Parts::*part, const char* path,
              Animation& animation) {
  bool is_at_rest = true;
  std::vector<float> values;
  for (const std::size_t k : times.key) {
    const Value& value = track.values[k].*part;
    is_at_rest = is_at_rest && is_same(value, rest);
    if constexpr (std::is_same_v<Value, Eigen::Quaterniond>) {
      for (int c = 0; c < 4; ++c) values.push_back(static_cast<float>(value.coeffs()[c]));
    } else {
      for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(value[c]));
    }
  }
  if (is_at_rest || times.key.empty()) return;
  animation.add(times, values, std::is_same_v<Value, Eigen::Quaterniond> ? 4 : 3, track.node, path);
}

void add_clip(const Character& character, const Clip& clip, Document& document) {
  Animation animation(document, clip.name);
  for (const Track& track : clip.tracks) {
    const Times times = times_of(track.times);
    const Parts rest = parts_of(character.nodes[track.node].local);
    add_part(track, times, rest.translation, &Parts::translation, "translation", animation);
    add_part(track, times, rest.rotation, &Parts::rotation, "rotation", animation);
    add_part(track, times, rest.scale, &Parts::scale, "scale", animation);
  }
  for (const ShapeTrack& track : clip.shapes) {
    if (!document.json["nodes"][track.node].contains("mesh")) continue;
    const Times times = times_of(track.times);
    std::vector<float> values;
    for (const std::size_t k : times.key)
      for (const double weight : track.weights[k]) values.push_back(static_cast<float>(weight));
    if (!times.key.empty()) animation.add(times, values, 1, track.node, "weights");
  }
  animation.finish();
}

}  // namespace

std::string glb_of(Character& character, const std::filesystem::path& source) {
  Document document;
  add_materials(*character.scene, source, document, character.notes);
  add_nodes(character, document);
  for (const Clip& clip : character.clips) add_clip(character, clip, document);
  document.json["asset"] = {{"version", "2.0"},
                            {"generator", "fascicle-convert " FASCICLE_VERSION},
                            {"extras", {{"notes", character.notes}}}};
  return glb_text(std::move(document));
}

}  // namespace fascicle::convert
