// The lowest mode of a body of elastic regions: what an eigen-iteration finds at build time.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/build/one_ring.h"
#include "host/build/weights.h"

namespace fascicle::build {

struct ElasticBody {
  const OneRings& rings;
  const RestState& state;
  const RegionWeights& weights;  // w_ir of (12), without k_r
  std::span<const double> k;     // k_r of each region, 1/s^2
};

struct LowestMode {
  double square = 0.0;  // of the circular frequency, 1/s^2; from above
  bool settled = true;  // false: the iteration's limit came first
};

// The lowest circular frequency of the free vertices about rest, all others held still,
// with momentum-scaled weights. Nothing where no free vertex is held by another, or where there is none.
std::optional<LowestMode> lowest_mode(const ElasticBody& body, const std::vector<char>& is_free,
                                      int most_iterations = 5000);

}  // namespace fascicle::build
