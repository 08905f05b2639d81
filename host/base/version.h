// Versions written into every output.
#pragma once

#include <cstdint>

namespace fascicle::base {

// Of the program; the version in the root CMakeLists.txt.
inline constexpr const char* fascicle_version = FASCICLE_VERSION;

// Incremented whenever a scene gets a different model (its hash) or solvers compute different bits for it.
// Two bakes are comparable only within one version.
inline constexpr std::uint32_t solver_version = 22;

}  // namespace fascicle::base
