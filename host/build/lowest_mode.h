// The lowest mode of a body of elastic regions, found by an eigenvalue iteration at build time.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "host/base/parallel.h"
#include "host/build/region_stiffness.h"

namespace fascicle::build {

struct LowestMode {
  double square = 0.0;  // squared circular frequency, 1/s^2; an upper bound
  bool settled = true;  // false: the iteration limit was reached first
};

struct LowestModeSearch {
  int most_iterations = 5000;
  // From this many free vertices on, the search uses grids of cubes (cube_modes.h). The result then differs
  // within the search's tolerance, less than a thousandth if the spacing is even.
  std::size_t least_for_grids = 10000;
  std::size_t threads = base::thread_count();  // does not affect the result
};

// The lowest circular frequency of the free vertices about rest, with all others held still and with
// momentum-scaled weights. Nothing if there is no free vertex, or if nothing holds the free vertices.
std::optional<LowestMode> lowest_mode(const ElasticBody& body, const std::vector<char>& is_free,
                                      const LowestModeSearch& search = {});

}  // namespace fascicle::build
