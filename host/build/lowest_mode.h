// The lowest mode of a body of elastic regions: what an eigen-iteration finds at build time.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/base/parallel.h"
#include "host/build/region_stiffness.h"

namespace fascicle::build {

struct LowestMode {
  double square = 0.0;  // of the circular frequency, 1/s^2; from above
  bool settled = true;  // false: the iteration's limit came first
};

struct LowestModeSearch {
  int most_iterations = 5000;
  // Free vertices from which on the search goes by grids of cubes (cube_modes.h). Its result then differs
  // within what the search leaves open, less than a thousandth where spacing is even.
  std::size_t least_for_grids = 10000;
  std::size_t threads = base::thread_count();  // the result is the same with any
};

// The lowest circular frequency of the free vertices about rest, all others held still,
// with momentum-scaled weights. Nothing where no free vertex is held by another, or where there is none.
std::optional<LowestMode> lowest_mode(const ElasticBody& body, const std::vector<char>& is_free,
                                      const LowestModeSearch& search = {});

}  // namespace fascicle::build
