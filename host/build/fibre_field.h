// The fibre field (3.3): a direction for each vertex that varies smoothly between given directions.
//
//   min over d of  sum_i | d_i - sum_{j in one-ring(i)} rho_ij d_j |^2
//                  + lambda sum_{k in C} | d_k - c_k |^2                                       (1) (2)
//   rho_ij = exp(-r_ij) / sum_{k in one-ring(i)} exp(-r_ik),   r_ij = |q0_i - q0_j|            (3)
//
// with r in mean edge lengths, so that the result does not depend on the unit of the mesh. The normal
// equations (M^T M + lambda C) d = lambda C c with M = 1 - rho are solved by conjugate gradients with a
// diagonal preconditioner. Sums have a fixed order, for the same bits on every machine.
//
// Fibres are lines, so d and -d mean the same. The equations as printed treat opposed directions that meet
// (at groins, shoulders, necks) as a contradiction and cancel them. So they are solved again, with rho_ij d_j
// flipped to the side of d_i wherever the last solution has them opposed, until almost no edge is flipped.
// The result is then the field of lines; its signs may still differ between neighbouring vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/build/body.h"
#include "host/build/one_ring.h"

namespace fascicle::build {

struct FibreConstraint {
  std::uint32_t vertex = 0;  // each at most once
  Vector3d direction;        // unit
};

struct FibreOptions {
  double lambda = 1e3;
  double tolerance = 1e-8;        // of the residual, relative to the right-hand side
  std::uint32_t most_rounds = 6;  // 1: the equations as printed
};

struct FibreSolution {
  std::vector<Vector3d> direction;  // unit; 0 0 0: no fibre
  std::uint32_t rounds = 0;
  std::uint32_t iterations = 0;  // in all rounds
  bool has_converged = true;
};

// A vertex whose solution is shorter than 1e-6 has no fibre; nor has any vertex of a part without
// constraints.
FibreSolution solve_fibre_field(std::span<const Vector3d> vertices, const OneRings& rings,
                                std::span<const FibreConstraint> constraints,
                                const FibreOptions& options = {});

}  // namespace fascicle::build
