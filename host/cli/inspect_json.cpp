#include "host/cli/inspect_json.h"

#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "host/bake/bake.h"
#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/cli/inspect_counts.h"
#include "host/cli/part_names.h"
#include "host/model/model.h"
#include "host/rig/character.h"
#include "host/scene/scene_json.h"

namespace fascicle::cli {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::vector<build::JointReport>& joints) {
  Json list = Json::array();
  for (const build::JointReport& joint : joints)
    list.push_back({{"name", joint.name},
                    {"parent", joint.parent < 0 ? Json(nullptr) : Json(joint.parent)},
                    {"skin_share", joint.share},
                    {"openness", joint.openness},
                    {"bone", joint.is_bone},
                    {"ends_chain", joint.ends_chain},
                    {"kinematic", joint.is_kinematic},
                    {"reason", joint.reason}});
  return list;
}

Json json_of(const std::vector<build::RigidReport>& parts) {
  Json list = Json::array();
  for (const build::RigidReport& part : parts)
    list.push_back(
        {{"name", part.name}, {"joint", part.joint}, {"vertices", part.vertices}, {"reason", part.reason}});
  return list;
}

Json json_of(const build::FibreReport& fibres) {
  return {{"constraints", fibres.constraints},     {"rounds", fibres.rounds},
          {"iterations", fibres.iterations},       {"edges", fibres.edges},
          {"flipped_edges", fibres.flipped_edges}, {"bent_edges", fibres.bent_edges},
          {"without_direction", fibres.without},   {"seconds", fibres.seconds}};
}

Json json_of(const build::Finding& finding) {
  return {{"count", finding.count}, {"vertices", finding.vertices}};
}

Json json_of(const build::Spread& spread) {
  return {{"percentile_1_m", spread.low}, {"percentile_99_m", spread.high}, {"ratio", spread.ratio()}};
}

Json json_of(const std::vector<bake::OpenEndEntry>& ends) {
  Json list = Json::array();
  for (const bake::OpenEndEntry& end : ends)
    list.push_back({{"joint", end.joint},
                    {"became", end.became},
                    {"width_m", end.width},
                    {"edges", end.edges},
                    {"vertex", end.vertex}});
  return list;
}

// Null for bars and tetrahedral files, which have no skin to fill.
Json json_of(const build::CageReport& cage) {
  if (!cage.has_skin) return nullptr;
  const build::SurfaceFindings& found = cage.findings;
  return {{"cage", cage.is_cage},
          {"reason", cage.reason},
          {"parts", json_of(found.parts)},
          {"loose_vertices", json_of(found.loose_vertices)},
          {"flat_triangles", json_of(found.flat_triangles)},
          {"open_edges", json_of(found.open_edges)},
          {"non_manifold_edges", json_of(found.non_manifold_edges)},
          {"non_manifold_vertices", json_of(found.non_manifold_vertices)},
          {"turned_edges", json_of(found.turned_edges)},
          {"inverted_parts", json_of(found.inverted_parts)},
          {"intersections", json_of(found.intersections)},
          {"genus", found.genus},
          {"skin_volume_m3", cage.skin_volume},
          {"skin_spacing", json_of(cage.skin_spacing)},
          {"spacing", json_of(cage.spacing)},
          {"edges", json_of(cage.edges)},
          {"closed_gaps_m", 2.0 * cage.alpha},
          {"wrap_offset_m", cage.offset},
          {"cut_tetrahedra", cage.cut_tetrahedra},
          {"wrap_seconds", cage.wrap_seconds},
          {"fill_seconds", cage.fill_seconds},
          {"cut_seconds", cage.cut_seconds}};
}

std::span<const rig::Clip> clips_of(const scene::Scene& scene) {
  const auto* character = std::get_if<rig::Character>(&scene.geometry);
  return character != nullptr ? std::span<const rig::Clip>(character->clips) : std::span<const rig::Clip>();
}

// Expected accuracy of the steps; null for explicit ones, whose stiffness depends on the steps.
Json json_of(const model::Model& model, const build::StepError& error) {
  if (!model.is_implicit()) return {};
  return {{"residual", error.residual}, {"slower", error.slower}, {"lost_a_period", error.lost}};
}

}  // namespace

nlohmann::ordered_json inspect_json(const scene::Scene& scene, const pipeline::Built& built) {
  const build::Report& report = built.report;
  const model::Model& model = built.model;
  Json layers = Json::array();
  for (const build::LayerShare& layer : report.layers)
    layers.push_back({{"name", layer.name},
                      {"vertices", layer.vertices},
                      {"volume_m3", layer.volume},
                      {"volume_share", share_of(layer.volume, report.volume)},
                      {"mass_kg", layer.mass}});
  Json probes = Json::array();
  for (const model::ProbeSet& probe : model.probes)
    probes.push_back({{"name", probe.name}, {"vertices", probe.vertices.size()}});
  const PartNames names = names_of_parts(scene);
  Json clips = Json::array();
  for (const rig::Clip& clip : clips_of(scene))
    clips.push_back({{"name", clip.name}, {"duration_s", clip.duration}});
  Json characters = Json::array();
  for (const scene::PlacedCharacter& one : scene.characters) {
    Json own = Json::array();
    for (const rig::Clip& clip : one.own.clips)
      own.push_back({{"name", clip.name}, {"duration_s", clip.duration}});
    characters.push_back({{"name", one.settings.name},
                          {"file", one.file.string()},
                          {"made", one.settings.made},
                          {"joint", one.settings.joint},
                          {"at", scene::json_of(one.settings.at)},
                          {"turn", scene::json_of(one.settings.turn)},
                          {"rigid", one.settings.rigid},
                          {"thickness", one.settings.thickness},
                          {"vertices", one.own.surface.vertices.size()},
                          {"joints", one.own.skeleton.size()},
                          {"clips", std::move(own)}});
  }
  Json muscles = Json::array();
  for (const MuscleCount& muscle : count_muscles(scene, model))
    muscles.push_back({{"name", muscle.name},
                       {"bone", muscle.bone},
                       {"bone_length_m", muscle.bone_length},
                       {"regions", muscle.regions},
                       {"bulging_regions", muscle.bulging}});
  Json warnings = Json::array();
  for (const build::Warning& warning : report.warnings)
    warnings.push_back({{"text", warning.text}, {"vertices", warning.vertices}});
  return {{"scene", scene.name},
          {"source", scene.source},
          {"vertices", report.vertices},
          {"tetrahedra", report.tetrahedra},
          {"surface_vertices", report.surface_vertices},
          {"surface_triangles", report.surface_triangles},
          {"joints", model.joint_count},
          {"one_ring_entries", model.ring.size()},
          {"longest_one_ring", longest_ring(model)},
          {"pinned_vertices", report.pinned_vertices},
          {"volume_m3", report.volume},
          {"mass_kg", report.mass},
          {"mean_edge_m", report.mean_edge},
          {"shortest_edge_m", report.shortest_edge},
          {"longest_edge_m", report.longest_edge},
          {"working_unit_m", model.unit},
          {"weights", model::name_of(model.weight_form)},
          {"flipped_tetrahedra", report.flipped_tetrahedra},
          {"riders_outside", report.fill.riders_outside},
          {"least_barycentric", report.fill.least_barycentric},
          {"model_from_cache", report.is_kept},
          {"body_from_cache", report.body_from_cache},
          {"skin", json_of(report.fill.cage)},
          {"open_ends", json_of(pipeline::open_ends_of(report))},
          {"region_fallbacks", report.region_fallbacks},
          {"vertex_fallbacks", report.vertex_fallbacks},
          {"skipped_regions", report.skipped_regions},
          {"frames", scene::frame_count(scene)},
          {"fps", scene.fps},
          {"objects", names.objects},
          {"materials", names.materials},
          {"clips", clips},
          {"characters", characters},
          {"clip", scene::clip_name(scene)},
          {"substeps", built.steps.substeps},
          {"iterations", model.is_implicit() ? Json(built.steps.iterations) : Json()},
          {"step_error", json_of(model, built.steps.error)},
          {"solver_bytes", model::solver_bytes(model)},
          {"skeleton", json_of(report.joints)},
          {"rigid_parts", json_of(report.rigid_parts)},
          {"bone_layer",
           {{"islands_of_shapes", report.bone_islands_before},
            {"islands", report.bone_islands},
            {"vertices_added", report.bone_vertices_added}}},
          {"fibres", json_of(report.fibres)},
          {"layers", layers},
          {"muscles", muscles},
          {"probes", probes},
          {"warnings", warnings},
          {"build_seconds", report.seconds}};
}

}  // namespace fascicle::cli
