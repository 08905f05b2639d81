#include "host/rig/blend_shapes.h"

#include <algorithm>

#include "host/rig/pose_interpolation.h"

namespace fascicle::rig {

std::vector<double> weights_at(const WeightChannel& channel, double time) {
  const bool is_spline = channel.interpolation == Interpolation::cubic_spline;
  const std::vector<double>& times = channel.times;
  const std::size_t parts = is_spline ? 3 : 1;
  const std::size_t count = channel.values->size() / (times.size() * parts);
  // 0, 1, 2: in-tangent, value, out-tangent of a spline.
  const auto part = [&](std::size_t key, std::size_t which, std::size_t shape) {
    return (*channel.values)[(key * parts + which) * count + shape];
  };
  const std::size_t middle = is_spline ? 1 : 0;
  const auto held = [&](std::size_t key) {
    std::vector<double> weights;
    for (std::size_t s = 0; s < count; ++s) weights.push_back(part(key, middle, s));
    return weights;
  };
  if (time <= times.front()) return held(0);
  if (time >= times.back()) return held(times.size() - 1);
  const auto next =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  std::vector<double> weights = held(next - 1);
  if (channel.interpolation == Interpolation::step) return weights;
  const double span = times[next] - times[next - 1];
  const double u = (time - times[next - 1]) / span;
  for (std::size_t s = 0; s < count; ++s) {
    const double a = weights[s], b = part(next, middle, s);
    weights[s] =
        is_spline ? hermite(a, part(next - 1, 2, s) * span, b, part(next, 0, s) * span, u) : a + (b - a) * u;
  }
  return weights;
}

}  // namespace fascicle::rig
