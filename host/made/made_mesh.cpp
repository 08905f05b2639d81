#include "host/made/made_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

namespace fascicle::made {
namespace {

constexpr std::uint32_t none = ~std::uint32_t{0};

// A half-edge: 3 x triangle + the corner it starts from. Twins are the same edge seen from both triangles.
struct Sides {
  std::vector<std::uint32_t> twin;

  explicit Sides(const mesh::SurfaceMesh& mesh) : twin(3 * mesh.triangles.size(), none) {
    struct Side {
      std::uint32_t low, high, side;
    };
    std::vector<Side> sides;
    sides.reserve(twin.size());
    for (std::uint32_t s = 0; s < twin.size(); ++s) {
      const std::uint32_t a = mesh.triangles[s / 3][s % 3], b = mesh.triangles[s / 3][(s + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), s});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
      return x.low != y.low ? x.low < y.low : x.high != y.high ? x.high < y.high : x.side < y.side;
    });
    for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {
      twin[sides[i].side] = sides[i + 1].side;
      twin[sides[i + 1].side] = sides[i].side;
    }
  }
};

std::uint32_t next_side(std::uint32_t side) {
  return side % 3 == 2 ? side - 2 : side + 1;
}

double cotangent(const Vector3d& apex, const Vector3d& a, const Vector3d& b) {
  const Vector3d u = a - apex, v = b - apex;
  return u.dot(v) / std::max(std::sqrt(u.cross(v).squaredNorm()), 1e-30);
}

Vector3d unit_normal(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  return normal / std::max(std::sqrt(normal.squaredNorm()), 1e-30);
}

// Whether two vertices share an edge. Walks around the first vertex, starting from one of its half-edges.
bool is_edge(const mesh::SurfaceMesh& mesh, const Sides& sides, std::uint32_t first, std::uint32_t other) {
  std::uint32_t side = first;
  do {
    if (mesh.triangles[side / 3][(side + 1) % 3] == other) return true;
    side = sides.twin[next_side(next_side(side))];
  } while (side != first);
  return false;
}

// Flips the edge a -> b: triangles (a b c) and (b a d) become (d b c) and (c a d), if that improves them.
bool flip(mesh::SurfaceMesh& mesh, Sides& sides, std::uint32_t ab) {
  const std::uint32_t ba = sides.twin[ab];
  const std::uint32_t bc = next_side(ab), ca = next_side(bc), ad = next_side(ba), db = next_side(ad);
  const auto vertex = [&](std::uint32_t side) { return mesh.triangles[side / 3][side % 3]; };
  const std::uint32_t a = vertex(ab), b = vertex(ba), c = vertex(ca), d = vertex(db);
  const Vector3d &pa = mesh.vertices[a], &pb = mesh.vertices[b], &pc = mesh.vertices[c],
                 &pd = mesh.vertices[d];
  // The sum of the angles at c and d exceeds 180 degrees if and only if the sum of their cotangents is
  // negative.
  constexpr double rounding = 1e-6;
  if (cotangent(pc, pa, pb) + cotangent(pd, pb, pa) > -rounding) return false;
  const Vector3d before = unit_normal(pa, pb, pc) + unit_normal(pb, pa, pd);
  const double length = std::sqrt(before.squaredNorm());
  const double least = 0.5 * length;  // the cosine of 60 degrees
  if (unit_normal(pd, pb, pc).dot(before) < least || unit_normal(pc, pa, pd).dot(before) < least)
    return false;
  if (c == d || is_edge(mesh, sides, ca, d)) return false;

  const std::uint32_t twin_bc = sides.twin[bc], twin_ad = sides.twin[ad];
  const std::uint32_t t0 = ab / 3, t1 = ba / 3;
  mesh.triangles[t0][ab % 3] = d;  // d b c: ab is now d -> b, bc stays, ca is now c -> d
  mesh.triangles[t1][ba % 3] = c;  // c a d: ba is now c -> a, ad stays, db is now d -> c
  const std::uint32_t twin_ca = sides.twin[ca], twin_db = sides.twin[db];
  const auto join = [&](std::uint32_t x, std::uint32_t y) {
    sides.twin[x] = y;
    sides.twin[y] = x;
  };
  join(ab, twin_db);
  join(ba, twin_ca);
  join(ca, db);
  join(bc, twin_bc);
  join(ad, twin_ad);
  return true;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> vertex_neighbours(const mesh::SurfaceMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.vertices.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) neighbours[t[c]].push_back(t[(c + 1) % 3]);
  for (auto& list : neighbours) std::sort(list.begin(), list.end());
  return neighbours;
}

void flip_to_delaunay(mesh::SurfaceMesh& mesh) {
  Sides sides(mesh);
  constexpr int most_passes = 20;
  for (int pass = 0; pass < most_passes; ++pass) {
    std::size_t flips = 0;
    for (std::uint32_t side = 0; side < sides.twin.size(); ++side)
      if (side < sides.twin[side]) flips += flip(mesh, sides, side) ? 1u : 0u;
    if (flips == 0) return;
  }
}

void smooth_tangentially(mesh::SurfaceMesh& mesh) {
  std::vector<Vector3d> normal(mesh.vertices.size(), Vector3d::Zero());
  std::vector<double> area(mesh.vertices.size(), 0.0);
  for (const auto& t : mesh.triangles) {
    const Vector3d across =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    const double size = std::sqrt(across.squaredNorm());
    for (const std::uint32_t v : t) {
      normal[v] += across;
      area[v] += size;
    }
  }
  const auto neighbours = vertex_neighbours(mesh);
  std::vector<Vector3d> moved = mesh.vertices;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    Vector3d mean = Vector3d::Zero();
    double weight = 0.0;
    for (const std::uint32_t j : neighbours[i]) {
      mean += area[j] * mesh.vertices[j];
      weight += area[j];
    }
    const Vector3d step = 0.7 * (mean / weight - mesh.vertices[i]);
    moved[i] += step - normal[i] * (step.dot(normal[i]) / std::max(normal[i].squaredNorm(), 1e-60));
  }
  mesh.vertices = std::move(moved);
}

}  // namespace fascicle::made
