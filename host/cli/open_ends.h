// Openings in a character's skin and how its cage treats them, for inspect.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/bake/bake.h"

namespace fascicle::cli {

// One row per joint and treatment: how many there are, and the width of the widest.
std::vector<std::pair<std::string, std::string>> rows_of(const std::vector<bake::OpenEndEntry>& ends);

}  // namespace fascicle::cli
