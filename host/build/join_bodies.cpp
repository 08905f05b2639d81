#include "host/build/join_bodies.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace fascicle::build {

namespace {

template <class T>
void append(std::vector<T>& to, std::vector<T> more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void append_shifted(std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& more,
                    std::uint32_t by) {
  for (const std::uint32_t value : more) to.push_back(value + by);
}

void append(Finding& to, const Finding& more, std::uint32_t first_vertex) {
  to.count += more.count;
  append_shifted(to.vertices, more.vertices, first_vertex);
}

void append(Spread& to, const Spread& more) {
  to.low = to.high > 0.0 ? std::min(to.low, more.low) : more.low;
  to.high = std::max(to.high, more.high);
}

// `more` has the numbers of one character; `to` those of the whole scene's surface and skeleton.
void append(CageReport& to, const CageReport& more, const std::string& name, std::uint32_t first_vertex,
            std::int32_t first_joint) {
  to.has_skin = to.has_skin || more.has_skin;
  to.is_cage = to.is_cage || more.is_cage;
  to.reason += (to.reason.empty() ? "" : "; ") + name + ": " + (more.is_cage ? "a cage, " : "") + more.reason;
  const SurfaceFindings& found = more.findings;
  append(to.findings.parts, found.parts, first_vertex);
  append(to.findings.loose_vertices, found.loose_vertices, first_vertex);
  append(to.findings.flat_triangles, found.flat_triangles, first_vertex);
  append(to.findings.open_edges, found.open_edges, first_vertex);
  append(to.findings.non_manifold_edges, found.non_manifold_edges, first_vertex);
  append(to.findings.non_manifold_vertices, found.non_manifold_vertices, first_vertex);
  append(to.findings.turned_edges, found.turned_edges, first_vertex);
  append(to.findings.inverted_parts, found.inverted_parts, first_vertex);
  append(to.findings.intersections, found.intersections, first_vertex);
  to.findings.genus += found.genus;
  append_shifted(to.ends.vertex, more.ends.vertex, first_vertex);
  append(to.ends.edges, more.ends.edges);
  for (const std::int32_t joint : more.ends.joint)
    to.ends.joint.push_back(joint < 0 ? -1 : joint + first_joint);
  append(to.ends.width, more.ends.width);
  append(to.ends.fate, more.ends.fate);
  to.skin_volume += more.skin_volume;
  append(to.skin_spacing, more.skin_spacing);
  append(to.spacing, more.spacing);
  append(to.edges, more.edges);
  to.alpha = std::max(to.alpha, more.alpha);
  to.cut_tetrahedra += more.cut_tetrahedra;
  to.wrap_seconds += more.wrap_seconds;
  to.fill_seconds += more.fill_seconds;
  to.cut_seconds += more.cut_seconds;
}

void append_report(const std::string& name, std::uint32_t first_vertex, std::int32_t first_joint,
                   bool is_first, Report found, Report& report) {
  report.flipped_tetrahedra += found.flipped_tetrahedra;
  report.fill.riders_outside += found.fill.riders_outside;
  report.fill.least_barycentric = std::min(report.fill.least_barycentric, found.fill.least_barycentric);
  append(report.fill.cage, found.fill.cage, name, first_vertex, first_joint);
  report.joints.push_back({.name = name, .reason = "stands above all joints of the character"});
  for (JointReport& joint : found.joints) {
    joint.parent = joint.parent < 0 ? first_joint - 1 : joint.parent + first_joint;
    report.joints.push_back(std::move(joint));
  }
  append(report.rigid_parts, std::move(found.rigid_parts));
  for (Warning& warning : found.warnings) {
    warning.text = name + ": " + warning.text;
    report.warnings.push_back(std::move(warning));
  }
  report.body_from_cache = found.body_from_cache && (is_first || report.body_from_cache);
}

std::vector<std::string> names_of_character(const std::vector<std::string>& names,
                                            const std::string& character) {
  std::vector<std::string> own;
  for (const std::string& name : names)
    if (name.starts_with(character + "/")) own.push_back(name);
  return own;
}

// The share of a vertex's weights that makes it follow one joint.
constexpr double hard_share = 0.99;

// Whether each vertex follows a single joint: an object, not a skin.
bool is_hard(const rig::Character& character) {
  return std::all_of(character.weights.begin(), character.weights.end(), [](const auto& weights) {
    return *std::max_element(weights.begin(), weights.end()) >= hard_share;
  });
}

}  // namespace

scene::Scene scene_of_character(const scene::Scene& scene, std::size_t k) {
  const scene::CharacterSettings& settings = scene.characters.at(k).settings;
  scene::Scene own;
  own.name = scene.name;
  own.source = scene.source + ": character." + settings.name;
  own.scale = scene.scale;
  own.resolution = scene.resolution;
  own.body = scene.body;
  if (settings.resolution) {
    own.resolution = settings.resolution;
    own.body.vertices.reset();
  }
  // Contact needs to know how deep flesh lies in a prop. Tetrahedra between the few corners of a box do not
  // tell.
  own.body.thickness = settings.thickness;
  if (settings.rigid && (settings.thickness > 0.0 || is_hard(scene.characters[k].own)))
    own.body.cage = scene::Cage::wrap;
  own.bones = scene.bones;
  own.skeleton = scene.skeleton;
  for (auto* names : {&own.skeleton.bones, &own.skeleton.not_bones, &own.skeleton.kinematic,
                      &own.skeleton.simulated, &own.skeleton.rigid, &own.skeleton.only})
    *names = names_of_character(*names, settings.name);
  return own;
}

bool is_rigid(const scene::Scene& scene, std::size_t k) {
  const scene::CharacterSettings& settings = scene.characters.at(k).settings;
  const std::vector<std::string>& only = scene.skeleton.only;
  return settings.rigid || (!only.empty() && names_of_character(only, settings.name).empty());
}

void append_body(const scene::Scene& scene, std::size_t k, Body one, Report found, Body& all,
                 Report& report) {
  const scene::PlacedCharacter& character = scene.characters.at(k);
  const std::string& name = character.settings.name;
  const Vector3d offset = scene.scale * character.bind_offset;
  const auto first = static_cast<std::uint32_t>(all.mesh.vertices.size());
  const auto first_rider = static_cast<std::uint32_t>(all.render.corners.size());
  const std::uint32_t above = character.first_joint;
  const auto first_joint = static_cast<std::int32_t>(above + 1);
  const bool rigid = is_rigid(scene, k);

  for (const Vector3d& p : one.mesh.vertices) all.mesh.vertices.push_back(p + offset);
  for (const auto& t : one.mesh.tetrahedra)
    all.mesh.tetrahedra.push_back({t[0] + first, t[1] + first, t[2] + first, t[3] + first});
  append(all.holding, std::move(one.holding));
  for (const auto& c : one.render.corners)
    all.render.corners.push_back({c[0] + first, c[1] + first, c[2] + first, c[3] + first});
  append(all.render.weights, std::move(one.render.weights));
  for (const auto& t : one.render.triangles)
    all.render.triangles.push_back({t[0] + first_rider, t[1] + first_rider, t[2] + first_rider});
  if (all.skin.offset.empty()) all.skin.offset.push_back(0);
  const std::uint32_t first_weight = all.skin.offset.back();
  for (std::size_t i = 1; i < one.skin.offset.size(); ++i)
    all.skin.offset.push_back(one.skin.offset[i] + first_weight);
  append_shifted(all.skin.joint, one.skin.joint, above + 1);
  append(all.skin.weight, std::move(one.skin.weight));

  all.joints.push_back({.name = name});
  const auto in_scene = [&](std::int32_t joint) { return joint < 0 ? -1 : joint + first_joint; };
  for (JointUse& joint : one.joints) {
    joint.parent = joint.parent < 0 ? first_joint - 1 : in_scene(joint.parent);
    joint.bone = in_scene(joint.bone);
    if (rigid) joint.is_kinematic = true, joint.is_free = false;
    all.joints.push_back(std::move(joint));
  }
  for (Bone& bone : one.bones) {
    for (std::int32_t& owner : bone.owners) owner = in_scene(owner);
    all.bones.push_back({bone.from + offset, bone.to + offset, bone.owners});
  }
  all.members.push_back({above, offset, rigid});
  append_report(name, first_rider, first_joint, k == 0, std::move(found), report);
}

}  // namespace fascicle::build
