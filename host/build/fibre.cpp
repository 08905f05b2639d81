#include "host/build/fibre.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <Eigen/Geometry>

#include "host/build/boundary.h"
#include "host/build/message.h"
#include "host/build/surface_search.h"

namespace fascicle::build {

namespace {

// A direction whose part in the tangent plane is shorter than this (sine of 6 degrees) is undefined there.
constexpr double least_in_plane = 0.1;
// Painted directions shorter than this are unpainted.
constexpr double least_painted = 0.1;
const char* const painted_fibre = "_FIBER";

// Unit directions of the bones; 0 for points. Each has dot >= 0 with its parent bone.
std::vector<Vector3d> bone_directions(const std::vector<Bone>& bones) {
  std::vector<Vector3d> direction(bones.size(), Vector3d::Zero());
  for (std::size_t b = 0; b < bones.size(); ++b) {
    const Vector3d along = bones[b].to - bones[b].from;
    if (along.norm() > 0.0) direction[b] = along.normalized();
  }
  // Parents before children, in whatever order they are listed: as many passes as a chain has bones.
  for (std::size_t pass = 0; pass < bones.size(); ++pass) {
    bool turned = false;
    for (std::size_t b = 0; b < bones.size(); ++b)
      for (std::size_t parent = 0; parent < bones.size(); ++parent) {
        if (bones[b].owners[0] < 0 || bones[parent].owners[2] != bones[b].owners[0]) continue;
        if (direction[b].dot(direction[parent]) >= 0.0) continue;
        direction[b] = -direction[b];
        turned = true;
      }
    if (!turned) break;
  }
  return direction;
}

struct Boundary {
  mesh::SurfaceMesh boundary;
  std::vector<Vector3d> normal;  // per vertex: sum of its triangles' area vectors; 0 inside
};

Boundary boundary_of(const Body& body) {
  Boundary skin{{body.mesh.vertices, boundary_triangles(body.mesh, "mesh")}, {}};
  skin.normal.assign(body.mesh.vertices.size(), Vector3d::Zero());
  for (const auto& t : skin.boundary.triangles) {
    const Vector3d& a = skin.boundary.vertices[t[0]];
    const Vector3d area = (skin.boundary.vertices[t[1]] - a).cross(skin.boundary.vertices[t[2]] - a) / 2.0;
    for (const std::uint32_t corner : t) skin.normal[corner] += area;
  }
  return skin;
}

// The direction projected into the plane across `normal`, or 0 if it is nearly perpendicular to the plane.
Vector3d in_tangent_plane(const Vector3d& direction, const Vector3d& normal) {
  const double length = normal.norm();
  if (!(length > 0.0)) return Vector3d::Zero();
  const Vector3d flat = direction - direction.dot(normal / length) * (normal / length);
  return flat.norm() >= least_in_plane ? Vector3d(flat.normalized()) : Vector3d::Zero();
}

// The painted direction at each boundary vertex, interpolated at the nearest place of the character's skin.
std::vector<Vector3d> painted_directions(const Body& body, const Boundary& skin) {
  std::vector<Vector3d> direction(body.mesh.vertices.size(), Vector3d::Zero());
  const auto attribute =
      std::find_if(body.painted.begin(), body.painted.end(),
                   [](const rig::PaintedAttribute& a) { return a.name == painted_fibre && a.width >= 3; });
  if (attribute == body.painted.end()) return direction;
  const SurfaceSearch search(body.skin_surface);
  for (std::size_t i = 0; i < direction.size(); ++i) {
    if (skin.normal[i] == Vector3d::Zero()) continue;
    const SurfacePoint place = search.nearest(body.mesh.vertices[i]);
    Vector3d sum = Vector3d::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      const double* value =
          &attribute->values[attribute->width * body.skin_surface.triangles[place.triangle][c]];
      const Vector3d corner(value[0], value[1], value[2]);
      sum += (sum.dot(corner) < 0.0 ? -1.0 : 1.0) * place.weights[c] * corner;
    }
    if (sum.norm() >= least_painted) direction[i] = in_tangent_plane(sum.normalized(), skin.normal[i]);
  }
  return direction;
}

// The direction of the nearest drawn curve whose radius includes the point, or 0.
Vector3d drawn_direction(const std::vector<scene::FibreCurve>& curves, const Vector3d& point,
                         double mean_edge) {
  Vector3d direction = Vector3d::Zero();
  double nearest = 0.0;
  for (const scene::FibreCurve& curve : curves)
    for (std::size_t k = 0; k + 1 < curve.points.size(); ++k) {
      const double distance = segment_distance(point, curve.points[k], curve.points[k + 1]);
      if (distance > curve.radius.value_or(mean_edge)) continue;
      if (direction != Vector3d::Zero() && distance >= nearest) continue;
      nearest = distance;
      direction = (curve.points[k + 1] - curve.points[k]).normalized();
    }
  return direction;
}

double mean_edge_of(const std::vector<Vector3d>& vertices, const OneRings& rings) {
  double sum = 0.0;
  for (std::size_t i = 0; i < rings.size(); ++i)
    for (const std::uint32_t j : rings[i]) sum += (vertices[j] - vertices[i]).norm();
  return sum / static_cast<double>(std::max<std::size_t>(rings.neighbour.size(), 1));
}

void count_edges(const std::vector<Vector3d>& direction, const OneRings& rings, FibreReport& report) {
  constexpr double cosine_of_60 = 0.5;
  for (std::size_t i = 0; i < rings.size(); ++i)
    for (const std::uint32_t j : rings[i]) {
      if (j < i || direction[i] == Vector3d::Zero() || direction[j] == Vector3d::Zero()) continue;
      const double cosine = direction[i].dot(direction[j]);
      ++report.edges;
      report.flipped_edges += cosine < 0.0 ? 1u : 0u;
      report.bent_edges += std::abs(cosine) < cosine_of_60 ? 1u : 0u;
    }
}

std::vector<Vector3d> solve_field(const scene::Scene& scene, const std::vector<std::uint32_t>& layer_of,
                                  const OneRings& rings, Measures& measures, Report& report) {
  const auto start = std::chrono::steady_clock::now();
  const std::vector<Vector3d>& vertices = measures.body().mesh.vertices;
  const std::vector<FibreConstraint> constraints =
      fibre_constraints(scene, layer_of, mean_edge_of(vertices, rings), measures);
  if (constraints.empty())
    fail(scene.source,
         "layers: fibre_field is set, but nothing gives the fibres a direction; add [bones.NAME] or draw "
         "[fibres.NAME]");
  const FibreSolution solution = solve_fibre_field(vertices, rings, constraints);
  if (!solution.has_converged)
    fail(scene.source,
         "layers: the fibre field could not be solved; the tetrahedra are too uneven, use "
         "another resolution, or give the layers one `fibre` each");
  FibreReport& fibres = report.fibres;
  fibres.constraints = static_cast<std::uint32_t>(constraints.size());
  fibres.rounds = solution.rounds;
  fibres.iterations = solution.iterations;
  count_edges(solution.direction, rings, fibres);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (scene.layers[layer_of[i]].fibre_field && solution.direction[i] == Vector3d::Zero()) ++fibres.without;
  fibres.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return solution.direction;
}

}  // namespace

std::vector<FibreConstraint> fibre_constraints(const scene::Scene& scene,
                                               const std::vector<std::uint32_t>& layer_of, double mean_edge,
                                               Measures& measures) {
  const Body& body = measures.body();
  const std::vector<Vector3d> along = bone_directions(body.bones);
  const Boundary skin = boundary_of(body);
  const std::vector<Vector3d> painted = painted_directions(body, skin);
  std::vector<FibreConstraint> constraints;
  for (std::uint32_t i = 0; i < layer_of.size(); ++i) {
    const Vector3d bone =
        body.bones.empty() ? Vector3d(Vector3d::Zero()) : along[measures.nearest_bones()[i].bone];
    Vector3d direction = Vector3d::Zero();
    if (scene.layers[layer_of[i]].kinematic) direction = bone;
    if (direction == Vector3d::Zero())
      direction = drawn_direction(scene.fibres, own_place(body, i), mean_edge);
    if (direction == Vector3d::Zero()) direction = painted[i];
    if (direction == Vector3d::Zero()) direction = in_tangent_plane(bone, skin.normal[i]);
    if (direction != Vector3d::Zero()) constraints.push_back({i, direction});
  }
  return constraints;
}

std::vector<float> fibre_directions(const scene::Scene& scene, const std::vector<std::uint32_t>& layer_of,
                                    const OneRings& rings, Measures& measures, Report& report) {
  const bool needs_field = std::any_of(layer_of.begin(), layer_of.end(),
                                       [&](std::uint32_t l) { return scene.layers[l].fibre_field; });
  std::vector<Vector3d> field;
  if (needs_field) field = solve_field(scene, layer_of, rings, measures, report);
  std::vector<float> directions;
  directions.reserve(3 * layer_of.size());
  for (std::size_t i = 0; i < layer_of.size(); ++i) {
    const scene::Layer& layer = scene.layers[layer_of[i]];
    Vector3d d = layer.fibre_field ? field[i] : layer.fibre.value_or(Vector3d::Zero());
    const double length = d.norm();
    if (length > 0.0) d /= length;
    for (int a = 0; a < 3; ++a) directions.push_back(static_cast<float>(d[a]));
  }
  return directions;
}

}  // namespace fascicle::build
