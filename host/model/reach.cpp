#include "host/model/reach.h"

#include <algorithm>
#include <cmath>

namespace fascicle::model {

bool is_in_reach(std::span<const float> positions, double unit) {
  const double most = std::min(farthest, farthest / unit);
  return std::all_of(positions.begin(), positions.end(),
                     [most](float x) { return std::abs(double{x}) <= most; });
}

bool is_in_reach(const std::array<double, 3>& origin) {
  return std::all_of(origin.begin(), origin.end(), [](double x) { return std::abs(x) <= farthest; });
}

}  // namespace fascicle::model
