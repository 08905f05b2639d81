// Weights factored into pull and share: w_ir = pull_i f_ir (Model's comment on weights).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/build/one_ring.h"
#include "host/build/weights.h"

namespace fascicle::build {

struct Shares {
  std::vector<float> pull;         // n
  std::vector<float> taken;        // entry (r, i): f_ir
  std::vector<float> given;        // entry (i, r): f_ir
  std::vector<float> region_rest;  // 4n
  std::uint32_t skipped_regions = 0;
  // Regions whose own moment at rest is below 2^-40 of the mean: the solvers never rotate them.
  std::vector<std::uint32_t> still_regions;
};

// `stiffness` is alpha_i, 1 if kinematic; for an implicit model K_i / m_i, with k_r in the weights. With
// `momentum_scaled` the pull is stiffness x mass, which makes the goals' sum conserve momentum; without it,
// sum_r w_ir, as printed in the paper. Shares are rounded to multiples of 2^-16. A vertex's shares in the
// regions of its one-ring sum to at most 1; the rest is its share in its own region.
Shares make_shares(const OneRings& rings, const RestState& state, const RegionWeights& weights,
                   std::span<const float> stiffness, bool momentum_scaled);

}  // namespace fascicle::build
