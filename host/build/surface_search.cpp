#include "host/build/surface_search.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

namespace fascicle::build {

namespace {

using mesh::SurfaceMesh;
using scene::Vector3d;

// A triangle whose doubled area is below this share of its longest side's square is searched as its sides:
// its plane is noise.
constexpr double flat_area = 1e-12;

// Squared distances that differ only by rounding count as equal: boxes at that distance are still opened.
constexpr double equally_near = 1.0 + 1e-12;

// Directions unlikely to lie along a plane or edge that an artist would draw.
const std::array<Vector3d, 3> ray_directions{
    Vector3d(0.8147, 0.4271, 0.3923), Vector3d(-0.3719, 0.6343, 0.6778), Vector3d(0.2137, -0.5839, 0.7832)};

std::vector<BoundingBox> boxes_of(const SurfaceMesh& surface) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(surface.triangles.size());
  for (const auto& t : surface.triangles)
    boxes.push_back(
        box_around(std::array{surface.vertices[t[0]], surface.vertices[t[1]], surface.vertices[t[2]]}));
  return boxes;
}

// The parameter, in [0, 1], of the point from -> to nearest to `point`.
double along_segment(const Vector3d& point, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length2 = along.squaredNorm();
  return length2 > 0.0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0.0;
}

}  // namespace

SurfacePoint nearest_on_triangle(const Vector3d& point, const Vector3d& a, const Vector3d& b,
                                 const Vector3d& c) {
  const std::array<Vector3d, 3> corner{a, b, c};
  const Vector3d ab = b - a, ac = c - a, bc = c - b;
  const Vector3d normal = ab.cross(ac);
  const double area2 = normal.squaredNorm();
  const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), bc.squaredNorm()});
  SurfacePoint result;
  if (area2 > flat_area * flat_area * longest2 * longest2) {
    const Vector3d ap = point - a;
    const double of_b = ap.cross(ac).dot(normal) / area2;
    const double of_c = ab.cross(ap).dot(normal) / area2;
    if (of_b >= 0.0 && of_c >= 0.0 && of_b + of_c <= 1.0) {
      result.weights = {1.0 - of_b - of_c, of_b, of_c};
      result.point = a + (of_b * ab + of_c * ac);
      result.distance = (point - result.point).norm();
      return result;
    }
  }
  result.distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double u = along_segment(point, corner[k], corner[next]);
    const Vector3d place = (1.0 - u) * corner[k] + u * corner[next];
    const double distance = (point - place).norm();
    if (!(distance < result.distance)) continue;
    result.distance = distance;
    result.point = place;
    result.weights = {};
    result.weights[k] = 1.0 - u;
    result.weights[next] = u;
  }
  return result;
}

SurfaceSearch::SurfaceSearch(const SurfaceMesh& surface) : surface_(surface), tree_(boxes_of(surface)) {}

SurfacePoint SurfaceSearch::nearest(const Vector3d& point) const {
  SurfacePoint best;
  best.distance = std::numeric_limits<double>::infinity();
  tree_.visit_near(point, best.distance, [&](std::uint32_t k) {
    const auto& t = surface_.triangles[k];
    SurfacePoint found =
        nearest_on_triangle(point, surface_.vertices[t[0]], surface_.vertices[t[1]], surface_.vertices[t[2]]);
    found.triangle = k;
    if (found.distance < best.distance || (found.distance == best.distance && k < best.triangle))
      best = found;
    return equally_near * best.distance * best.distance;
  });
  return best;
}

bool SurfaceSearch::is_nearer_than(const Vector3d& point, double distance) const {
  bool nearer = false;
  tree_.visit_near(point, distance * distance, [&](std::uint32_t k) {
    const auto& t = surface_.triangles[k];
    nearer = nearer || nearest_on_triangle(point, surface_.vertices[t[0]], surface_.vertices[t[1]],
                                           surface_.vertices[t[2]])
                               .distance < distance;
    // Below every distance: ends the search.
    return nearer ? -1.0 : distance * distance;
  });
  return nearer;
}

void SurfaceSearch::for_each_crossing(const Vector3d& origin, const Vector3d& direction,
                                      const std::function<void(std::uint32_t, bool)>& visit) const {
  tree_.visit_ray(origin, direction, [&](std::uint32_t k) {
    // Moeller and Trumbore, 1997.
    const auto& t = surface_.triangles[k];
    const Vector3d& a = surface_.vertices[t[0]];
    const Vector3d ab = surface_.vertices[t[1]] - a, ac = surface_.vertices[t[2]] - a;
    const Vector3d across = direction.cross(ac);
    const double determinant = ab.dot(across);
    if (determinant == 0.0) return;
    const Vector3d from_a = origin - a;
    const double u = from_a.dot(across) / determinant;
    const Vector3d q = from_a.cross(ab);
    const double v = direction.dot(q) / determinant;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0)) return;
    // The determinant is -direction . (ab x ac): negative if the ray leaves through an outward face.
    visit(k, determinant < 0.0);
  });
}

SurfaceSearch::Crossings SurfaceSearch::crossings(const Vector3d& origin, const Vector3d& direction) const {
  Crossings result;
  for_each_crossing(origin, direction, [&](std::uint32_t, bool is_outward) {
    ++result.all;
    result.outward += is_outward ? 1 : -1;
  });
  return result;
}

bool SurfaceSearch::is_inside(const Vector3d& point) const {
  int inside = 0;
  for (const Vector3d& direction : ray_directions) inside += crossings(point, direction).all % 2;
  return inside >= 2;
}

int SurfaceSearch::winding(const Vector3d& point) const {
  std::array<int, 3> answers{};
  for (std::size_t k = 0; k < 3; ++k) answers[k] = crossings(point, ray_directions[k]).outward;
  std::sort(answers.begin(), answers.end());
  return answers[1];
}

}  // namespace fascicle::build
