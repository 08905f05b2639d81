// Concave faces of surface files: their triangles cover them once, whichever corner is first.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <unistd.h>

#include "host/base/errors.h"
#include "host/mesh/mesh_file.h"
#include "host/mesh/surface_builder.h"
#include "tests/support/seed.h"

namespace fascicle::tests::polygon_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using mesh::SurfaceMesh;
using Triangle = std::array<std::uint32_t, 3>;

// A prism of height 1 over a polygon that is given counterclockwise.
struct Prism {
  std::vector<Vector3d> vertices;
  std::vector<std::vector<std::uint32_t>> faces;
};

Prism prism_over(const std::vector<Vector2d>& outline, std::size_t first) {
  Prism prism;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double height : {0.0, 1.0})
    for (const Vector2d& p : outline) prism.vertices.emplace_back(p.x(), p.y(), height);
  std::vector<std::uint32_t> bottom, top;
  for (std::uint32_t k = 0; k < n; ++k) {
    bottom.push_back(n - 1 - k);
    top.push_back(n + k);
    prism.faces.push_back({k, (k + 1) % n, n + (k + 1) % n, n + k});
  }
  for (auto* cap : {&bottom, &top}) {
    std::rotate(cap->begin(), cap->begin() + static_cast<std::ptrdiff_t>(first), cap->end());
    prism.faces.push_back(*cap);
  }
  return prism;
}

std::string off_of(const Prism& prism) {
  std::string text =
      "OFF\n" + std::to_string(prism.vertices.size()) + " " + std::to_string(prism.faces.size()) + " 0\n";
  for (const Vector3d& p : prism.vertices)
    text += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const auto& face : prism.faces) {
    text += std::to_string(face.size());
    for (const std::uint32_t v : face) text += " " + std::to_string(v);
    text += "\n";
  }
  return text;
}

std::string obj_of(const Prism& prism) {
  std::string text;
  for (const Vector3d& p : prism.vertices)
    text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const auto& face : prism.faces) {
    text += "f";
    for (const std::uint32_t v : face) text += " " + std::to_string(v + 1);
    text += "\n";
  }
  return text;
}

std::string ply_of(const Prism& prism) {
  const std::string off = off_of(prism);
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(prism.vertices.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(prism.faces.size()) + "\nproperty list int int vertex_indices\nend_header\n" +
         off.substr(off.find('\n', 4) + 1);
}

class Polygon : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "fascicle-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  SurfaceMesh read(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return mesh::read_surface_mesh(folder_ / name);
  }

  fs::path folder_;
};

// Three of four unit squares.
const std::vector<Vector2d> ell = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
// With corners on its straight sides, so that some triangles would be flat.
const std::vector<Vector2d> comb = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 2},   {2.5, 2}, {2.5, 1},
                                    {2, 1}, {2, 2}, {1, 2}, {1, 1}, {0.5, 1}, {0.5, 2}, {0, 2}};

double area_of(const std::vector<Vector2d>& outline) {
  double twice = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vector2d &a = outline[k], &b = outline[(k + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2.0;
}

// The caps' triangles all face out of the prism, and their areas are the outline's: nothing is covered twice.
void expect_prism(const SurfaceMesh& surface, const std::vector<Vector2d>& outline) {
  std::array<double, 2> caps{};
  double volume = 0.0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& t : surface.triangles) {
    const Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
    volume += a.dot(b.cross(c)) / 6.0;
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    if (a.z() != b.z() || b.z() != c.z()) continue;
    const double upward = (b - a).cross(c - a).z() / 2.0;
    EXPECT_GT(a.z() > 0.5 ? upward : -upward, 0.0);
    caps[a.z() > 0.5 ? 1 : 0] += std::abs(upward);
  }
  // Sums of at most forty numbers below 10.
  const double wanted = area_of(outline);
  EXPECT_NEAR(caps[0], wanted, 1e-12);
  EXPECT_NEAR(caps[1], wanted, 1e-12);
  EXPECT_NEAR(volume, wanted, 1e-12);
  EXPECT_EQ(surface.triangles.size(), 4 * outline.size() - 4);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u) << "the surface is open";
  }
}

TEST_F(Polygon, ConcaveFacesAreCoveredOnce) {
  EXPECT_EQ(area_of(ell), 3.0);
  for (const auto& outline : {ell, comb})
    for (std::size_t first = 0; first < outline.size(); ++first) {
      SCOPED_TRACE(std::to_string(outline.size()) + " corners, from " + std::to_string(first));
      const Prism prism = prism_over(outline, first);
      expect_prism(read("a.off", off_of(prism)), outline);
      expect_prism(read("a.obj", obj_of(prism)), outline);
      expect_prism(read("a.ply", ply_of(prism)), outline);
    }
}

// Any plane, any number of corners: stars with random rays.
TEST_F(Polygon, TrianglesOfStarsFaceOneWayAndAddUp) {
  std::mt19937_64 random(seed_of_run(3));
  std::uniform_real_distribution<double> ray(0.05, 1.0), any(-1.0, 1.0);
  for (std::size_t n = 4; n < 200; n += 1 + n / 8) {
    const Vector3d normal = Vector3d(any(random), any(random), any(random) + 1.1).normalized();
    const Vector3d x = normal.unitOrthogonal(), y = normal.cross(x), middle(any(random), any(random), 5.0);
    std::vector<Vector3d> vertices;
    std::vector<std::uint32_t> polygon;
    double area = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double angle = 6.283185307179586 * static_cast<double>(k) / static_cast<double>(n);
      vertices.push_back(middle + ray(random) * (std::cos(angle) * x + std::sin(angle) * y));
      polygon.push_back(static_cast<std::uint32_t>(k));
    }
    for (std::size_t k = 0; k < n; ++k)
      area += (vertices[k] - middle).cross(vertices[(k + 1) % n] - middle).dot(normal) / 2.0;
    const std::vector<Triangle> ears = mesh::cut_into_ears(vertices, polygon);
    EXPECT_EQ(ears.size(), n - 2);
    double sum = 0.0;
    for (const Triangle& t : ears) {
      const double up =
          (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]).dot(normal) / 2.0;
      EXPECT_GT(up, 0.0) << n;
      sum += up;
    }
    EXPECT_NEAR(sum, area, 1e-12 * static_cast<double>(n)) << n;
  }
}

// The order that bodies were built with before is part of their bits.
TEST_F(Polygon, FacesThatTheirFanCoversKeepIt) {
  const SurfaceMesh quad = read("a.off", "OFF\n4 1 0\n0 0 0\n2 0 0\n1 0.6 0\n0 2 0\n4 0 1 2 3\n");
  EXPECT_EQ(quad.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}})) << "concave, but not seen from 0";
  const SurfaceMesh line = read("b.off", "OFF\n4 1 0\n0 0 0\n1 -1e-8 0\n2 0 0\n0 2 0\n4 0 1 2 3\n");
  EXPECT_EQ(line.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

// A square with a square hole, cut open from one to the other.
TEST_F(Polygon, AFaceWithAHoleIsCovered) {
  const SurfaceMesh ring =
      read("a.obj",
           "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\n");
  double area = 0.0;
  for (const Triangle& t : ring.triangles) {
    const double up =
        (ring.vertices[t[1]] - ring.vertices[t[0]]).cross(ring.vertices[t[2]] - ring.vertices[t[0]]).z() /
        2.0;
    EXPECT_GT(up, 0.0);
    area += up;
  }
  EXPECT_NEAR(area, 8.0, 1e-12);
}

TEST_F(Polygon, RepeatedCornersAreLeftOutAndCounted) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const SurfaceMesh mesh = read("a.obj", square + "f 1 3 2 2\nf 1 1 3 3 4 1\nf 2 2 3\n");
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 1}, {0, 2, 3}}));
  EXPECT_EQ(mesh.repeated_corners, 5u);
  EXPECT_EQ(read("b.obj", square + "f 1 2 3\n").repeated_corners, 0u);
  const auto refusal = [&](const std::string& name, const std::string& content) -> std::string {
    try {
      read(name, content);
    } catch (const base::SceneError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(refusal("d.obj", square + "f 1 1 2\n").find("no face has three different corners"),
            std::string::npos);
  // A hair in line with an edge: the fan does without a triangle of one corner twice.
  EXPECT_EQ(read("e.obj", square + "v -1 1 0\nf 1 2 3 4 5 4\n").triangles.size(), 4u);
  EXPECT_NE(refusal("c.obj", square + "f 1 2 1 4\n").find("names vertex 1 (counted from 1) twice"),
            std::string::npos)
      << refusal("c.obj", square + "f 1 2 1 4\n");
  EXPECT_NE(refusal("c.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 0 2\n").find("0 (counted from 0) twice"),
            std::string::npos);
}

}  // namespace
}  // namespace fascicle::tests::polygon_test
