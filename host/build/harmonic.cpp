#include "host/build/harmonic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "host/build/mass.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();
// How many rings beyond the given vertices a solve first includes, and by how many it grows: some extra work
// on vertices that turn out not to be reached saves whole solves.
constexpr std::size_t first_rings = 4;
constexpr std::size_t more_rings = 3;
// Relative to the right-hand side, in the norm of the matrix's inverse diagonal. Solves before the last only
// determine the vertices reached.
constexpr double draft_tolerance = 1e-3;
constexpr double final_tolerance = 1e-8;
// The limit is the number of unknowns, but at least this.
constexpr std::size_t least_iterations = 1000;

}  // namespace

LaplaceMatrix laplace_matrix(const mesh::TetMesh& mesh) {
  LaplaceMatrix matrix{one_rings(mesh.vertices.size(), mesh.tetrahedra), {}, {}};
  matrix.coupling.assign(matrix.rings.neighbour.size(), 0.0);
  matrix.diagonal.assign(mesh.vertices.size(), 0.0);
  for (const auto& t : mesh.tetrahedra) {
    // 6 volume grad_k, which points from the face across to vertex k.
    std::array<Vector3d, 4> area;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3d& a = mesh.vertices[t[(k + 1) % 4]];
      const Vector3d normal = (mesh.vertices[t[(k + 2) % 4]] - a).cross(mesh.vertices[t[(k + 3) % 4]] - a);
      area[k] = k % 2 == 0 ? normal : Vector3d(-normal);
    }
    const double factor = 1.0 / (36.0 * signed_volume(mesh, t));
    for (std::size_t a = 0; a < 4; ++a) {
      matrix.diagonal[t[a]] += factor * area[a].squaredNorm();
      const auto ring = matrix.rings[t[a]];
      for (std::size_t b = 0; b < 4; ++b) {
        if (a == b) continue;
        const auto entry = std::lower_bound(ring.begin(), ring.end(), t[b]) - ring.begin();
        matrix.coupling[matrix.rings.offset[t[a]] + static_cast<std::size_t>(entry)] +=
            factor * area[a].dot(area[b]);
      }
    }
  }
  return matrix;
}

HarmonicExtension::HarmonicExtension(const LaplaceMatrix& matrix, const std::vector<char>& is_given)
    : matrix_(matrix), is_given_(is_given), place_(is_given.size(), nowhere), given_(is_given.size(), 0.0) {}

std::optional<std::vector<VertexValue>> HarmonicExtension::extend(std::span<const VertexValue> values) {
  std::vector<std::uint32_t> front;
  for (const VertexValue& v : values) {
    given_[v.vertex] = v.value;
    front.push_back(v.vertex);
  }
  reach_rings_around(front, first_rings);
  bool converged = true;
  for (double tolerance = draft_tolerance; converged;) {
    restrict_matrix();
    converged = solve(tolerance);
    front = reached_beyond();
    if (!front.empty())
      reach_rings_around(front, more_rings);
    else if (tolerance == final_tolerance)
      break;
    else
      tolerance = final_tolerance;
  }

  std::vector<VertexValue> result;
  for (std::size_t k = 0; k < reached_.size(); ++k) {
    result.push_back({reached_[k], value_[k]});
    place_[reached_[k]] = nowhere;
  }
  for (const VertexValue& v : values) given_[v.vertex] = 0.0;
  reached_.clear();
  value_.clear();
  if (!converged) return std::nullopt;
  return result;
}

// Adds the unknown vertices of `front` and those within `rings` steps of it to the reached ones.
void HarmonicExtension::reach_rings_around(std::vector<std::uint32_t> front, std::size_t rings) {
  const auto reach = [&](std::uint32_t vertex) {
    if (is_given_[vertex] || place_[vertex] != nowhere) return false;
    place_[vertex] = static_cast<std::uint32_t>(reached_.size());
    reached_.push_back(vertex);
    value_.push_back(0.0);
    return true;
  };
  for (const std::uint32_t vertex : front) reach(vertex);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t vertex : front)
      for (const std::uint32_t neighbour : matrix_.rings[vertex])
        if (reach(neighbour)) next.push_back(neighbour);
    front = std::move(next);
  }
  place_in_order();
}

// Makes sums run by ascending vertex, however the vertices were reached.
void HarmonicExtension::place_in_order() {
  std::vector<double> by_vertex_order(value_.size());
  std::vector<std::uint32_t> ordered = reached_;
  std::sort(ordered.begin(), ordered.end());
  for (std::uint32_t k = 0; k < ordered.size(); ++k) {
    by_vertex_order[k] = value_[place_[ordered[k]]];
    place_[ordered[k]] = k;
  }
  reached_ = std::move(ordered);
  value_ = std::move(by_vertex_order);
}

void HarmonicExtension::restrict_matrix() {
  row_.assign(1, 0);
  column_.clear();
  entry_.clear();
  diagonal_.clear();
  right_.clear();
  for (const std::uint32_t vertex : reached_) {
    double right = 0.0;
    for (std::uint32_t k = matrix_.rings.offset[vertex]; k < matrix_.rings.offset[vertex + 1]; ++k) {
      const std::uint32_t neighbour = matrix_.rings.neighbour[k];
      if (is_given_[neighbour]) {
        right -= matrix_.coupling[k] * given_[neighbour];
      } else if (place_[neighbour] != nowhere) {
        column_.push_back(place_[neighbour]);
        entry_.push_back(matrix_.coupling[k]);
      }
    }
    row_.push_back(static_cast<std::uint32_t>(column_.size()));
    diagonal_.push_back(matrix_.diagonal[vertex]);
    right_.push_back(right);
  }
}

// Conjugate gradients with a diagonal preconditioner, starting from the current values.
bool HarmonicExtension::solve(double tolerance) {
  const std::size_t count = reached_.size();
  const auto multiply = [&](const std::vector<double>& x) {
    for (std::size_t i = 0; i < count; ++i) {
      double sum = diagonal_[i] * x[i];
      for (std::uint32_t k = row_[i]; k < row_[i + 1]; ++k) sum += entry_[k] * x[column_[k]];
      product_[i] = sum;
    }
  };
  const auto preconditioned_norm = [&](const std::vector<double>& x) {
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) sum += x[i] * x[i] / diagonal_[i];
    return sum;
  };
  residual_.resize(count);
  direction_.resize(count);
  product_.resize(count);
  multiply(value_);
  for (std::size_t i = 0; i < count; ++i) {
    residual_[i] = right_[i] - product_[i];
    direction_[i] = residual_[i] / diagonal_[i];
  }
  const double goal = tolerance * tolerance * preconditioned_norm(right_);
  double rest = preconditioned_norm(residual_);
  for (std::size_t left = std::max(count, least_iterations); rest > goal; --left) {
    if (left == 0) return false;
    multiply(direction_);
    double curvature = 0.0;
    for (std::size_t i = 0; i < count; ++i) curvature += direction_[i] * product_[i];
    const double step = rest / curvature;
    if (!(curvature > 0.0) || !std::isfinite(step)) return false;
    for (std::size_t i = 0; i < count; ++i) {
      value_[i] += step * direction_[i];
      residual_[i] -= step * product_[i];
    }
    const double before = rest;
    rest = preconditioned_norm(residual_);
    const double turn = rest / before;
    for (std::size_t i = 0; i < count; ++i)
      direction_[i] = residual_[i] / diagonal_[i] + turn * direction_[i];
  }
  return std::isfinite(rest);
}

// Vertices adjacent to the reached ones that the values would reach.
std::vector<std::uint32_t> HarmonicExtension::reached_beyond() const {
  std::vector<std::uint32_t> rim;
  for (const std::uint32_t vertex : reached_)
    for (const std::uint32_t neighbour : matrix_.rings[vertex])
      if (!is_given_[neighbour] && place_[neighbour] == nowhere) rim.push_back(neighbour);
  std::sort(rim.begin(), rim.end());
  rim.erase(std::unique(rim.begin(), rim.end()), rim.end());
  std::erase_if(rim, [&](std::uint32_t vertex) {
    double sum = 0.0;
    for (std::uint32_t k = matrix_.rings.offset[vertex]; k < matrix_.rings.offset[vertex + 1]; ++k) {
      const std::uint32_t neighbour = matrix_.rings.neighbour[k];
      if (place_[neighbour] != nowhere) sum -= matrix_.coupling[k] * value_[place_[neighbour]];
    }
    return std::abs(sum) <= negligible * matrix_.diagonal[vertex];
  });
  return rim;
}

}  // namespace fascicle::build
