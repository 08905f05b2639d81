#include "host/build/body.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "host/build/bar.h"
#include "host/build/bone_choice.h"
#include "host/build/bones.h"
#include "host/build/boundary.h"
#include "host/build/carriers.h"
#include "host/build/check_mesh.h"
#include "host/build/filled_body.h"
#include "host/build/join_bodies.h"
#include "host/build/mesher.h"
#include "host/build/message.h"
#include "host/build/rigid_parts.h"
#include "host/build/skin_weights.h"
#include "host/build/thin_props.h"
#include "host/build/unions.h"
#include "host/build/weld.h"

namespace fascicle::build {

namespace {

void add_scene_bones(const scene::Scene& scene, Body& body) {
  for (const scene::BoneSegment& bone : scene.bones) body.bones.push_back({bone.from, bone.to, {-1, -1, -1}});
}

Body body_of(const scene::Bar& bar, const scene::Scene& scene, Report& report, const BuildOptions&) {
  Body body;
  body.mesh = make_bar(bar, scene.source);
  check_and_orient(body.mesh, scene.source, report);
  body.render = boundary_render_mesh(body.mesh, scene.source);
  add_scene_bones(scene, body);
  return body;
}

Body body_of(const mesh::TetMesh& mesh, const scene::Scene& scene, Report& report, const BuildOptions&) {
  Body body;
  body.mesh = mesh;
  for (Vector3d& p : body.mesh.vertices) p *= scene.scale;
  check_and_orient(body.mesh, scene.source, report);
  body.render = boundary_render_mesh(body.mesh, scene.source);
  add_scene_bones(scene, body);
  return body;
}

// Scales a surface to metres and welds it.
WeldedSurface prepare_surface(mesh::SurfaceMesh surface, const scene::Scene& scene, Report& report) {
  for (Vector3d& p : surface.vertices) p *= scene.scale;
  return weld(surface, scene.source, report);
}

void take(FilledBody filled, Body& body) {
  body.mesh = std::move(filled.mesh);
  body.skin = std::move(filled.skin);
  body.render = std::move(filled.render);
}

Body body_of(const mesh::SurfaceMesh& surface, const scene::Scene& scene, Report& report,
             const BuildOptions& options) {
  const WeldedSurface welded = prepare_surface(surface, scene, report);
  Body body;
  const std::vector<Bone> no_points_inside;
  take(fill_body({scene, surface, welded, no_points_inside}, report, options), body);
  add_scene_bones(scene, body);
  return body;
}

// Adds the vertices of small parts: those with less than a tenth of the area of the largest part, of what is
// not left out.
void leave_out_small_parts(const mesh::SurfaceMesh& surface, std::vector<char>& is_left_out) {
  Unions parts(surface.vertices.size());
  for (const auto& t : surface.triangles) parts.join(t[0], t[1]), parts.join(t[0], t[2]);
  std::vector<double> area(surface.vertices.size(), 0.0);  // at the root of each part, m^2
  for (const auto& t : surface.triangles) {
    if (is_left_out[t[0]] != 0) continue;
    const Vector3d& a = surface.vertices[t[0]];
    area[parts.find(t[0])] += (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm() / 2.0;
  }
  const double largest = area.empty() ? 0.0 : *std::max_element(area.begin(), area.end());
  for (std::uint32_t v = 0; v < surface.vertices.size(); ++v)
    if (area[parts.find(v)] < 0.1 * largest) is_left_out[v] = 1;
}

// Hair of many strips may be most of the skin, so that no joint of the body moves enough of it. Where there
// would be no bone at all, the bones of a body are those that it has without its rigid parts, or without its
// small parts, too.
BoneChoice choose_bones_beside(const rig::Character& character, const WeldedSurface& welded,
                               const RigidSkin& rigid, const scene::Scene& scene, bool is_prop) {
  const auto chosen = [&](const std::vector<char>& is_beside) {
    std::vector<char> is_left_out;
    for (const std::uint32_t v : welded.of_vertex) is_left_out.push_back(is_beside[v]);
    return choose_bones(character, scene.skeleton, scene.scale, scene.source, is_left_out);
  };
  BoneChoice choice = chosen(rigid.is_beside);
  if (is_prop || !choice.bones.empty()) return choice;
  std::vector<char> rigid_too = rigid.is_beside;
  for (std::size_t v = 0; v < rigid_too.size(); ++v)
    if (rigid.is_apart[v] != 0) rigid_too[v] = 1;
  std::vector<char> small_too = rigid_too;
  leave_out_small_parts(welded.surface, small_too);
  for (const std::vector<char>& more : {rigid_too, small_too}) {
    if (more == rigid.is_beside || std::count(more.begin(), more.end(), 0) == 0) continue;
    BoneChoice other = chosen(more);
    if (!other.bones.empty()) return other;
  }
  return choice;
}

// Fills all parts of a prop: it pushes by its tetrahedra.
Body body_of_one(const rig::Character& character, const scene::Scene& scene, bool is_prop, Report& report,
                 const BuildOptions& options) {
  const WeldedSurface welded = prepare_surface(character.surface, scene, report);
  Body body;
  const SkinWeights weights =
      welded_skin_weights(character, welded.of_vertex, welded.surface.vertices.size(), scene.source);
  RigidSkin rigid = find_rigid_parts(character, welded, weights, scene);
  BoneChoice choice = choose_bones_beside(character, welded, rigid, scene, is_prop);
  if (!choice.warning.empty() && !is_prop) warn_of_flesh(report, choice.warning);
  report.joints = std::move(choice.report);
  body.joints = std::move(choice.joints);
  body.bones = std::move(choice.bones);
  add_scene_bones(scene, body);
  if (is_prop) rigid.report.clear();
  report.rigid_parts = rigid.report;
  if (rigid.report.empty()) {
    take(fill_body({scene, character.surface, welded, body.bones, &character}, report, options), body);
  } else {
    const SoftSkin soft = without_rigid_parts(character, welded, rigid);
    if (!soft.welded.surface.triangles.empty())
      take(fill_body({scene, soft.character.surface, soft.welded, body.bones, &soft.character}, report,
                     options),
           body);
    add_rigid_parts(character, welded, rigid, soft, body);
  }
  body.joint_count = static_cast<std::uint32_t>(character.skeleton.size());
  body.painted = character.painted;
  body.parts = character.parts;
  body.skin_surface = character.surface;
  for (Vector3d& p : body.skin_surface.vertices) p *= scene.scale;
  if (body.holding.empty()) body.holding.assign(body.mesh.vertices.size(), Holding::none);
  seat_on_carriers(welded, weights, misled_riders(welded, weights, body), Sharing::alike, body);
  return body;
}

Body body_of(const rig::Character& character, const scene::Scene& scene, Report& report,
             const BuildOptions& options) {
  if (scene.characters.empty()) return body_of_one(character, scene, false, report, options);
  Body all;
  for (std::size_t k = 0; k < scene.characters.size(); ++k) {
    check_cancelled(options);
    Report found;
    const scene::PlacedCharacter& placed = scene.characters[k];
    Body one = body_of_one(placed.own, scene_of_character(scene, k), placed.settings.rigid, found, options);
    if (placed.settings.rigid) warn_of_thin_prop(one, scene.source, found);
    append_body(scene, k, std::move(one), std::move(found), all, report);
  }
  all.joint_count = static_cast<std::uint32_t>(character.skeleton.size());
  all.painted = character.painted;
  all.parts = character.parts;
  all.skin_surface = character.surface;
  for (Vector3d& p : all.skin_surface.vertices) p *= scene.scale;
  return all;
}

}  // namespace

BoneChoice bones_of(const rig::Character& character, const scene::Scene& scene, bool is_prop) {
  Report unread;
  const WeldedSurface welded = prepare_surface(character.surface, scene, unread);
  const SkinWeights weights =
      welded_skin_weights(character, welded.of_vertex, welded.surface.vertices.size(), scene.source);
  return choose_bones_beside(character, welded, find_rigid_parts(character, welded, weights, scene), scene,
                             is_prop);
}

std::size_t member_of(const Body& body, std::size_t vertex) {
  if (body.members.empty()) return 0;
  const std::uint32_t joint = body.skin.joint[body.skin.offset[vertex]];
  std::size_t k = 0;
  while (k + 1 < body.members.size() && body.members[k + 1].first_joint <= joint) ++k;
  return k;
}

Vector3d own_place(const Body& body, std::size_t vertex) {
  const Vector3d& place = body.mesh.vertices[vertex];
  return body.members.empty() ? place : Vector3d(place - body.members[member_of(body, vertex)].offset);
}

double diagonal_of_member(const Body& body) {
  std::vector<Vector3d> low(std::max<std::size_t>(body.members.size(), 1), Vector3d::Constant(INFINITY));
  std::vector<Vector3d> high(low.size(), Vector3d::Constant(-INFINITY));
  for (std::size_t i = 0; i < body.mesh.vertices.size(); ++i) {
    const std::size_t k = member_of(body, i);
    low[k] = low[k].cwiseMin(body.mesh.vertices[i]);
    high[k] = high[k].cwiseMax(body.mesh.vertices[i]);
  }
  double longest = 0.0;
  for (std::size_t k = 0; k < low.size(); ++k)
    if (low[k][0] <= high[k][0]) longest = std::max(longest, (high[k] - low[k]).norm());
  return longest;
}

Body make_body(const scene::Scene& scene, Report& report, const BuildOptions& options) {
  return std::visit([&](const auto& geometry) { return body_of(geometry, scene, report, options); },
                    scene.geometry);
}

}  // namespace fascicle::build
