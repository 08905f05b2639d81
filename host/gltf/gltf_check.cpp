#include "host/gltf/gltf_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "host/gltf/gltf_check_steps.h"

namespace fascicle::gltf {

namespace {
constexpr std::uint64_t deepest_node = 1024;
}

using nlohmann::json;

void GltfCheck::asset() {
  const GltfPlace place = object({&file_.document, ""}, "asset");
  const auto version = optional_text(place, "version");
  if (!version) fail("/asset/version", "is missing");
  if (version->rfind("2.", 0) != 0)
    fail("/asset/version", "`" + version->substr(0, 20) + "`; only glTF 2 is read");
  const auto minimum = optional_text(place, "minVersion");
  if (minimum && *minimum != "2.0")
    fail("/asset/minVersion", "`" + minimum->substr(0, 20) + "`; only glTF 2.0 is read");
  out_["asset"] = {{"version", "2.0"}};
}

// Rejects required extensions, except those that change only the look of a surface, add only metadata, or are
// supported here.
void GltfCheck::extensions() {
  static constexpr std::array<const char*, 20> harmless{"KHR_materials_",
                                                        "KHR_texture_",
                                                        "EXT_texture_",
                                                        "MSFT_texture_",
                                                        "MSFT_packing_",
                                                        "ADOBE_materials_",
                                                        "KHR_lights_",
                                                        "EXT_lights_",
                                                        "KHR_mesh_quantization",
                                                        "KHR_animation_",
                                                        "KHR_xmp",
                                                        "KHR_audio",
                                                        "VRM",
                                                        "EXT_mesh_features",
                                                        "EXT_structural_metadata",
                                                        "EXT_feature_metadata",
                                                        "KHR_draco_mesh_compression",
                                                        "EXT_meshopt_compression",
                                                        "KHR_meshopt_compression",
                                                        "AGI_"};
  for (const GltfPlace& place : elements({&file_.document, ""}, "extensionsRequired")) {
    if (!place.value->is_string()) fail(place.pointer, "must be a string");
    const auto name = place.value->get<std::string>();
    const bool is_harmless = std::any_of(harmless.begin(), harmless.end(),
                                         [&](const char* prefix) { return name.rfind(prefix, 0) == 0; });
    if (!is_harmless) {
      fail(place.pointer, "the file needs the extension `" + name.substr(0, 60) +
                              "`, which may change its meshes and is not read; export without it");
    }
  }
}

void GltfCheck::meshes() {
  out_["meshes"] = json::array();
  for (const GltfPlace& place : objects({&file_.document, ""}, "meshes")) {
    json primitives = json::array();
    for (const GltfPlace& primitive : objects(place, "primitives")) {
      json result{{"mode", optional_whole(primitive, "mode").value_or(4)}};
      if (result["mode"].get<std::uint64_t>() > 6) fail(primitive.pointer + "/mode", "must be 0 to 6");
      if (const auto indices = optional_index(primitive, "indices", "accessors")) {
        if (!accessors_[*indices].has_view)
          fail(primitive.pointer + "/indices", "its accessor has no buffer view");
        result["indices"] = *indices;
      }
      const GltfPlace attributes = object(primitive, "attributes");
      result["attributes"] = json::object();
      for (const auto& [name, value] : attributes.value->items()) {
        const bool is_needed = name == "POSITION" || name.starts_with("JOINTS_") ||
                               name.starts_with("WEIGHTS_") || name.starts_with("COLOR_") ||
                               name.starts_with("_");
        if (is_needed)
          result["attributes"][name] = index(value, attributes.pointer + "/" + name, "accessors");
      }
      json targets = morph_targets(primitive, attributes);
      const std::size_t number = targets.size();
      if (primitives.empty()) {
        targets_.push_back(number);
      } else if (number != targets_.back()) {
        fail(primitive.pointer + "/targets", std::to_string(number) +
                                                 " targets, and the mesh's first primitive has " +
                                                 std::to_string(targets_.back()));
      }
      if (number > 0) result["targets"] = std::move(targets);
      primitives.push_back(std::move(result));
    }
    if (primitives.empty()) fail(place.pointer + "/primitives", "must have at least one");
    out_["meshes"].push_back({{"primitives", std::move(primitives)}});
    morph_weights(place, targets_.back());
  }
}

json GltfCheck::morph_targets(const GltfPlace& primitive, const GltfPlace& attributes) const {
  json result = json::array();
  for (const GltfPlace& target : objects(primitive, "targets")) {
    json kept = json::object();
    if (const auto position = optional_index(target, "POSITION", "accessors")) {
      const Accessor& accessor = accessors_[*position];
      const std::string pointer = target.pointer + "/POSITION";
      if (accessor.type != "VEC3" || accessor.component == 5125)
        fail(pointer, "its accessor must be VEC3 of floats or of short integers");
      const json* base = member(attributes, "POSITION");
      if (base != nullptr && base->is_number_unsigned() &&
          accessor.count != accessors_[base->get<std::size_t>()].count) {
        fail(pointer, std::to_string(accessor.count) + " elements for " +
                          std::to_string(accessors_[base->get<std::size_t>()].count) + " positions");
      }
      kept["POSITION"] = *position;
    }
    result.push_back(std::move(kept));
  }
  return result;
}

// `owner`: a mesh, or a node with one.
void GltfCheck::morph_weights(const GltfPlace& owner, std::size_t targets) const {
  const std::vector<GltfPlace> values = elements(owner, "weights");
  for (const GltfPlace& value : values)
    if (!value.value->is_number() || !std::isfinite(value.value->get<double>()))
      fail(value.pointer, "must be a number");
  if (!values.empty() && targets > 0 && values.size() != targets)
    fail(owner.pointer + "/weights",
         std::to_string(values.size()) + " weights for " + std::to_string(targets) + " targets");
}

void GltfCheck::skins() {
  out_["skins"] = json::array();
  for (const GltfPlace& place : objects({&file_.document, ""}, "skins")) {
    json joints = json::array();
    std::set<std::size_t> seen;
    for (const GltfPlace& joint : elements(place, "joints")) {
      const std::size_t number = index(*joint.value, joint.pointer, "nodes");
      if (!seen.insert(number).second)
        fail(joint.pointer, "names node " + std::to_string(number) + " a second time");
      joints.push_back(number);
    }
    if (joints.empty()) fail(place.pointer + "/joints", "a skin needs at least one joint");
    json skin{{"joints", std::move(joints)}};
    if (const auto matrices = optional_index(place, "inverseBindMatrices", "accessors")) {
      const Accessor& accessor = accessors_[*matrices];
      const std::string pointer = place.pointer + "/inverseBindMatrices";
      if (accessor.type != "MAT4" || accessor.component != 5126)
        fail(pointer, "its accessor must be MAT4 of floats (5126)");
      if (accessor.count < seen.size()) {
        fail(pointer,
             std::to_string(accessor.count) + " matrices for " + std::to_string(seen.size()) + " joints");
      }
      skin["inverseBindMatrices"] = *matrices;
    }
    out_["skins"].push_back(std::move(skin));
  }
}

json GltfCheck::node(const GltfPlace& place) {
  json result = json::object();
  if (const auto name = optional_text(place, "name")) result["name"] = *name;
  if (const auto mesh = optional_index(place, "mesh", "meshes")) {
    result["mesh"] = *mesh;
    morph_weights(place, targets_[*mesh]);
  }
  if (const auto skin = optional_index(place, "skin", "skins")) result["skin"] = *skin;
  json children = json::array();
  for (const GltfPlace& child : elements(place, "children"))
    children.push_back(index(*child.value, child.pointer, "nodes"));
  if (!children.empty()) result["children"] = std::move(children);
  const auto numbers = [&](const char* key, std::size_t count) {
    if (member(place, key) == nullptr) return false;
    const std::vector<GltfPlace> values = elements(place, key);
    if (values.size() != count)
      fail(place.pointer + "/" + key, "must have " + std::to_string(count) + " numbers");
    json array = json::array();
    for (const GltfPlace& value : values) {
      if (!value.value->is_number()) fail(value.pointer, "must be a number");
      array.push_back(value.value->get<double>());
    }
    result[key] = std::move(array);
    return true;
  };
  has_matrix_.push_back(numbers("matrix", 16));
  if (has_matrix_.back()) {
    const json& m = result["matrix"];
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
      fail(place.pointer + "/matrix", "its last row must be 0 0 0 1");
    }
    return result;
  }
  numbers("translation", 3);
  numbers("scale", 3);
  if (numbers("rotation", 4)) {
    double square = 0.0;
    for (const json& value : result["rotation"]) square += value.get<double>() * value.get<double>();
    // A quaternion written by hand may be slightly off unit length; far off, it is not a rotation.
    if (!(square > 0.25 && square < 4.0))
      fail(place.pointer + "/rotation", "must be a quaternion of length 1");
  }
  return result;
}

// Every node has at most one parent, so a node that cannot be reached from a root lies on a cycle.
void GltfCheck::forest(const std::vector<GltfPlace>& places) const {
  const json& nodes = out_.at("nodes");
  constexpr std::size_t nothing = ~std::size_t{0};
  std::vector<std::size_t> parent(places.size(), nothing);
  static const json no_children = json::array();
  const auto children = [&](std::size_t i) -> const json& {
    const auto found = nodes[i].find("children");
    return found == nodes[i].end() ? no_children : *found;
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    std::size_t c = 0;
    for (const json& child : children(i)) {
      const auto number = child.get<std::size_t>();
      if (parent[number] != nothing || number == i) {
        fail(places[i].pointer + "/children/" + std::to_string(c),
             "node " + std::to_string(number) + " is " +
                 (number == i ? "its own child"
                              : "already a child of node " + std::to_string(parent[number])));
      }
      parent[number] = i;
      ++c;
    }
  }
  std::vector<std::uint64_t> depth(places.size(), 0);
  std::vector<std::size_t> stack;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (parent[i] == nothing) {
      depth[i] = 1;
      stack.push_back(i);
    }
  }
  while (!stack.empty()) {
    const std::size_t i = stack.back();
    stack.pop_back();
    if (depth[i] > deepest_node) {
      fail(places[i].pointer, "lies deeper than " + std::to_string(deepest_node) + " nodes");
    }
    for (const json& child : children(i)) {
      depth[child.get<std::size_t>()] = depth[i] + 1;
      stack.push_back(child.get<std::size_t>());
    }
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (depth[i] == 0)
      fail(places[i].pointer + "/children", "node " + std::to_string(i) + " is below itself");
  }
}

void GltfCheck::nodes() {
  out_["nodes"] = json::array();
  const std::vector<GltfPlace> places = objects({&file_.document, ""}, "nodes");
  for (const GltfPlace& place : places) out_["nodes"].push_back(node(place));
  forest(places);
}

void GltfCheck::scenes() {
  const GltfPlace top{&file_.document, ""};
  out_["scenes"] = json::array();
  for (const GltfPlace& place : objects(top, "scenes")) {
    json roots = json::array();
    for (const GltfPlace& root : elements(place, "nodes"))
      roots.push_back(index(*root.value, root.pointer, "nodes"));
    out_["scenes"].push_back({{"nodes", std::move(roots)}});
  }
  if (const auto scene = optional_index(top, "scene", "scenes")) out_["scene"] = *scene;
}

// Number of morph targets of the node's mesh.
std::size_t GltfCheck::shapes_of(std::size_t node) const {
  const json& checked = out_.at("nodes")[node];
  const auto mesh = checked.find("mesh");
  return mesh == checked.end() ? 0 : targets_[mesh->get<std::size_t>()];
}

json GltfCheck::animation(const GltfPlace& place) {
  struct Sampler {
    std::size_t input, output;
    bool is_spline;
  };
  std::vector<Sampler> samplers;
  json result{{"samplers", json::array()}, {"channels", json::array()}};
  if (const auto name = optional_text(place, "name")) result["name"] = *name;
  for (const GltfPlace& sampler : objects(place, "samplers")) {
    const std::size_t input = required_index(sampler, "input", "accessors");
    const std::size_t output = required_index(sampler, "output", "accessors");
    const std::string interpolation = optional_text(sampler, "interpolation").value_or("LINEAR");
    if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE") {
      fail(sampler.pointer + "/interpolation",
           "`" + interpolation.substr(0, 20) + "`; must be LINEAR, STEP or CUBICSPLINE");
    }
    if (accessors_[input].type != "SCALAR" || accessors_[input].component != 5126) {
      fail(sampler.pointer + "/input", "its accessor must be SCALAR of floats (5126)");
    }
    samplers.push_back({input, output, interpolation == "CUBICSPLINE"});
    result["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
  }
  std::set<std::pair<std::size_t, std::string>> seen;
  for (const GltfPlace& channel : objects(place, "channels")) {
    const json* number = member(channel, "sampler");
    if (number == nullptr) fail(channel.pointer + "/sampler", "is missing");
    const std::uint64_t s = whole(*number, channel.pointer + "/sampler", gltf_largest_number);
    if (s >= samplers.size()) {
      fail(channel.pointer + "/sampler",
           "names sampler " + std::to_string(s) + " of " + std::to_string(samplers.size()));
    }
    const GltfPlace target = object(channel, "target");
    const auto path = optional_text(target, "path");
    if (!path) fail(target.pointer + "/path", "is missing");
    const auto node = optional_index(target, "node", "nodes");
    // Channels added by extensions move no joint.
    if (!node || *path == "pointer") continue;
    const bool is_weights = *path == "weights";
    if (is_weights && shapes_of(*node) == 0) continue;
    if (!is_weights && *path != "translation" && *path != "rotation" && *path != "scale") {
      fail(target.pointer + "/path",
           "`" + path->substr(0, 20) + "`; must be translation, rotation, scale or weights");
    }
    if (!is_weights && has_matrix_[*node]) {
      fail(target.pointer + "/node",
           "node " + std::to_string(*node) + " is given as a matrix and cannot be animated");
    }
    if (!seen.emplace(*node, *path).second) {
      fail(target.pointer, "the " + *path + " of node " + std::to_string(*node) + " is animated twice");
    }
    const Sampler& sampler = samplers[static_cast<std::size_t>(s)];
    const Accessor& output = accessors_[sampler.output];
    const std::string type = is_weights ? "SCALAR" : *path == "rotation" ? "VEC4" : "VEC3";
    const std::string pointer = place.pointer + "/samplers/" + std::to_string(s) + "/output";
    if (output.type != type) fail(pointer, "its accessor must be " + type + " for a " + *path);
    const std::uint64_t shapes = is_weights ? shapes_of(*node) : 1;
    const std::uint64_t wanted = accessors_[sampler.input].count * (sampler.is_spline ? 3 : 1) * shapes;
    if (output.count != wanted) {
      fail(pointer, std::to_string(output.count) + " values where the keys need " + std::to_string(wanted));
    }
    result["channels"].push_back({{"sampler", s}, {"target", {{"node", *node}, {"path", *path}}}});
  }
  return result;
}

void GltfCheck::animations() {
  out_["animations"] = json::array();
  for (const GltfPlace& place : objects({&file_.document, ""}, "animations"))
    out_["animations"].push_back(animation(place));
}

CheckedGltf check_gltf(GltfFile file) {
  return GltfCheck(std::move(file)).run();
}

}  // namespace fascicle::gltf
