#include "host/bake/scene_json.h"

#include <type_traits>

#include "host/scene/pose.h"

namespace fascicle::bake {

namespace {

const char* axis_name(scene::Axis axis) {
  return axis == scene::Axis::x ? "x" : axis == scene::Axis::y ? "y" : "z";
}

Json per_bone_json(const scene::PerBone& per_bone) {
  Json object = Json::object();
  for (const auto& [name, value] : per_bone) object[name] = value;
  return object;
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
    return {{"bone_distance",
             {{"minimum", distance.minimum},
              {"maximum", distance.maximum},
              {"per_bone", per_bone_json(distance.per_bone)}}}};
  }
  Json operator()(const scene::Depth& depth) const {
    return {{"depth",
             {{"minimum", depth.minimum},
              {"maximum", depth.maximum},
              {"per_bone", per_bone_json(depth.per_bone)}}}};
  }
  Json operator()(const scene::VolumeShare& share) const {
    return {{"volume_share",
             {{"minimum", share.minimum},
              {"maximum", share.maximum},
              {"by", share.by_distance ? "distance" : "depth"}}}};
  }
  Json operator()(const scene::JointSet& set) const {
    return {{"joints", {{"names", set.names}, {"share", set.share}, {"below", set.below}}}};
  }
  Json operator()(const scene::PartSet& set) const {
    return {{set.by_object ? "object" : "material", {{"names", set.names}}}};
  }
  Json operator()(const scene::Painted& painted) const {
    return {{"painted",
             {{"attribute", painted.attribute}, {"minimum", painted.minimum}, {"maximum", painted.maximum}}}};
  }
  Json operator()(const scene::Everywhere&) const { return "everywhere"; }
};

Json painted_names(const scene::Character& character) {
  Json names = Json::array();
  for (const scene::PaintedAttribute& attribute : character.painted) names.push_back(attribute.name);
  return names;
}

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
              {"painted", painted_names(character)},
              {"clips", std::move(clips)}}}};
  }
};

Json number_or_null(const std::optional<double>& number) {
  return number ? Json(*number) : Json(nullptr);
}

Json json_of_layer(const scene::Layer& layer) {
  Json object{{"name", layer.name},
              {"alpha", layer.alpha},
              {"alpha_outer", layer.alpha_outer ? Json(*layer.alpha_outer) : Json(nullptr)},
              {"alpha_attribute", layer.alpha_attribute},
              {"youngs_modulus", number_or_null(layer.youngs_modulus)},
              {"frequency", number_or_null(layer.frequency)},
              {"material", layer.material},
              {"beta", layer.beta},
              {"damping", layer.damping},
              {"damping_ratio", number_or_null(layer.damping_ratio)},
              {"density", layer.density},
              {"fibre", layer.fibre ? json_of(*layer.fibre) : Json(nullptr)},
              {"fibre_field", layer.fibre_field},
              {"kinematic", layer.kinematic},
              {"inertia_scale", layer.inertia_scale},
              {"where", json_of(layer.where)}};
  if (layer.least_volume > 0.0) object["least_volume"] = layer.least_volume;
  if (layer.volume > 0.0) object["volume"] = layer.volume;
  if (layer.sliding) object["sliding"] = true;
  return object;
}

Json json_of_skeleton(const scene::SkeletonSettings& skeleton) {
  return {{"bones", skeleton.bones},
          {"not_bones", skeleton.not_bones},
          {"kinematic", skeleton.kinematic},
          {"simulated", skeleton.simulated},
          {"rigid", skeleton.rigid},
          {"only", skeleton.only},
          {"least_share", skeleton.least_share},
          {"connect", skeleton.connect}};
}

Json json_of_fibres(const std::vector<scene::FibreCurve>& fibres) {
  Json list = Json::array();
  for (const scene::FibreCurve& curve : fibres) {
    Json points = Json::array();
    for (const scene::Vector3d& point : curve.points) points.push_back(json_of(point));
    list.push_back({{"name", curve.name},
                    {"points", std::move(points)},
                    {"radius", curve.radius ? Json(*curve.radius) : Json(nullptr)}});
  }
  return list;
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
  return {
      {"rest", motion.rest == scene::Rest::sculpted ? "sculpted" : "weightless"},
      {"interpolation", motion.interpolation == scene::KeyInterpolation::smooth ? "smooth" : "as-authored"},
      {"preroll", motion.preroll},
      {"settle", motion.settle},
      {"loop", motion.loop},
      {"seamless", motion.seamless},
      {"seamless_tolerance", motion.seamless_tolerance},
      {"seamless_cycles", motion.seamless_cycles},
      {"hold", motion.hold},
      {"handles", motion.handles},
      {"acceleration_limit", motion.acceleration_limit ? Json(*motion.acceleration_limit) : Json(nullptr)},
      {"cuts", motion.cuts},
      {"cut_distance", motion.cut_distance ? Json(*motion.cut_distance) : Json(nullptr)}};
}

Json json_of_curve(const scene::KeyedCurve& curve) {
  Json keys = Json::array();
  for (const auto& [x, value] : curve) keys.push_back({x, value});
  return keys;
}

Json json_of_muscle(const scene::Muscle& muscle) {
  return {{"name", muscle.name},
          {"joint", muscle.joint},
          {"parent", muscle.parent},
          {"child", muscle.child},
          {"bone", muscle.bone},
          {"layer", muscle.layer},
          {"where", json_of(muscle.where)},
          {"gain", muscle.gain},
          {"axis", muscle.axis},
          {"activation", muscle.activation},
          {"curve", json_of_curve(muscle.curve)},
          {"contraction", json_of_curve(muscle.contraction)},
          {"contraction_channel", muscle.contraction_channel},
          {"twist", muscle.twist},
          {"twist_joint", muscle.twist_joint}};
}

Json json_of(const scene::Scene& scene) {
  Json bones = Json::array(), layers = Json::array(), muscles = Json::array(), pins = Json::array(),
       probes = Json::array();
  for (const scene::BoneSegment& bone : scene.bones)
    bones.push_back({{"name", bone.name}, {"from", json_of(bone.from)}, {"to", json_of(bone.to)}});
  for (const scene::Layer& layer : scene.layers) layers.push_back(json_of_layer(layer));
  for (const scene::Muscle& muscle : scene.muscles) muscles.push_back(json_of_muscle(muscle));
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
          {"clip_name", scene::clip_name(scene)},
          {"gravity", json_of(scene.gravity)},
          {"motion", json_of(scene.motion)},
          {"solver",
           {{"integrator", scene.solver.integrator},
            {"rotation", scene.solver.rotation},
            {"weights", scene.solver.weights},
            {"substeps", scene.solver.substeps},
            {"auto_substeps", scene.solver.auto_substeps},
            {"iterations", scene.solver.iterations}}},
          {"geometry", std::visit(GeometryJson{}, scene.geometry)},
          {"scale", scene.scale},
          {"resolution", scene.resolution ? Json(*scene.resolution) : Json(nullptr)},
          {"body",
           {{"cage", scene.body.cage},
            {"cage_detail", scene.body.cage_detail},
            {"vertices", scene.body.vertices ? Json(*scene.body.vertices) : Json(nullptr)}}},
          {"bones", std::move(bones)},
          {"skeleton", json_of_skeleton(scene.skeleton)},
          {"layers", std::move(layers)},
          {"fibres", json_of_fibres(scene.fibres)},
          {"muscles", std::move(muscles)},
          {"pins", std::move(pins)},
          {"probes", std::move(probes)},
          {"forces", json_of(scene.forces)},
          {"text", scene.text}};
}

}  // namespace fascicle::bake
