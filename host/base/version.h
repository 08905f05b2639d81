// Versions written into every output.
#pragma once

#include <cstdint>

namespace fascicle::base {

// Of the program; the number in the root CMakeLists.txt.
inline constexpr const char* fascicle_version = FASCICLE_VERSION;

// Raised whenever a scene gets another model (its hash) or the solvers other bits for it: two bakes compare
// only within one number.
inline constexpr std::uint32_t solver_version = 17;

}  // namespace fascicle::base
