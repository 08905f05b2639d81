// Where a character's skin is open and what its cage made of that, for inspect and the manifest.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/bake/bake.h"
#include "host/build/build.h"

namespace fascicle::cli {

std::vector<bake::OpenEndEntry> open_ends_of(const build::Report& report);

// One row for each joint and fate: how many, and how wide the widest is.
std::vector<std::pair<std::string, std::string>> rows_of(const std::vector<bake::OpenEndEntry>& ends);

}  // namespace fascicle::cli
