// Where a character's skin is open and what its cage made of that, for inspect.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/bake/bake.h"

namespace fascicle::cli {

// One row for each joint and fate: how many, and how wide the widest is.
std::vector<std::pair<std::string, std::string>> rows_of(const std::vector<bake::OpenEndEntry>& ends);

}  // namespace fascicle::cli
