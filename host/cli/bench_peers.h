// Other programs on the same bar: run as processes of their own, so that the library never needs them.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace fascicle::cli {

// fascicle-bench-bullet lies beside the executable.
bool has_peer_program();

// ns a vertex and substep of `kind`, bullet-clusters or bullet-links, on one thread. Throws
// std::runtime_error where it fails.
double run_peer(const std::string& kind, const std::array<std::uint32_t, 3>& grid, std::uint32_t substeps);

}  // namespace fascicle::cli
