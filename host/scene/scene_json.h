// A scene's parameters as JSON, for the manifest. The JSON of a struct with keys follows from its rows
// (scene_rows.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/scene/scene.h"

namespace fascicle::scene {

using Json = nlohmann::ordered_json;

// JSON as text. Bytes that are not UTF-8 (in file names) become U+FFFD. indent < 0: one line.
std::string dump(const Json& json, int indent = -1);

Json json_of(const Vector3d& vector);
Json json_of(const Where& where);
Json json_of(const Layer& layer);
Json json_of(const FleshSettings& flesh);
Json json_of(const ContactSettings& contact);
Json json_of(const SkeletonSettings& skeleton);
Json json_of(const FibreCurve& curve);
Json json_of(const Muscle& muscle);
Json json_of(const Pin& pin);
Json json_of(const ProbeSet& probe);
Json json_of(const Force& force);
Json json_of(const Collider& collider);
Json json_of(const BoneSegment& bone);
Json json_of(const Bar& bar);
Json json_of(const CharacterSettings& character);
Json json_of(const BodySettings& body);
Json json_of(const SolverSettings& solver);
Json json_of(const Motion& motion);
Json json_of(const Box& box);
Json json_of(const Sphere& sphere);
Json json_of(const Capsule& capsule);
Json json_of(const HalfSpace& half_space);
Json json_of(const BoneDistance& distance);
Json json_of(const Depth& depth);
Json json_of(const VolumeShare& share);
Json json_of(const JointSet& set);
Json json_of(const PartSet& set);
Json json_of(const Painted& painted);
// The keys of [scene], [mesh] and [character] that set members of the scene itself.
Json json_of_scene_keys(const Scene& scene);
// Every parameter. Meshes and clips are identified by the input hashes, so only their sizes appear.
Json json_of(const Scene& scene);

template <class Struct>
Json json_of(const std::vector<Struct>& list) {
  Json all = Json::array();
  for (const Struct& one : list) all.push_back(json_of(one));
  return all;
}

// Members' values as JSON: null if absent, a curve as pairs, named numbers as an object.
template <class T>
Json json_of_value(const T& value) {
  return value;
}
inline Json json_of_value(const Vector3d& vector) {
  return json_of(vector);
}
inline Json json_of_value(const Where& where) {
  return json_of(where);
}
inline Json json_of_value(const std::vector<Vector3d>& points) {
  Json list = Json::array();
  for (const Vector3d& point : points) list.push_back(json_of(point));
  return list;
}
inline Json json_of_value(const PerBone& per_bone) {
  Json object = Json::object();
  for (const auto& [name, value] : per_bone) object[name] = value;
  return object;
}
template <class T>
Json json_of_value(const std::optional<T>& value) {
  return value ? json_of_value(*value) : Json(nullptr);
}

}  // namespace fascicle::scene
