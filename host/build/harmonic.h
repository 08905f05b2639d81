// Laplace's equation on a tetrahedral mesh: extends values given at some vertices to the others.
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
  std::vector<double> coupling;  // per entry of rings: the off-diagonal matrix entry
  std::vector<double> diagonal;  // per vertex
};

// Tetrahedra must have positive volume.
LaplaceMatrix laplace_matrix(const mesh::TetMesh& mesh);

// Solves for the vertices that are not `given`. Values given at a few vertices decay exponentially along a
// limb, so a solve works on the vertices it reaches and not on the whole mesh. Holds memory that solves
// reuse; use one object per thread.
class HarmonicExtension {
 public:
  // Values below this count as not reached. By the maximum principle it also bounds the error of omitting
  // them.
  static constexpr double negligible = 1e-5;

  // `is_given` has a flag per vertex. Both arguments must outlive this object.
  HarmonicExtension(const LaplaceMatrix& matrix, const std::vector<char>& is_given);

  // The solution at the vertices reached, by ascending vertex, if the given vertices hold `values` (by
  // ascending vertex, each given) or 0. It may leave the range of the values, as finite elements on flat
  // tetrahedra do. Nothing if the conjugate gradients do not converge.
  std::optional<std::vector<VertexValue>> extend(std::span<const VertexValue> values);

 private:
  void place_in_order();
  void restrict_matrix();
  bool solve(double tolerance);
  std::vector<std::uint32_t> reached_beyond() const;
  void reach_rings_around(std::vector<std::uint32_t> front, std::size_t rings);

  const LaplaceMatrix& matrix_;
  const std::vector<char>& is_given_;
  std::vector<std::uint32_t> place_;    // per vertex: its place in reached_, or nowhere
  std::vector<double> given_;           // per vertex: its given value
  std::vector<std::uint32_t> reached_;  // vertices solved for, ascending
  std::vector<double> value_;           // by place, like all below
  std::vector<std::uint32_t> row_, column_;
  std::vector<double> entry_, diagonal_, right_;
  std::vector<double> residual_, direction_, product_;
};

}  // namespace fascicle::build
