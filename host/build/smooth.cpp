#include "host/build/smooth.h"

#include <array>
#include <limits>

#include <Eigen/LU>

#include "host/build/boundary.h"
#include "host/build/mass.h"

namespace fascicle::build {

namespace {

using Eigen::Matrix3d;
using mesh::TetMesh;
using scene::Vector3d;

using Corners = std::array<std::uint32_t, 4>;

constexpr int sweeps = 8;
constexpr int most_halvings = 8;
// A step with a relative gain below this ends a vertex's turn.
constexpr double least_gain = 1e-3;

// 15552 = 6^3 72: a regular tetrahedron of edge a has L = 6 a^2 and V^2 = a^6 / 72.
constexpr double of_regular = 15552.0;

double squares_of_edges(const TetMesh& mesh, const Corners& t) {
  double sum = 0.0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b) sum += (mesh.vertices[t[a]] - mesh.vertices[t[b]]).squaredNorm();
  return sum;
}

// 1 / quality; infinite if the tetrahedron is flat or inverted.
double badness(const TetMesh& mesh, const Corners& t) {
  const double volume = signed_volume(mesh, t);
  if (!(volume > 0.0)) return std::numeric_limits<double>::infinity();
  const double edges = squares_of_edges(mesh, t);
  return edges * edges * edges / (of_regular * volume * volume);
}

class Smoother {
 public:
  Smoother(TetMesh& mesh, const std::vector<char>& fixed)
      : mesh_(mesh), stays_(fixed), offset_(mesh.vertices.size() + 1, 0) {
    for (const auto& triangle : boundary_triangles(mesh, "mesh"))
      for (const std::uint32_t corner : triangle) stays_[corner] = 1;
    for (const Corners& t : mesh.tetrahedra)
      for (const std::uint32_t corner : t) ++offset_[corner + 1];
    for (std::size_t i = 1; i < offset_.size(); ++i) offset_[i] += offset_[i - 1];
    touching_.resize(offset_.back());
    std::vector<std::uint32_t> next(offset_.begin(), offset_.end() - 1);
    for (std::uint32_t k = 0; k < mesh.tetrahedra.size(); ++k)
      for (const std::uint32_t corner : mesh.tetrahedra[k]) touching_[next[corner]++] = k;
  }

  void run() {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      bool has_moved = false;
      for (std::uint32_t i = 0; i < stays_.size(); ++i)
        if (!stays_[i]) has_moved |= move(i);
      if (!has_moved) return;
    }
  }

 private:
  double badness_around(std::uint32_t vertex) const {
    double sum = 0.0;
    for (std::uint32_t k = offset_[vertex]; k < offset_[vertex + 1]; ++k)
      sum += badness(mesh_, mesh_.tetrahedra[touching_[k]]);
    return sum;
  }

  // Newton's step on the sum of L^3 / V^2, with L the sum of the squared edges and V the volume. The term
  // that could make the second derivative negative, -3 (dL/L)(dL/L)^T, is omitted.
  Vector3d step_of(std::uint32_t vertex) const {
    Vector3d slope = Vector3d::Zero();
    Matrix3d bend = Matrix3d::Zero();
    for (std::uint32_t k = offset_[vertex]; k < offset_[vertex + 1]; ++k) {
      const Corners& t = mesh_.tetrahedra[touching_[k]];
      const std::size_t at = t[0] == vertex ? 0 : t[1] == vertex ? 1 : t[2] == vertex ? 2 : 3;
      const Vector3d& a = mesh_.vertices[t[(at + 1) % 4]];
      const Vector3d& b = mesh_.vertices[t[(at + 2) % 4]];
      const Vector3d& c = mesh_.vertices[t[(at + 3) % 4]];
      const double volume = signed_volume(mesh_, t), edges = squares_of_edges(mesh_, t);
      const double weight = edges * edges * edges / (of_regular * volume * volume);
      const Vector3d of_edges = (6.0 * mesh_.vertices[vertex] - 2.0 * (a + b + c)) / edges;
      // A sixth of the opposite face's area vector, towards the vertex.
      const Vector3d of_volume = (at % 2 == 0 ? -1.0 : 1.0) / (6.0 * volume) * (b - a).cross(c - a);
      const Vector3d both = 3.0 * of_edges - 2.0 * of_volume;
      slope += weight * both;
      bend += weight * (both * both.transpose() + 2.0 * (of_volume * of_volume.transpose()) +
                        18.0 / edges * Matrix3d::Identity());
    }
    return -(bend.inverse() * slope);
  }

  bool move(std::uint32_t vertex) {
    const Vector3d before = mesh_.vertices[vertex];
    const double bad = badness_around(vertex);
    Vector3d step = step_of(vertex);
    if (!step.allFinite()) return false;
    for (int k = 0; k < most_halvings; ++k, step /= 2.0) {
      mesh_.vertices[vertex] = before + step;
      const double now = badness_around(vertex);
      if (now < bad) return now < (1.0 - least_gain) * bad;
    }
    mesh_.vertices[vertex] = before;
    return false;
  }

  TetMesh& mesh_;
  std::vector<char> stays_;
  std::vector<std::uint32_t> offset_, touching_;  // tetrahedra of each vertex
};

}  // namespace

double shape_quality(const TetMesh& mesh, const Corners& tetrahedron) {
  const double volume = signed_volume(mesh, tetrahedron), edges = squares_of_edges(mesh, tetrahedron);
  return of_regular * volume * volume / (edges * edges * edges);
}

void smooth_inside(TetMesh& mesh, const std::vector<char>& fixed) {
  Smoother(mesh, fixed).run();
}

}  // namespace fascicle::build
