#include "host/convert/gltf.h"

#include <algorithm>
#include <cmath>
#include <string_view>

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
  // The scene's nodes come first and keep their numbers; nodes that only place meshes follow.
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
  if (!has_mesh) throw Failure(unreadable, "contains no polygon mesh");
}

// glTF times are single precision and strictly increasing.
struct Times {
  std::vector<float> seconds;
  std::vector<std::size_t> key;  // index in the track
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

struct Moved {
  std::size_t node = 0;
  const char* path = "";
  int width = 0;  // numbers per output row
  std::vector<float> times, values;
};

// Nodes of the skeleton: joints of skins and their ancestors; without skins, all nodes.
std::vector<bool> skeleton_of(const Character& character, const json& document) {
  const json skins = document.value("skins", json::array());
  std::vector<bool> result(character.nodes.size(), skins.empty());
  for (const json& skin : skins)
    for (const std::size_t joint : skin["joints"]) {
      if (joint >= result.size()) continue;  // stands in for another joint of the skin
      for (int n = static_cast<int>(joint); n >= 0; n = character.nodes[static_cast<std::size_t>(n)].parent)
        result[static_cast<std::size_t>(n)] = true;
    }
  return result;
}

// A clip lasts until its last key, even if the track with that key is constant and left out. The track that
// ends last is held until then; if there is none, a joint is held at rest.
void last_until(float end, const Character& character, const json& document, std::vector<Moved>& moved) {
  const std::vector<bool> in_skeleton = skeleton_of(character, document);
  Moved* last = nullptr;
  for (Moved& each : moved) {
    const bool is_weights = std::string_view(each.path) == "weights";
    if ((is_weights || in_skeleton[each.node]) && each.times.back() >= end) return;
    if (!is_weights && in_skeleton[each.node] && (last == nullptr || each.times.back() > last->times.back()))
      last = &each;
  }
  if (last != nullptr) {
    const std::vector<float> held(last->values.end() - last->width, last->values.end());
    last->times.push_back(end);
    last->values.insert(last->values.end(), held.begin(), held.end());
  } else if (document.contains("skins") && end > 0.0f) {
    const std::size_t joint = document["skins"][0]["joints"][0];
    const Eigen::Vector4f rest = parts_of(character.nodes[joint].local).rotation.coeffs().cast<float>();
    Moved still{.node = joint, .path = "rotation", .width = 4, .times = {0.0f, end}, .values = {}};
    for (int k = 0; k < 2; ++k) still.values.insert(still.values.end(), rest.begin(), rest.end());
    moved.push_back(std::move(still));
  }
}

void write_clip(const std::string& name, const std::vector<Moved>& moved, Document& document) {
  json samplers = json::array(), channels = json::array();
  const std::vector<float>* last_times = nullptr;
  std::size_t input = 0;
  for (const Moved& each : moved) {
    // Consecutive tracks with equal times share one accessor.
    if (last_times == nullptr || each.times != *last_times)
      input = add_accessor(document, std::span<const float>(each.times), 1, true);
    last_times = &each.times;
    samplers.push_back({{"input", input},
                        {"output", add_accessor(document, std::span<const float>(each.values), each.width)},
                        {"interpolation", "LINEAR"}});
    channels.push_back(
        {{"sampler", samplers.size() - 1}, {"target", {{"node", each.node}, {"path", each.path}}}});
  }
  if (!channels.empty())
    document.json["animations"].push_back({{"name", name}, {"samplers", samplers}, {"channels", channels}});
}

// Single-precision rounding: of a rotation, or relative to the size of the vector.
constexpr double rounding = 1e-6;

bool is_same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm() <= rounding * std::max(a.norm(), b.norm());
}
bool is_same(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return std::min((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm()) <= rounding;
}

// Assimp writes all three components for a node that moves in one, and for nodes that are keyed without
// moving. Components that stay at rest are left out, so that a node that does not move has no channel.
template <typename Value>
void add_part(const Track& track, const Times& times, const Value& rest, Value Parts::*part, const char* path,
              std::vector<Moved>& moved) {
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
  constexpr int width = std::is_same_v<Value, Eigen::Quaterniond> ? 4 : 3;
  moved.push_back({track.node, path, width, times.seconds, std::move(values)});
}

void add_clip(const Character& character, const Clip& clip, Document& document) {
  std::vector<Moved> moved;
  float end = 0.0f;
  for (const Track& track : clip.tracks) {
    const Times times = times_of(track.times);
    if (!times.key.empty()) end = std::max(end, times.seconds.back());
    const Parts rest = parts_of(character.nodes[track.node].local);
    add_part(track, times, rest.translation, &Parts::translation, "translation", moved);
    add_part(track, times, rest.rotation, &Parts::rotation, "rotation", moved);
    add_part(track, times, rest.scale, &Parts::scale, "scale", moved);
  }
  for (const ShapeTrack& track : clip.shapes) {
    if (!document.json["nodes"][track.node].contains("mesh")) continue;
    const Times times = times_of(track.times);
    if (times.key.empty()) continue;
    end = std::max(end, times.seconds.back());
    std::vector<float> values;
    for (const std::size_t k : times.key)
      for (const double weight : track.weights[k]) values.push_back(static_cast<float>(weight));
    moved.push_back({track.node, "weights", 1, times.seconds, std::move(values)});
  }
  last_until(end, character, document.json, moved);
  write_clip(clip.name, moved, document);
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
