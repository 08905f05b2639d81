#include "host/build/body_mesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "host/build/bones.h"
#include "host/build/box_tree.h"
#include "host/build/caps.h"
#include "host/build/check_mesh.h"
#include "host/build/cut.h"
#include "host/build/hold.h"
#include "host/build/mesher.h"
#include "host/build/message.h"
#include "host/build/partings.h"
#include "host/build/smooth.h"
#include "host/build/spacing.h"
#include "host/build/tetrahedralize.h"
#include "host/build/wrap.h"

namespace fascicle::build {

namespace {

// A cage's default number of vertices, approximately.
constexpr std::uint32_t default_vertices = 20000;
// The largest spacing ratio that a character's own skin may have: explicit stiffness depends on the square of
// the spacing.
constexpr double most_uneven = 4.0;
// A cage need not resolve gaps finer than this many of its edges.
constexpr double alpha_in_edges = 1.0;
// Skin of two limbs is cut apart if it is this many edges apart along the skin and has less than this in
// common. At 5 edges and nothing in common joining would be wrong; these limits are well below.
constexpr double separate_edges = 3.0;
constexpr double separate_shares = 0.2;
// Skin is also cut apart if it is at most touching_edges apart in the bind pose, and a clip moves it
// parting_edges farther apart.
constexpr double touching_edges = 1.5;
constexpr double parting_edges = 1.0;
// How far the cage's vertices may move to hold the skin, in edges.
constexpr double farthest_in_edges = 2.0;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Describes what keeps a skin from being filled as it is; empty if nothing does.
std::string defects_of(const SurfaceFindings& findings) {
  std::string text;
  const auto add = [&](const Finding& finding, const char* one, const char* many, std::uint64_t allowed = 0) {
    if (finding.count <= allowed) return;
    text += (text.empty() ? "" : ", ") + counted(finding.count, one, many);
  };
  add(findings.parts, "part", "parts", 1);
  add(findings.open_edges, "open edge", "open edges");
  add(findings.non_manifold_edges, "edge of more than two triangles", "edges of more than two triangles");
  add(findings.non_manifold_vertices, "vertex where parts meet in a point",
      "vertices where parts meet in a point");
  add(findings.turned_edges, "edge between triangles that face opposite ways",
      "edges between triangles that face opposite ways");
  add(findings.intersections, "pair of triangles that cross", "pairs of triangles that cross");
  add(findings.flat_triangles, "triangle without area", "triangles without area");
  return text;
}

struct Choice {
  bool is_cage = false;
  std::string reason;
};

Choice choose(const Skin& skin, const scene::Scene& scene, const CageReport& cage) {
  if (scene.body.cage == scene::Cage::wrap) return {true, "requested"};
  if (scene.body.cage == scene::Cage::off) return {false, "requested"};
  const std::string defects = defects_of(cage.findings);
  if (!defects.empty()) return {true, "the skin has " + defects};
  if (skin.skeleton.empty()) return {false, "the skin encloses a volume"};
  if (cage.skin_spacing.ratio() > most_uneven)
    return {true, "the skin is uneven: its spacing differs by a factor of " +
                      std::to_string(static_cast<int>(std::lround(cage.skin_spacing.ratio()))) +
                      " from the 1st to the 99th percentile"};
  if (skin.welded.surface.vertices.size() > scene.body.vertices.value_or(default_vertices))
    return {true, "the skin alone has more vertices than the whole body should have"};
  return {false, "the skin encloses a volume and is even"};
}

// Edge length at which `vertices` fill a volume: TetGen makes about 1.3 per cube of the edge. Uses bisection
// because the C library's roots differ between processors.
double edge_to_fill(double volume, double vertices) {
  constexpr double per_volume = 1.3;
  const double cube = per_volume * volume / vertices;
  double low = 0.0, high = 1.0 + cube;
  for (int k = 0; k < 100; ++k) {
    const double middle = (low + high) / 2.0;
    (middle * middle * middle > cube ? high : low) = middle;
  }
  return high;
}

// Edge length at which `vertices` cover a surface.
double edge_to_cover(const mesh::SurfaceMesh& surface, double vertices) {
  double area = 0.0;
  for (const auto& t : surface.triangles) {
    const Vector3d& a = surface.vertices[t[0]];
    area += 0.5 * (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm();
  }
  return std::sqrt(2.0 / std::sqrt(3.0) * area / vertices);
}

// The edge length that a cage with so many vertices will have. For a nearly flat skin the volume says
// nothing: its vertices go to the surface.
double edge_of_cage(const mesh::SurfaceMesh& surface, double volume, double vertices) {
  constexpr double least_of_cover = 0.5;
  return std::max(edge_to_fill(volume, vertices), least_of_cover * edge_to_cover(surface, vertices));
}

// One flag per vertex: whether it is one of the points.
std::vector<char> vertices_at(std::vector<Vector3d> points, const mesh::TetMesh& mesh) {
  const auto before = [](const Vector3d& a, const Vector3d& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  };
  std::sort(points.begin(), points.end(), before);
  std::vector<char> is_one;
  is_one.reserve(mesh.vertices.size());
  for (const Vector3d& p : mesh.vertices)
    is_one.push_back(std::binary_search(points.begin(), points.end(), p, before) ? 1 : 0);
  return is_one;
}

// For a kept skin, only the inside can adapt.
double edge_of_kept(const mesh::SurfaceMesh& surface, std::uint32_t vertices) {
  constexpr double coarsest = 4.0;
  const double mean = mean_edge(surface);
  if (vertices <= surface.vertices.size()) return coarsest * mean;
  const auto inner = static_cast<double>(vertices - surface.vertices.size());
  return std::min(coarsest * mean, edge_to_fill(std::abs(enclosed_volume(surface)), inner));
}

BodyMesh keep_skin(const Skin& skin, const scene::Scene& scene, Report& report, const BuildOptions& options) {
  const mesh::SurfaceMesh& surface = skin.welded.surface;
  const double spacing = scene.body.vertices ? edge_of_kept(surface, *scene.body.vertices)
                                             : scene.resolution.value_or(mean_edge(surface));
  const auto start = std::chrono::steady_clock::now();
  BodyMesh body;
  const std::vector<Vector3d> on_bones = points_along_bones(skin.bones, surface, spacing);
  body.mesh = tetrahedralize(surface, spacing, on_bones, options);
  check_cancelled(options);
  smooth_inside(body.mesh, vertices_at(on_bones, body.mesh));
  report.fill.cage.fill_seconds = seconds_since(start);
  if (scene.body.vertices && body.mesh.vertices.size() > 2 * std::size_t{*scene.body.vertices})
    warn_of_flesh(
        report,
        "the kept skin alone has " + std::to_string(surface.vertices.size()) +
            " vertices, so only the inside has the requested resolution; set cage = \"wrap\" to remesh "
            "the skin");
  return body;
}

// The joint that moves most of the given vertices of the skin; -1 if nothing moves them.
std::int32_t joint_of(const std::vector<std::uint32_t>& vertices, const Skin& skin) {
  if (skin.weights.offset.empty()) return -1;
  std::vector<double> share(skin.skeleton.size(), 0.0);
  for (const std::uint32_t v : vertices)
    for (std::uint32_t k = skin.weights.offset[v]; k < skin.weights.offset[v + 1]; ++k)
      share[skin.weights.joint[k]] += skin.weights.weight[k];
  return static_cast<std::int32_t>(std::max_element(share.begin(), share.end()) - share.begin());
}

mesh::SurfaceMesh close_ends(const Skin& skin, double alpha, CageReport& cage, const BuildOptions& options) {
  const mesh::SurfaceMesh& surface = skin.welded.surface;
  const Limbs limbs(surface, skin.weights, skin.skeleton, {separate_edges * alpha, separate_shares});
  const std::vector<OpenEnd> ends = find_open_ends(surface, limbs, options);
  for (const OpenEnd& end : ends) {
    cage.ends.vertex.push_back(end.loop[0]);
    cage.ends.edges.push_back(static_cast<std::uint32_t>(end.loop.size()));
    cage.ends.joint.push_back(joint_of(end.loop, skin));
    cage.ends.width.push_back(end.width);
    cage.ends.fate.push_back(static_cast<std::uint8_t>(end.fate));
  }
  return with_caps(surface, ends);
}

// Farther out than ordered, the body is thicker, and parts that do not touch may be one.
void warn_of_wider_wrap(const WrapOrder& order, const Wrap& wrap, Report& report) {
  constexpr double offset_of_alpha = 1.0 / 30.0, rounding = 1.01;
  const double offset = order.offset > 0.0 ? order.offset : offset_of_alpha * order.alpha;
  if (wrap.alpha == order.alpha && wrap.offset <= rounding * offset) return;
  std::ostringstream text;
  text << std::setprecision(3)
       << "the skin has parts or gaps too thin for the cage's triangles, so the cage lies "
       << 1e3 * wrap.offset << " mm outside it, and skin less than about " << 2e3 * wrap.alpha
       << " mm apart is joined; use a smaller resolution (edge length) or more vertices";
  warn_of_flesh(report, text.str());
}

BodyMesh make_cage(const Skin& skin, const scene::Scene& scene, Report& report, const BuildOptions& options) {
  const mesh::SurfaceMesh& surface = skin.welded.surface;
  const BoundingBox box = box_around(surface.vertices);
  WrapOrder order;
  order.alpha = order.gap = (box.high - box.low).norm() / scene.body.cage_detail;
  if (!scene.body.vertices) order.edge = scene.resolution;
  if (!order.edge) order.vertices = scene.body.vertices.value_or(default_vertices);
  std::optional<double> wanted_edge = order.edge;
  if (!wanted_edge && report.fill.cage.skin_volume > 0.0)
    wanted_edge = edge_of_cage(surface, report.fill.cage.skin_volume, *order.vertices);
  if (wanted_edge) order.alpha = std::min(order.alpha, alpha_in_edges * *wanted_edge);
  order.offset = scene.body.thickness;

  auto start = std::chrono::steady_clock::now();
  const Wrap wrapped = wrap_surface(close_ends(skin, order.alpha, report.fill.cage, options), order, options);
  const mesh::SurfaceMesh& wrap = wrapped.surface;
  report.fill.cage.alpha = wrapped.alpha;
  report.fill.cage.offset = wrapped.offset;
  report.fill.cage.wrap_seconds = seconds_since(start);
  warn_of_wider_wrap(order, wrapped, report);
  start = std::chrono::steady_clock::now();
  const double edge = mean_edge(wrap);
  const std::vector<Vector3d> on_bones = points_along_bones(skin.bones, wrap, edge);
  mesh::TetMesh filled = tetrahedralize(wrap, edge, on_bones, options);
  check_cancelled(options);
  smooth_inside(filled, vertices_at(on_bones, filled));
  check_cancelled(options);
  report.fill.cage.fill_seconds = seconds_since(start);

  start = std::chrono::steady_clock::now();
  const auto poses = skin.character != nullptr ? poses_of_clips(*skin.character, scene.scale)
                                               : std::vector<std::vector<Eigen::Matrix4d>>();
  const Partings partings(surface, skin.weights, poses, touching_edges * edge, parting_edges * edge);
  const Limbs limbs(surface, skin.weights, skin.skeleton, {separate_edges * edge, separate_shares},
                    &partings);
  CutMesh cut = cut_limbs(filled, surface, limbs);
  check_cancelled(options);
  Hold hold = hold_skin(cut, surface, farthest_in_edges * edge, vertices_at(on_bones, cut.mesh));
  report.fill.cage.cut_tetrahedra = cut.cut_tetrahedra;
  report.fill.cage.cut_seconds = seconds_since(start);
  return {std::move(cut.mesh), false, std::move(cut.anchor), std::move(hold.home)};
}

// The file's author has no tetrahedra to repair, so flat ones are reported as a fault of the surface.
void refuse_flat_fill(const mesh::TetMesh& mesh, bool is_cage, const std::string& source) {
  const std::vector<std::uint32_t> flat = tetrahedra_without_volume(mesh);
  if (flat.empty()) return;
  const Vector3d& at = mesh.vertices[mesh.tetrahedra[flat[0]][0]];
  std::ostringstream text;
  text << "mesh: " << counted(flat.size(), "tetrahedron that fills", "tetrahedra that fill")
       << " the surface would have no volume, near (" << at[0] << " " << at[1] << " " << at[2]
       << ") m; the surface is too flat or too finely folded there. "
       << (is_cage ? "Thicken it, or set another --resolution or --cage-detail"
                   : "Thicken it, or use --cage wrap");
  fail(source, text.str());
}

}  // namespace

BodyMesh make_body_mesh(const Skin& skin, const scene::Scene& scene, Report& report,
                        const BuildOptions& options) {
  CageReport& cage = report.fill.cage;
  const mesh::SurfaceMesh& surface = skin.welded.surface;
  cage.has_skin = true;
  BodyMesh body;
  try {
    cage.findings = find_defects(surface, options);
    cage.skin_spacing = vertex_spacing(surface);
    if (cage.findings.open_edges.count == 0) cage.skin_volume = std::abs(enclosed_volume(surface));
    const Choice choice = choose(skin, scene, cage);
    cage.is_cage = choice.is_cage;
    cage.reason = choice.reason;
    body = choice.is_cage ? make_cage(skin, scene, report, options) : keep_skin(skin, scene, report, options);
  } catch (const scene::SceneError& error) {
    const bool renumbered =
        surface.vertices.size() != skin.welded.of_vertex.size() || !skin.welded.file_vertex.empty();
    fail(scene.source, "mesh: " + std::string(error.what()) +
                           (renumbered ? " (vertices are counted after welding equal ones" : "") +
                           (renumbered && !skin.welded.file_vertex.empty() ? ", without rigid parts" : "") +
                           (renumbered ? ")" : ""));
  }
  refuse_flat_fill(body.mesh, cage.is_cage, scene.source);
  check_and_orient(body.mesh, scene.source, report);
  cage.spacing = vertex_spacing(body.mesh);
  cage.edges = edge_lengths(body.mesh);
  return body;
}

void add_mesh_settings(base::ContentHash& hash, const scene::Scene& scene) {
  hash.add(scene.resolution.has_value());
  hash.add(scene.resolution.value_or(0.0));
  hash.add(std::string_view(name_of(scene.body.cage)));
  hash.add(scene.body.cage_detail);
  hash.add(scene.body.vertices.has_value());
  hash.add(std::uint64_t{scene.body.vertices.value_or(0)});
  if (scene.body.thickness > 0.0) hash.add(scene.body.thickness);
}

}  // namespace fascicle::build
