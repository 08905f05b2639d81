// Tells sheets from rods and blocks.
#pragma once

#include <array>
#include <span>

namespace fascicle::base {

// Whether the points lie along a sheet, such as a floor or a wall: at most a fiftieth as thick as it is long,
// and at least a tenth as wide. Measured between the points that lie farthest out, so that it does not depend
// on how densely they lie.
bool is_flat(std::span<const std::array<double, 3>> points);

}  // namespace fascicle::base
