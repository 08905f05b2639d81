#include "host/scene/scene_json.h"

#include <type_traits>
#include <variant>

#include "host/rig/pose.h"
#include "host/scene/scene_keys.h"

namespace fascicle::scene {

namespace {

// The key of each shape.
struct ShapeJson {
  Json operator()(const Box& box) const { return {{"box", json_of(box)}}; }
  Json operator()(const Sphere& sphere) const { return {{"sphere", json_of(sphere)}}; }
  Json operator()(const Capsule& capsule) const { return {{"capsule", json_of(capsule)}}; }
  Json operator()(const HalfSpace& half) const { return {{half.below ? "below" : "above", json_of(half)}}; }
  Json operator()(const BoneDistance& distance) const { return {{"bone_distance", json_of(distance)}}; }
  Json operator()(const Depth& depth) const { return {{"depth", json_of(depth)}}; }
  Json operator()(const VolumeShare& share) const { return {{"volume_share", json_of(share)}}; }
  Json operator()(const JointSet& set) const { return {{"joints", json_of(set)}}; }
  Json operator()(const PartSet& set) const {
    return {{set.by_object ? "object" : "material", json_of(set)}};
  }
  Json operator()(const Painted& painted) const { return {{"painted", json_of(painted)}}; }
  Json operator()(const Everywhere&) const { return "everywhere"; }
};

Json painted_names(const rig::Character& character) {
  Json names = Json::array();
  for (const rig::PaintedAttribute& attribute : character.painted) names.push_back(attribute.name);
  return names;
}

// The characters of [character.NAME], with their positions in the scene's bind pose; empty for a single
// [character].
Json json_of_characters(const Scene& scene) {
  Json list = Json::array();
  for (const PlacedCharacter& character : scene.characters) {
    Json one = json_of(character.settings);
    one["bind_offset"] = json_of(character.bind_offset);
    one["vertices"] = character.own.surface.vertices.size();
    one["joints"] = character.own.skeleton.size();
    list.push_back(std::move(one));
  }
  return list;
}

struct GeometryJson {
  Json operator()(const Bar& bar) const { return {{"bar", json_of(bar)}}; }
  Json operator()(const mesh::TetMesh& mesh) const {
    return {{"tetrahedra", {{"vertices", mesh.vertices.size()}, {"tetrahedra", mesh.tetrahedra.size()}}}};
  }
  Json operator()(const mesh::SurfaceMesh& mesh) const {
    return {{"surface", {{"vertices", mesh.vertices.size()}, {"triangles", mesh.triangles.size()}}}};
  }
  Json operator()(const rig::Character& character) const {
    Json clips = Json::array();
    for (const rig::Clip& clip : character.clips)
      clips.push_back({{"name", clip.name}, {"duration", clip.duration}, {"channels", clip.channels.size()}});
    return {{"character",
             {{"vertices", character.surface.vertices.size()},
              {"triangles", character.surface.triangles.size()},
              {"joints", character.skeleton.size()},
              {"painted", painted_names(character)},
              {"clips", std::move(clips)}}}};
  }
};

}  // namespace

Json json_of(const Vector3d& vector) {
  return Json::array({vector.x(), vector.y(), vector.z()});
}

Json json_of(const Where& where) {
  Json shapes = Json::array();
  for (const Shape& shape : where) shapes.push_back(std::visit(ShapeJson{}, shape));
  return shapes;
}

Json json_of(const Scene& scene) {
  Json object{{"name", scene.name},
              {"source", scene.source},
              {"fps", scene.fps},
              {"start", scene.start},
              {"end", scene.end},
              {"frames", frame_count(scene)},
              {"clip", scene.clip},
              {"clip_name", clip_name(scene)},
              {"gravity", json_of(scene.gravity)},
              {"motion", json_of(scene.motion)},
              {"contact", json_of(scene.contact)},
              {"solver", json_of(scene.solver)},
              {"geometry", std::visit(GeometryJson{}, scene.geometry)},
              {"scale", scene.scale},
              {"resolution", json_of_value(scene.resolution)},
              {"body", json_of(scene.body)},
              {"bones", json_of(scene.bones)},
              {"skeleton", json_of(scene.skeleton)},
              {"layers", json_of(scene.layers)},
              {"flesh", json_of(scene.flesh)},
              {"fibres", json_of(scene.fibres)},
              {"muscles", json_of(scene.muscles)},
              {"pins", json_of(scene.pins)},
              {"probes", json_of(scene.probes)},
              {"forces", json_of(scene.forces)},
              {"colliders", json_of(scene.colliders)},
              {"text", scene.text}};
  if (!scene.characters.empty()) object["characters"] = json_of_characters(scene);
  // Keys that set members of the scene itself and are not listed above.
  const Json of_keys = json_of_scene_keys(scene);
  for (const auto& [key, value] : of_keys.items())
    if (!object.contains(key)) object[key] = value;
  return object;
}

std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace fascicle::scene
