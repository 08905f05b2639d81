#include "host/bake/scene_json.h"

#include <type_traits>

namespace fascicle::bake {

namespace {

const char* axis_name(scene::Axis axis) {
  return axis == scene::Axis::x ? "x" : axis == scene::Axis::y ? "y" : "z";
}

struct ShapeJson {
  Json operator()(const scene::Box& box) const {
    return {{"box", {{"minimum", json_of(box.minimum)}, {"maximum", json_of(box.maximum)}}}};
  }
  Json operator()(const scene::Sphere& sphere) const {
    return {{"sphere", {{"center", json_of(sphere.center)}, {"radius", sphere.radius}}}};
  }
  Json operator()(const scene::Capsule& capsule) const {
    return {{"capsule",
             {{"from", json_of(capsule.from)}, {"to", json_of(capsule.to)}, {"radius", capsule.radius}}}};
  }
  Json operator()(const scene::HalfSpace& half) const {
    return {{half.below ? "below" : "above",
             {{"axis", axis_name(half.axis)}, {half.is_fraction ? "fraction" : "value", half.value}}}};
  }
  Json operator()(const scene::BoneDistance& distance) const {
    return {{"bone_distance", {{"minimum", distance.minimum}, {"maximum", distance.maximum}}}};
  }
  Json operator()(const scene::Everywhere&) const { return "everywhere"; }
};

struct GeometryJson {
  Json operator()(const scene::Bar& bar) const {
    return {{"bar",
             {{"size", json_of(bar.size)},
              {"vertices", bar.vertices},
              {"jitter", bar.jitter},
              {"seed", bar.seed}}}};
  }
  Json operator()(const scene::TetMesh& mesh) const {
    return {{"tetrahedra", {{"vertices", mesh.vertices.size()}, {"tetrahedra", mesh.tetrahedra.size()}}}};
  }
  Json operator()(const scene::SurfaceMesh& mesh) const {
    return {{"surface", {{"vertices", mesh.vertices.size()}, {"triangles", mesh.triangles.size()}}}};
  }
  Json operator()(const scene::Character& character) const {
    Json clips = Json::array();
    for (const scene::Clip& clip : character.clips)
      clips.push_back({{"name", clip.name}, {"duration", clip.duration}, {"channels", clip.channels.size()}});
    return {{"character",
             {{"vertices", character.surface.vertices.size()},
              {"triangles", character.surface.triangles.size()},
              {"joints", character.skeleton.size()},
              {"clips", std::move(clips)}}}};
  }
};

Json json_of_layer(const scene::Layer& layer) {
  return {{"name", layer.name},           {"alpha", layer.alpha},
          {"beta", layer.beta},           {"damping", layer.damping},
          {"density", layer.density},     {"fibre", layer.fibre ? json_of(*layer.fibre) : Json(nullptr)},
          {"kinematic", layer.kinematic}, {"inertia_scale", layer.inertia_scale},
          {"where", json_of(layer.where)}};
}

}  // namespace

std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json json_of(const scene::Vector3d& vector) {
  return Json::array({vector.x(), vector.y(), vector.z()});
}

Json json_of(const scene::Where& where) {
  Json shapes = Json::array();
  for (const scene::Shape& shape : where) shapes.push_back(std::visit(ShapeJson{}, shape));
  return shapes;
}

Json json_of(const std::vector<scene::Force>& forces) {
  Json list = Json::array();
  for (const scene::Force& force : forces)
    list.push_back({{"name", force.name},
                    {"kind", force.kind == scene::ForceKind::wind ? "wind" : "point"},
                    {"vector", json_of(force.vector)},
                    {"where", json_of(force.where)},
                    {"start", force.start},
                    {"end", force.end}});
  return list;
}

Json json_of(const scene::Motion& motion) {
  return {{"rest", motion.rest == scene::Rest::sculpted ? "sculpted" : "weightless"},
          {"preroll", motion.preroll},
          {"settle", motion.settle},
          {"loop", motion.loop},
          {"seamless", motion.seamless},
          {"seamless_tolerance", motion.seamless_tolerance},
          {"seamless_cycles", motion.seamless_cycles},
          {"hold", motion.hold},
          {"cuts", motion.cuts},
          {"cut_distance", motion.cut_distance ? Json(*motion.cut_distance) : Json(nullptr)}};
}

Json json_of(const scene::Scene& scene) {
  Json bones = Json::array(), layers = Json::array(), pins = Json::array(), probes = Json::array();
  for (const scene::BoneSegment& bone : scene.bones)
    bones.push_back({{"name", bone.name}, {"from", json_of(bone.from)}, {"to", json_of(bone.to)}});
  for (const scene::Layer& layer : scene.layers) layers.push_back(json_of_layer(layer));
  for (const scene::Pin& pin : scene.pins)
    pins.push_back({{"name", pin.name}, {"where", json_of(pin.where)}});
  for (const scene::ProbeSet& probe : scene.probes)
    probes.push_back({{"name", probe.name}, {"where", json_of(probe.where)}});
  return {{"name", scene.name},
          {"source", scene.source},
          {"fps", scene.fps},
          {"start", scene.start},
          {"end", scene.end},
          {"frames", scene::frame_count(scene)},
          {"clip", scene.clip},
          {"gravity", json_of(scene.gravity)},
          {"motion", json_of(scene.motion)},
          {"solver",
           {{"integrator", scene.solver.integrator},
            {"rotation", scene.solver.rotation},
            {"weights", scene.solver.weights},
            {"substeps", scene.solver.substeps}}},
          {"geometry", std::visit(GeometryJson{}, scene.geometry)},
          {"scale", scene.scale},
          {"resolution", scene.resolution ? Json(*scene.resolution) : Json(nullptr)},
          {"body",
           {{"cage", scene.body.cage},
            {"cage_detail", scene.body.cage_detail},
            {"vertices", scene.body.vertices ? Json(*scene.body.vertices) : Json(nullptr)}}},
          {"bones", std::move(bones)},
          {"layers", std::move(layers)},
          {"pins", std::move(pins)},
          {"probes", std::move(probes)},
          {"forces", json_of(scene.forces)},
          {"text", scene.text}};
}

}  // namespace fascicle::bake
