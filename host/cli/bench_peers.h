// Runs other programs on the same bar, as separate processes, so that the library does not depend on them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace fascicle::cli {

// Whether fascicle-bench-bullet is next to the executable.
bool has_peer_program();

// ns per vertex and substep of `kind`, bullet-clusters or bullet-links, on one thread. Throws
// std::runtime_error if it fails.
double run_peer(const std::string& kind, const std::array<std::uint32_t, 3>& grid, std::uint32_t substeps);

}  // namespace fascicle::cli
