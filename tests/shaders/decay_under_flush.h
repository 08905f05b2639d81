// A vertex whose velocity dies away, stepped with the flush-to-zero mode of this CPU on or off. Two copies
// are compiled, with snap as it is and without it (FASCICLE_NO_SNAP).
#pragma once

#include <array>
#include <vector>

namespace fascicle::tests {

std::vector<float> decay_with_snap(bool flush_to_zero);
std::vector<float> decay_without_snap(bool flush_to_zero);

}  // namespace fascicle::tests
