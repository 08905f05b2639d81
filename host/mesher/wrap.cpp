#include "host/mesher/wrap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include "host/mesher/exit_codes.h"

namespace fascicle::mesher {
namespace {

namespace processing = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

// The number of vertices of a filled surface: on the surface, 2/sqrt(3) per squared edge of area, as
// with equilateral triangles; inside, where TetGen's tetrahedra of edge e hold one vertex per e^3/2.12. The
// volume term is for the surface moved inward by half an edge, where the inner vertices start. Measured on
// the heavy MakeHuman body at edges of 15, 20 and 30 mm.
double vertices_at(double area, double volume, double edge) {
  constexpr double per_area = 1.1547;
  constexpr double per_volume = 2.12;
  const double inner = std::max(0.0, volume - 0.5 * edge * area);
  return per_area * area / (edge * edge) + per_volume * inner / (edge * edge * edge);
}

// The edge at which vertices_at() equals `vertices`, by bisection: the number falls as the edge grows.
double edge_for(double area, double volume, double vertices) {
  double low = 0.0;
  double high = std::sqrt(area);
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2.0;
    (vertices_at(area, volume, middle) > vertices ? low : high) = middle;
  }
  return high;
}

Mesh wrapped(const Surface& surface, double alpha, double offset) {
  std::vector<Kernel::Point_3> points;
  points.reserve(surface.vertices.size());
  for (const Point& p : surface.vertices) points.emplace_back(p[0], p[1], p[2]);
  std::vector<std::array<std::size_t, 3>> triangles;
  triangles.reserve(surface.triangles.size());
  for (const auto& t : surface.triangles)
    triangles.push_back(
        {static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
  Mesh mesh;
  CGAL::alpha_wrap_3(points, triangles, alpha, offset, mesh);
  return mesh;
}

bool is_usable(const Mesh& mesh) {
  return mesh.number_of_faces() > 0 && CGAL::is_closed(mesh) && !processing::does_self_intersect(mesh);
}

// CGAL keeps edges between 4/5 and 4/3 of its target, and most are shorter than the target.
constexpr double target_of_edge = 1.09;

// CGAL's remeshing may make a thin part intersect itself. A finer target preserves more such parts.
std::optional<Mesh> remeshed(const Mesh& wrap, double edge) {
  for (const double part : {1.0, 0.8, 0.6}) {
    Mesh mesh = wrap;
    processing::isotropic_remeshing(faces(mesh), part * target_of_edge * edge, mesh,
                                    CGAL::parameters::number_of_iterations(3).number_of_relaxation_steps(1));
    mesh.collect_garbage();
    if (is_usable(mesh)) return mesh;
  }
  return std::nullopt;
}

Surface as_surface(const Mesh& mesh) {
  Surface surface;
  surface.vertices.reserve(mesh.number_of_vertices());
  for (const auto vertex : mesh.vertices()) {
    const Kernel::Point_3& p = mesh.point(vertex);
    surface.vertices.push_back({p.x(), p.y(), p.z()});
  }
  surface.triangles.reserve(mesh.number_of_faces());
  for (const auto face : mesh.faces()) {
    std::array<int, 3> triangle{};
    std::size_t k = 0;
    for (const auto vertex : CGAL::vertices_around_face(mesh.halfedge(face), mesh))
      triangle.at(k++) = static_cast<int>(vertex.idx());
    surface.triangles.push_back(triangle);
  }
  return surface;
}

}  // namespace

Wrap wrap(const Surface& surface, const WrapSettings& settings) {
  try {
    const Mesh mesh = wrapped(surface, settings.alpha, settings.offset);
    if (mesh.number_of_faces() == 0) throw Failure(wrap_failed, "the wrap is empty");
    if (!settings.edge && !settings.vertices) return {as_surface(mesh), settings.alpha, settings.offset};
    const double edge = settings.edge ? *settings.edge
                                      : edge_for(processing::area(mesh), processing::volume(mesh),
                                                 static_cast<double>(*settings.vertices));
    if (const auto found = remeshed(mesh, edge)) return {as_surface(*found), settings.alpha, settings.offset};
    // Sheets thinner than the triangles cannot be remeshed. A new wrap, offset by a third of an edge, makes
    // them thicker.
    constexpr double offset_in_edges = 1.0 / 3.0;
    const double offset = std::max(settings.offset, offset_in_edges * edge);
    if (const auto found = remeshed(wrapped(surface, edge, offset), edge))
      return {as_surface(*found), edge, offset};
    throw Failure(wrap_failed, "the wrapped surface crosses itself at triangles of that size");
  } catch (const std::logic_error& error) {  // how CGAL reports a violated precondition
    throw Failure(wrap_failed, std::string("CGAL gave up: ") + error.what());
  }
}

}  // namespace fascicle::mesher
