// A vertex with decaying velocity, stepped with this CPU's flush-to-zero mode on or off. Compiled twice, with
// snap and without it (FASCICLE_NO_SNAP).
#pragma once

#include <array>
#include <vector>

namespace fascicle::tests {

std::vector<float> decay_with_snap(bool flush_to_zero);
std::vector<float> decay_without_snap(bool flush_to_zero);

}  // namespace fascicle::tests
