#include "host/formats/character_file.h"

#include <algorithm>
#include <array>
#include <set>

#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/formats/gltf_writer.h"
#include "host/formats/joined_document.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/gltf/gltf_material.h"
#include "host/rig/blend_shapes.h"
#include "host/rig/pose.h"
#include "host/rig/rig_math.h"
#include "host/scene/input_files.h"

namespace fascicle::formats {

using nlohmann::json;

namespace {

json asset() {
  return {{"version", "2.0"}, {"generator", std::string("fascicle ") + base::fascicle_version}};
}

gltf::GltfDocument empty_document() {
  return {.json = {{"asset", asset()},
                   {"scene", 0},
                   {"scenes", json::array({{{"nodes", json::array({0})}}})},
                   {"nodes", json::array()},
                   {"meshes", json::array()},
                   {"accessors", json::array()},
                   {"bufferViews", json::array()}},
          .binary = {}};
}

// The render mesh at rest, as a primitive.
json primitive_of(const model::Model& model, gltf::GltfDocument& document) {
  const std::vector<float> rest = embed(model, model.rest);
  const std::vector<float> points = world_positions(rest, model.unit, model.rest_origin);
  const std::size_t position = add_accessor(document, std::span<const float>(points), 3, true);
  const std::vector<float> normals = SurfaceNormals(model).of(rest);
  const std::size_t normal = add_accessor(document, std::span<const float>(normals), 3);
  const std::size_t indices = add_accessor(document, std::span<const std::uint32_t>(model.surface_triangle));
  return {{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", indices}};
}

std::vector<double> numbers(const Eigen::Matrix4d& m) {
  return {m.data(), m.data() + 16};  // both are column-major
}

// One of several characters' skins, as a primitive: the vertices of the model's surface from `first` on.
json primitive_of(const rig::Character& character, const model::Model& model, std::size_t first,
                  gltf::GltfDocument& document) {
  std::vector<float> points;
  for (const scene::Vector3d& p : character.surface.vertices)
    for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(p[axis]));
  const std::vector<float> normals = SurfaceNormals(model).of(embed(model, model.rest));
  std::vector<std::uint32_t> triangles;
  for (const auto& t : character.surface.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  const std::size_t position = add_accessor(document, std::span<const float>(points), 3, true);
  const std::size_t normal =
      add_accessor(document, std::span<const float>(normals).subspan(3 * first, points.size()), 3);
  const std::size_t indices = add_accessor(document, std::span<const std::uint32_t>(triangles));
  return {{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", indices}};
}

// A document for a character without a file, in metres; `make_primitive` returns its skin without weights.
template <class MakePrimitive>
gltf::GltfDocument made_document(const rig::Character& character, const MakePrimitive& make_primitive) {
  gltf::GltfDocument document = empty_document();
  json primitive = make_primitive(document);
  const std::size_t vertices = character.weights.size();
  for (std::size_t set = 0; set < 2; ++set) {
    std::vector<std::uint16_t> joints;
    std::vector<float> weights;
    for (std::size_t i = 0; i < vertices; ++i) {
      // glTF wants the float weights to sum to 1, so the largest takes the rounding error.
      double rest = 1.0;
      const auto largest = static_cast<std::size_t>(
          std::max_element(character.weights[i].begin(), character.weights[i].end()) -
          character.weights[i].begin());
      for (std::size_t k = 0; k < 8; ++k)
        if (k != largest) rest -= double{static_cast<float>(character.weights[i][k])};
      for (std::size_t k = 4 * set; k < 4 * set + 4; ++k) {
        joints.push_back(
            static_cast<std::uint16_t>(character.weights[i][k] > 0.0 ? character.joints[i][k] : 0));
        weights.push_back(static_cast<float>(k == largest ? rest : character.weights[i][k]));
      }
    }
    if (set == 1 && std::all_of(weights.begin(), weights.end(), [](float w) { return w == 0.0f; })) break;
    const std::string suffix = '_' + std::to_string(set);
    primitive["attributes"]["JOINTS" + suffix] =
        add_accessor(document, std::span<const std::uint16_t>(joints), 4);
    primitive["attributes"]["WEIGHTS" + suffix] = add_accessor(document, std::span<const float>(weights), 4);
  }
  document.json["meshes"].push_back({{"name", "body"}, {"primitives", json::array({primitive})}});

  // Node 0 is the root, joint j is node j + 1, the mesh is last.
  json& nodes = document.json["nodes"];
  nodes.push_back({{"name", "character"}, {"children", json::array()}});
  if (!character.root.isIdentity(0.0)) nodes[0]["matrix"] = numbers(character.root);
  json joint_nodes = json::array();
  std::vector<float> inverse_bind;
  for (const rig::Joint& joint : character.skeleton) {
    joint_nodes.push_back(nodes.size());
    const std::size_t parent = joint.parent < 0 ? 0 : static_cast<std::size_t>(joint.parent) + 1;
    if (!nodes[parent].contains("children")) nodes[parent]["children"] = json::array();
    nodes[parent]["children"].push_back(nodes.size());
    const auto list = [](const auto& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
    nodes.push_back({{"name", joint.name},
                     {"translation", list(joint.rest_translation)},
                     {"rotation", list(joint.rest_rotation)},
                     {"scale", list(joint.rest_scale)}});
    for (const double value : numbers(joint.inverse_bind)) inverse_bind.push_back(static_cast<float>(value));
  }
  nodes.push_back({{"name", "body"}, {"mesh", 0}, {"skin", 0}});
  document.json["scenes"][0]["nodes"].push_back(nodes.size() - 1);
  document.json["skins"] = json::array(
      {{{"joints", joint_nodes},
        {"inverseBindMatrices", add_accessor(document, std::span<const float>(inverse_bind), 16)}}});
  return document;
}

constexpr const char* baked_mark = "fascicle_baked";

// The values of one channel, frame by frame.
struct Track {
  std::uint32_t joint = 0;
  rig::ChannelPath path = rig::ChannelPath::translation;
  std::vector<float> values;

  void append(const rig::JointParts& parts) {
    if (path != rig::ChannelPath::rotation) {
      const scene::Vector3d& value = path == rig::ChannelPath::scale ? parts.scale : parts.translation;
      for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(value[c]));
      return;
    }
    // Of the two quaternions of a rotation, take the one nearer to the previous, for readers that interpolate
    // linearly.
    double dot = 0.0;
    if (!values.empty())
      for (int c = 0; c < 4; ++c)
        dot += parts.rotation[c] * double{values[values.size() - 4 + static_cast<std::size_t>(c)]};
    const double sign = dot < 0.0 ? -1.0 : 1.0;
    std::array<float, 4> value;
    for (int c = 0; c < 4; ++c)
      value[static_cast<std::size_t>(c)] = static_cast<float>(sign * parts.rotation[c]);
    values.insert(values.end(), value.begin(), value.end());
  }
};

const char* name_of(rig::ChannelPath path) {
  return path == rig::ChannelPath::rotation ? "rotation"
         : path == rig::ChannelPath::scale  ? "scale"
                                            : "translation";
}

// Adds the motion of the scene's skeleton, sampled at the bake's frames, as the first animation. `weights_of`
// are the clip's weights with the document's node indices.
void add_baked_clip(gltf::GltfDocument& document, const scene::Scene& scene,
                    const std::vector<rig::WeightChannel>& weights_of,
                    const std::vector<std::uint32_t>& joint_node, const TimeOfFrame& time) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  const rig::Clip* clip = rig::find_clip(character, scene.clip);
  if (clip == nullptr || (clip->channels.empty() && weights_of.empty())) return;
  std::vector<Track> tracks;
  for (const rig::Channel& channel : clip->channels)
    tracks.push_back({.joint = channel.joint, .path = channel.path, .values = {}});
  std::vector<std::vector<float>> weights(weights_of.size());
  std::vector<float> times;
  const std::uint64_t frames = scene::frame_count(scene);
  for (std::uint64_t k = 0; k <= frames; ++k) {
    times.push_back(static_cast<float>(static_cast<double>(k) / scene.fps));
    const std::vector<rig::JointParts> parts = rig::joint_parts_at(character, clip, time(k));
    for (Track& track : tracks) track.append(parts[track.joint]);
    for (std::size_t w = 0; w < weights.size(); ++w)
      for (const double value : rig::weights_at(weights_of[w], time(k)))
        weights[w].push_back(static_cast<float>(value));
  }
  const std::size_t input = add_accessor(document, std::span<const float>(times), 1, true);
  json samplers = json::array(), channels = json::array();
  for (const Track& track : tracks) {
    const std::size_t width = track.path == rig::ChannelPath::rotation ? 4 : 3;
    samplers.push_back({{"input", input},
                        {"output", add_accessor(document, std::span<const float>(track.values), width)},
                        {"interpolation", "LINEAR"}});
    channels.push_back({{"sampler", samplers.size() - 1},
                        {"target", {{"node", joint_node.at(track.joint)}, {"path", name_of(track.path)}}}});
  }
  for (std::size_t w = 0; w < weights.size(); ++w) {
    if (!document.json["nodes"].at(weights_of[w].node).contains("mesh")) continue;
    samplers.push_back({{"input", input},
                        {"output", add_accessor(document, std::span<const float>(weights[w]), 1)},
                        {"interpolation", "LINEAR"}});
    channels.push_back(
        {{"sampler", samplers.size() - 1}, {"target", {{"node", weights_of[w].node}, {"path", "weights"}}}});
  }
  if (channels.empty()) return;
  json& animations = document.json["animations"];
  if (!animations.is_array()) animations = json::array();
  animations.insert(animations.begin(),
                    json({{"name", clip->name.empty() ? "baked" : clip->name + " (baked)"},
                          {"extras", {{baked_mark, true}}},
                          {"samplers", samplers},
                          {"channels", channels}}));
}

// Marks the carriers, so that meshes which nothing moves in their own file still belong to the character.
void mark_carriers(const gltf::Rig& rig, json& document) {
  for (std::size_t j = 0; j < rig.joint_node.size(); ++j) {
    if (!rig.character.skeleton[j].skins) continue;
    json& extras = document["nodes"][rig.joint_node[j]]["extras"];
    if (!extras.is_object()) extras = json::object();
    extras[gltf::carries_mark] = true;
  }
}

// Meshes that nothing moves are not part of the character, but below another character's joint they would be.
void hide_what_is_left_out(const gltf::Rig& rig, json& document) {
  std::set<std::size_t> shown;
  for (const gltf::RigPart& part : rig.parts) shown.insert(part.node);
  for (std::size_t n = 0; n < document["nodes"].size(); ++n)
    if (!shown.contains(n)) document["nodes"][n].erase("mesh");
}

// Adds each of the scene's characters below its own node. Returns the node of each joint of the scene's
// skeleton, and changes the weights' nodes to those of the document.
std::vector<std::uint32_t> add_characters(gltf::GltfDocument& document, const scene::Scene& scene,
                                          const model::Model& model, std::vector<rig::WeightChannel>& weights,
                                          std::vector<std::string>& missing) {
  std::vector<std::uint32_t> joint_node;
  std::size_t first_vertex = 0, weight = 0;
  for (std::size_t k = 0; k < scene.characters.size(); ++k) {
    const scene::PlacedCharacter& one = scene.characters[k];
    std::vector<std::uint32_t> own_node;
    gltf::GltfDocument part;
    if (one.file.empty() || scene::is_still_mesh(one)) {
      part = made_document(
          one.own, [&](gltf::GltfDocument& to) { return primitive_of(one.own, model, first_vertex, to); });
      for (std::uint32_t j = 0; j < one.own.skeleton.size(); ++j) own_node.push_back(j + 1);
    } else {
      part = gltf::pack_gltf(one.file, missing, scene.converter);
      const gltf::Rig rig = gltf::read_rig(one.file, scene.converter,
                                           one.settings.rigid ? gltf::Still::carried : gltf::Still::left_out);
      own_node = rig.joint_node;
      if (one.settings.rigid) mark_carriers(rig, part.json);
      if (one.bearer) hide_what_is_left_out(rig, part.json);
    }
    const rig::Joint& above = std::get<rig::Character>(scene.geometry).skeleton[one.first_joint];
    NodeAbove stands{.name = one.settings.name, .transform = {}, .parent = std::nullopt};
    if (one.bearer) {
      stands.transform = {{"matrix", numbers(one.place)}};
      stands.parent = joint_node.at(*one.bearer);
    } else {
      const auto list = [](const auto& v) { return std::vector<double>(v.data(), v.data() + v.size()); };
      stands.transform = {{"translation", list(above.rest_translation)},
                          {"rotation", list(above.rest_rotation)}};
    }
    const auto node = static_cast<std::uint32_t>(add_document(document, std::move(part), stands));
    joint_node.push_back(node);
    for (const std::uint32_t own : own_node) joint_node.push_back(node + 1 + own);
    const std::uint32_t next_node =
        k + 1 < scene.characters.size() ? scene.characters[k + 1].first_node : ~0u;
    for (; weight < weights.size() && weights[weight].node < next_node; ++weight)
      weights[weight].node += node + 1 - one.first_node;
    first_vertex += one.own.surface.vertices.size();
  }
  return joint_node;
}

void add_scale(json& document, double scale) {
  const std::vector<std::size_t> roots = shown_roots(document);
  json& nodes = document["nodes"];
  nodes.push_back({{"name", "metres"}, {"scale", {scale, scale, scale}}, {"children", roots}});
  json& scenes = document["scenes"];
  if (!scenes.is_array() || scenes.empty()) scenes = json::array({json::object()});
  scenes[document.value("scene", std::size_t{0})]["nodes"] = json::array({nodes.size() - 1});
}

const rig::Clip* baked_clip(const gltf::Rig& rig, bool has_clip) {
  return has_clip ? rig::find_clip(rig.character, "") : nullptr;
}

double stored_time(std::uint64_t frame, double fps) {
  return double{static_cast<float>(static_cast<double>(frame) / fps)};
}

}  // namespace

gltf::Rig read_kept_rig(const std::filesystem::path& character, const model::Model& model) {
  gltf::Rig rig = gltf::read_rig(character);
  std::size_t vertices = 0;
  for (const gltf::RigPart& part : rig.parts) vertices += part.positions.size();
  if (vertices != model.surface_count())
    throw base::BakeError(character.string() + ": has " + base::number_text(std::uint64_t{vertices}) +
                          " vertices, and the baked surface " + base::number_text(model.surface_count()) +
                          "; bake again with --overwrite");
  return rig;
}

bool has_baked_clip(const json& document) {
  const auto animations = document.find("animations");
  if (animations == document.end() || !animations->is_array() || animations->empty()) return false;
  return !gltf::json_member(gltf::json_member((*animations)[0], "extras"), baked_mark).is_null();
}

std::string character_glb(const scene::Scene& scene, const model::Model& model, const TimeOfFrame& time,
                          std::vector<std::string>& missing) {
  const auto& character = std::get<rig::Character>(scene.geometry);
  const std::filesystem::path file = scene::character_file(scene);
  const rig::Clip* clip = rig::find_clip(character, scene.clip);
  std::vector<rig::WeightChannel> weights;
  if (clip != nullptr) weights = clip->weights;
  std::vector<std::uint32_t> joint_node;
  gltf::GltfDocument document;
  if (!scene.characters.empty()) {
    document = {.json = {{"asset", asset()}, {"scene", 0}, {"scenes", json::array({json::object()})}},
                .binary = {}};
    joint_node = add_characters(document, scene, model, weights, missing);
  } else if (file.empty()) {
    document = made_document(character, [&](gltf::GltfDocument& to) { return primitive_of(model, to); });
    for (std::uint32_t j = 0; j < character.skeleton.size(); ++j) joint_node.push_back(j + 1);
  } else {
    document = gltf::pack_gltf(file, missing, scene.converter);
    joint_node = gltf::read_rig(file, scene.converter).joint_node;
  }
  add_baked_clip(document, scene, weights, joint_node, time);
  if (scene.characters.empty() && !file.empty() && scene.scale != 1.0) add_scale(document.json, scene.scale);
  json& extras = document.json["extras"];
  if (!extras.is_object()) extras = json::object();
  extras["fascicle"] = {{"fps", scene.fps},
                        {"first_frame", 0},
                        {"first_frame_seconds", scene.start},
                        {"meters_per_unit", 1},
                        {"up_axis", "Y"}};
  return glb_text(std::move(document));
}

std::vector<Eigen::Matrix4d> baked_joints(const gltf::Rig& rig, bool has_clip, std::uint64_t frame,
                                          double fps) {
  if (rig.character.skeleton.empty()) return {};
  return rig::joint_transforms_at(rig.character, baked_clip(rig, has_clip), stored_time(frame, fps));
}

std::vector<rig::JointParts> baked_parts(const gltf::Rig& rig, bool has_clip, std::uint64_t frame,
                                         double fps) {
  return rig::joint_parts_at(rig.character, baked_clip(rig, has_clip), stored_time(frame, fps));
}

gltf::GltfDocument plain_document(const model::Model& model) {
  gltf::GltfDocument document = empty_document();
  json primitive = primitive_of(model, document);
  document.json["meshes"].push_back({{"name", "surface"}, {"primitives", json::array({primitive})}});
  document.json["nodes"].push_back({{"name", "surface"}, {"mesh", 0}});
  return document;
}

}  // namespace fascicle::formats
