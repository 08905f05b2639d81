// Laplace's equation on a tetrahedral mesh: how values given at some vertices go on at the others.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/build/one_ring.h"
#include "host/scene/scene.h"

namespace fascicle::build {

struct VertexValue {
  std::uint32_t vertex;
  double value;
};

// The matrix of linear finite elements: sum over tetrahedra of volume grad_a . grad_b.
struct LaplaceMatrix {
  OneRings rings;
  std::vector<double> coupling;  // an entry of rings: the matrix' entry off the diagonal
  std::vector<double> diagonal;  // a vertex
};

// Tetrahedra of positive volume.
LaplaceMatrix laplace_matrix(const mesh::TetMesh& mesh);

// Solves for the vertices not `given`. Values given at few vertices fade fast, exponentially along a limb, so
// a solve works on the vertices that they reach and not on the whole mesh. Holds the memory that solves
// reuse: one for each thread.
class HarmonicExtension {
 public:
  // Values below this count as not reached. It bounds the error of leaving them out too, by the maximum
  // principle.
  static constexpr double negligible = 1e-5;

  // `is_given` has a flag for each vertex. Both must outlive it.
  HarmonicExtension(const LaplaceMatrix& matrix, const std::vector<char>& is_given);

  // The solution at the vertices reached, by ascending vertex, where the given vertices hold `values` (by
  // ascending vertex, each given) or 0. It may leave the range of the values: finite elements on flat
  // tetrahedra do. Nothing where the conjugate gradients do not converge.
  std::optional<std::vector<VertexValue>> extend(std::span<const VertexValue> values);

 private:
  void place_in_order();
  void restrict_matrix();
  bool solve(double tolerance);
  std::vector<std::uint32_t> reached_beyond() const;
  void reach_rings_around(std::vector<std::uint32_t> front, std::size_t rings);

  const LaplaceMatrix& matrix_;
  const std::vector<char>& is_given_;
  std::vector<std::uint32_t> place_;    // a vertex: its place in reached_, or nowhere
  std::vector<double> given_;           // a vertex: its given value
  std::vector<std::uint32_t> reached_;  // vertices solved for, ascending
  std::vector<double> value_;           // by place, like all below
  std::vector<std::uint32_t> row_, column_;
  std::vector<double> entry_, diagonal_, right_;
  std::vector<double> residual_, direction_, product_;
};

}  // namespace fascicle::build
