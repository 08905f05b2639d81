// A character's rigid parts, for inspect.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "host/build/build.h"

namespace fascicle::cli {

struct RigidRows {
  std::vector<std::pair<std::string, std::string>> rows;
  std::size_t left_out = 0;  // parts in no row
};

// One row for all parts that have the same name, joint, size and reason, such as the cards of a hairdo; at
// most `most` rows, in the order of the first parts.
RigidRows rigid_rows(const std::vector<build::RigidReport>& parts, std::size_t most);

}  // namespace fascicle::cli
