// Searches on surfaces, compared with exhaustive ones.
#include "host/build/surface_search.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/build/surfaces.h"

namespace fascicle::tests {
namespace {

using build::SurfacePoint;
using build::SurfaceSearch;
using mesh::SurfaceMesh;
using scene::Vector3d;

// Distributions of the standard library differ between implementations; this one does not.
class Random {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0;
  }
  Vector3d point(double half) { return {(*this)(-half, half), (*this)(-half, half), (*this)(-half, half)}; }

 private:
  std::mt19937 engine_{7};
};

// A torus around the y axis, facing outward.
SurfaceMesh torus(double radius, double tube, std::uint32_t around, std::uint32_t across) {
  SurfaceMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t k = 0; k < across; ++k) {
      const double u = 2.0 * M_PI * i / around, v = 2.0 * M_PI * k / across;
      const double r = radius + tube * std::cos(v);
      mesh.vertices.push_back({r * std::cos(u), tube * std::sin(v), r * std::sin(u)});
      const std::uint32_t next = (i + 1) % around, up = (k + 1) % across;
      mesh.triangles.push_back({i * across + k, i * across + up, next * across + k});
      mesh.triangles.push_back({next * across + k, i * across + up, next * across + up});
    }
  return mesh;
}

// Minimises over the triangle's interior and its sides, following the definition: a least-squares solve where
// the library uses cross products.
double distance_by_definition(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto to_segment = [&](const Vector3d& from, const Vector3d& to) {
    const double length2 = (to - from).squaredNorm();
    const double u = length2 > 0.0 ? std::min(std::max((p - from).dot(to - from) / length2, 0.0), 1.0) : 0.0;
    return (p - from - u * (to - from)).norm();
  };
  double best = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  Eigen::Matrix<double, 3, 2> sides;
  sides << b - a, c - a;
  const auto decomposed = sides.colPivHouseholderQr();
  if (decomposed.rank() < 2) return best;
  const Eigen::Vector2d x = decomposed.solve(p - a);
  if (x[0] >= 0.0 && x[1] >= 0.0 && x[0] + x[1] <= 1.0) best = std::min(best, (sides * x - (p - a)).norm());
  return best;
}

double distance_to_all(const SurfaceMesh& mesh, const Vector3d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles)
    best = std::min(best,
                    distance_by_definition(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  return best;
}

TEST(SurfaceSearch, NearestPlaceIsAsNearAsTheNearestOfAllTriangles) {
  const SurfaceMesh mesh = torus(1.0, 0.4, 40, 24);
  const SurfaceSearch search(mesh);
  Random random;
  for (int k = 0; k < 400; ++k) {
    const Vector3d p = random.point(1.8);
    const SurfacePoint found = search.nearest(p);
    // Two ways to compute a distance near 1 differ by rounding.
    EXPECT_NEAR(found.distance, distance_to_all(mesh, p), 1e-12);
    EXPECT_NEAR((found.point - p).norm(), found.distance, 1e-15);
    const auto& t = mesh.triangles[found.triangle];
    Vector3d place = Vector3d::Zero();
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_GE(found.weights[c], 0.0);
      sum += found.weights[c];
      place += found.weights[c] * mesh.vertices[t[c]];
    }
    EXPECT_NEAR(sum, 1.0, 1e-15);
    EXPECT_NEAR((place - found.point).norm(), 0.0, 1e-14);
    EXPECT_TRUE(search.is_nearer_than(p, found.distance * 1.000001));
    EXPECT_FALSE(search.is_nearer_than(p, found.distance * 0.999999));
  }
}

TEST(SurfaceSearch, AVertexIsFoundInItsOwnPlace) {
  const SurfaceMesh mesh = torus(1.0, 0.4, 16, 12);
  const SurfaceSearch search(mesh);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const SurfacePoint found = search.nearest(mesh.vertices[v]);
    // Rounding of coordinates near 1.
    EXPECT_LE(found.distance, 1e-15);
    const auto& t = mesh.triangles[found.triangle];
    const auto corner = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
    ASSERT_LT(corner, 3u);
    EXPECT_NEAR(found.weights[corner], 1.0, 1e-14);
  }
}

TEST(SurfaceSearch, OfTrianglesEquallyNearTheLowestIsFound) {
  SurfaceMesh mesh = torus(1.0, 0.4, 16, 12);
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  for (std::uint32_t k = 0; k < count; ++k) mesh.triangles.push_back(mesh.triangles[count - 1 - k]);
  const SurfaceSearch search(mesh);
  Random random;
  for (int k = 0; k < 200; ++k) EXPECT_LT(search.nearest(random.point(1.8)).triangle, count);
}

TEST(SurfaceSearch, TriangleDistanceIsTheSmallestOverThePlaneAndTheSides) {
  const Vector3d a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({1, 1, 3}, a, b, c).distance, 3.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({1, 1, -3}, a, b, c).distance, 3.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({2, -3, 4}, a, b, c).distance, 5.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({-3, 0, 4}, a, b, c).distance, 5.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({3, 3, 0}, a, b, c).distance, std::sqrt(2.0));
}

TEST(SurfaceSearch, TrianglesWithoutAreaAreSegmentsAndPoints) {
  const Vector3d a(0, 0, 0), b(4, 0, 0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({1, 2, 0}, a, b, {2, 0, 0}).distance, 2.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({1, 2, 0}, a, a, b).distance, 2.0);
  EXPECT_DOUBLE_EQ(build::nearest_on_triangle({3, 4, 0}, a, a, a).distance, 5.0);
  // A needle: its plane is lost in rounding, but its sides are not.
  EXPECT_NEAR(build::nearest_on_triangle({1, 2, 0}, a, b, {2, 1e-14, 1e-14}).distance, 2.0, 1e-12);
}

TEST(SurfaceSearch, InsideIsToldWhateverWayTheTrianglesFace) {
  SurfaceMesh cube = cube_surface(2.0);
  for (int turned = 0; turned < 2; ++turned) {
    const SurfaceSearch search(cube);
    for (double x = -1.75; x < 2.0; x += 0.5)
      for (double y = -1.75; y < 2.0; y += 0.5)
        for (double z = -1.75; z < 2.0; z += 0.5) {
          const bool inside = std::abs(x) < 1 && std::abs(y) < 1 && std::abs(z) < 1;
          EXPECT_EQ(search.is_inside({x, y, z}), inside);
          EXPECT_EQ(search.winding({x, y, z}), inside ? (turned ? -1 : 1) : 0);
        }
    for (auto& t : cube.triangles) std::swap(t[0], t[1]);
  }
}

// A solid whose inside has a closed form, at random points: the tree must not miss a crossing.
TEST(SurfaceSearch, InsideOfATorusIsWhereItsTubeIs) {
  const SurfaceMesh mesh = torus(1.0, 0.4, 64, 48);
  const SurfaceSearch search(mesh);
  Random random;
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d p = random.point(1.5);
    const double from_tube = std::hypot(std::hypot(p[0], p[2]) - 1.0, p[1]);
    // Facets are inside the tube by at most their sagitta: 1 - cos(pi/48) of the tube, 1 - cos(pi/64) of 1.4.
    if (std::abs(from_tube - 0.4) < 0.004) continue;
    inside += from_tube < 0.4;
    EXPECT_EQ(search.is_inside(p), from_tube < 0.4);
    EXPECT_EQ(search.winding(p), from_tube < 0.4 ? 1 : 0);
  }
  EXPECT_GT(inside, 200);
}

TEST(SurfaceSearch, WindingCountsTwiceWhereTheSurfaceOverlapsItself) {
  SurfaceMesh two = cube_surface(2.0);
  for (const Vector3d& p : cube_surface(2.0).vertices) two.vertices.push_back(p + Vector3d(1, 0, 0));
  for (const auto& t : cube_surface(2.0).triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  const SurfaceSearch search(two);
  EXPECT_EQ(search.winding({-0.5, 0.1, 0.2}), 1);
  EXPECT_EQ(search.winding({0.5, 0.1, 0.2}), 2);
  EXPECT_EQ(search.winding({1.5, 0.1, 0.2}), 1);
  EXPECT_EQ(search.winding({2.5, 0.1, 0.2}), 0);
  EXPECT_FALSE(search.is_inside({0.5, 0.1, 0.2}));
}

}  // namespace
}  // namespace fascicle::tests
