// Equations (12), (13), (14): the weight w_ir of vertex i in region r, computed once at rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/build/one_ring.h"
#include "host/build/points.h"
#include "host/model/model.h"

namespace fascicle::build {

// What the weights depend on, all as the model holds it, so that solvers see the rest state that the weights
// were made for.
struct RestState {
  std::span<const float> rest;   // 3n, working units
  std::span<const double> mass;  // n
  std::span<const float> fibre;  // 3n, unit or 0 0 0
  std::span<const float> beta;   // n, 0 without a fibre
};

// A vertex's rest position, working units.
inline Eigen::Vector3d rest_at(const RestState& state, std::size_t i) {
  return vector_at(state.rest, i);
}

struct RegionWeights {
  std::vector<double> own;    // n: w_rr
  std::vector<double> taken;  // one-ring entry (r, i): w_ir
  std::uint32_t region_fallbacks = 0;
  std::uint32_t vertex_fallbacks = 0;
};

// w_ir = m_i (beta c + 1 - beta)^2 / (beta^2 + (1 - beta)^2), with c the cosine between the fibre and r_i, or
// its absolute value for `symmetric`. If r_i is shorter than 1e-4 of the region's longest, w_ir = m_i. The
// same holds for a region whose weights sum to less than 1e-10 of its masses, and then for a vertex whose
// weights do so over its regions.
RegionWeights region_weights(const OneRings& rings, const RestState& state, model::WeightForm form);

}  // namespace fascicle::build
