#include "host/rig/smooth_clip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

#include "host/rig/pose.h"

namespace fascicle::rig {
namespace {

double least_of(double a, double b) {
  if (a * b <= 0.0) return 0.0;
  return std::abs(a) < std::abs(b) ? a : b;
}

// One component of a channel at its keys.
struct Samples {
  const std::vector<double>& times;
  std::vector<double> values;
  bool wraps = false;
  double seam = 1.0;  // -1: the last key is the negated first key, as quaternions may be

  std::ptrdiff_t count() const { return static_cast<std::ptrdiff_t>(times.size()); }
  // Intervals are numbered by the key they start at; numbers beyond one end wrap to the other.
  std::ptrdiff_t stretch(std::ptrdiff_t k) const {
    const std::ptrdiff_t stretches = count() - 1;
    return (k % stretches + stretches) % stretches;
  }
  bool has_stretch(std::ptrdiff_t k) const { return wraps || (k >= 0 && k < count() - 1); }
  double span(std::ptrdiff_t k) const {
    const auto i = static_cast<std::size_t>(stretch(k));
    return times[i + 1] - times[i];
  }
  double slope(std::ptrdiff_t k) const {
    const auto i = static_cast<std::size_t>(stretch(k));
    const double sign = k < 0 || k >= count() - 1 ? seam : 1.0;
    return sign * (values[i + 1] - values[i]) / span(k);
  }
  // Half the second derivative of the parabola through key k and its neighbours; at an end, that of the next
  // key inwards.
  double curvature(std::ptrdiff_t k) const {
    const bool before = has_stretch(k - 1), after = has_stretch(k);
    if (!before && !after) return 0.0;
    if (!before) k += 1;
    if (!after) k -= 1;
    if (!has_stretch(k - 1) || !has_stretch(k)) return 0.0;
    return (slope(k) - slope(k - 1)) / (span(k - 1) + span(k));
  }
  double end_slope(std::ptrdiff_t k) const;
  std::pair<double, double> bounds(std::ptrdiff_t k) const;
};

// Slope of the parabola through an end and the two keys next to it, if it has the sign of the line's slope.
double Samples::end_slope(std::ptrdiff_t k) const {
  const bool before = has_stretch(k - 1);
  const double curve = curvature(k);
  const double line = before ? slope(k - 1) : slope(k);
  const double wanted = before ? line + curve * span(k - 1) : line - curve * span(k);
  const double most = 3.0 * std::abs(line);
  return wanted * line <= 0.0 ? 0.0 : std::clamp(wanted, -most, most);
}

// Huynh's (3.11): beyond the bound that keeps the curve between its keys, allows as much as the curvature on
// both sides supports.
std::pair<double, double> Samples::bounds(std::ptrdiff_t k) const {
  const double curve = curvature(k);
  const double between = least_of(slope(k - 1), slope(k));
  const double borne_out = least_of(slope(k - 1) + least_of(curvature(k - 1), curve) * span(k - 1),
                                    slope(k) - least_of(curve, curvature(k + 1)) * span(k));
  return {std::min({0.0, 3.0 * between, 1.5 * borne_out}), std::max({0.0, 3.0 * between, 1.5 * borne_out})};
}

// The curve's slopes at the keys; `is_sample` says which intervals it covers. Where no bound is active, its
// second derivative is continuous too.
std::vector<double> smooth_slopes(const Samples& part, const std::vector<char>& is_sample) {
  const auto count = static_cast<std::ptrdiff_t>(is_sample.size()) + 1;
  const auto is_curved = [&](std::ptrdiff_t k) {
    return is_sample[static_cast<std::size_t>(part.stretch(k))] != 0;
  };
  struct Key {
    double slope = 0.0, low = 0.0, high = 0.0;
  };
  std::vector<Key> keys(static_cast<std::size_t>(count));
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    Key& key = keys[static_cast<std::size_t>(k)];
    if (!part.has_stretch(k - 1) || !part.has_stretch(k)) {
      key.slope = part.end_slope(k);
      key.low = key.high = key.slope;
    } else if (is_curved(k - 1) && is_curved(k)) {
      std::tie(key.low, key.high) = part.bounds(k);
    } else if (is_curved(k - 1) || is_curved(k)) {
      // The curve leaves a straight interval with the line's slope, unless that would make it overshoot.
      const double line = part.slope(is_curved(k) ? k - 1 : k);
      const double most = 3.0 * part.slope(is_curved(k) ? k : k - 1);
      key.slope = std::clamp(line, std::min(0.0, most), std::max(0.0, most));
      key.low = key.high = key.slope;
    }
  }
  // Projected Gauss-Seidel; each sweep at least halves the error.
  constexpr int sweeps = 48;
  const auto slope_at = [&](std::ptrdiff_t k) {
    if (k >= 0 && k < count) return keys[static_cast<std::size_t>(k)].slope;
    return part.seam * keys[static_cast<std::size_t>(k < 0 ? k + count - 1 : k - count + 1)].slope;
  };
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      Key& key = keys[static_cast<std::size_t>(k)];
      if (key.low == key.high) continue;
      const double before = 1.0 / part.span(k - 1), after = 1.0 / part.span(k);
      const double wanted = (3.0 * (part.slope(k - 1) * before + part.slope(k) * after) -
                             (slope_at(k - 1) * before + slope_at(k + 1) * after)) /
                            (2.0 * (before + after));
      key.slope = std::clamp(wanted, key.low, key.high);
    }
  std::vector<double> slopes;
  for (const Key& key : keys) slopes.push_back(key.slope);
  return slopes;
}

double dot(const std::vector<double>& values, std::size_t a, std::size_t b) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 4; ++c) sum += values[4 * a + c] * values[4 * b + c];
  return sum;
}

// Unit quaternions, each in the same hemisphere as the previous one.
std::vector<double> aligned(std::vector<double> values) {
  for (std::size_t k = 0; 4 * k < values.size(); ++k) {
    const double length = std::sqrt(dot(values, k, k));
    const double sign = k > 0 && dot(values, k - 1, k) < 0.0 ? -1.0 : 1.0;
    for (std::size_t c = 0; c < 4; ++c) values[4 * k + c] *= sign / length;
  }
  return values;
}

bool ends_as_it_begins(const Samples& part, bool is_rotation) {
  const auto [low, high] = std::minmax_element(part.values.begin(), part.values.end());
  // Exporters write floats, and their keys are rarely more accurate than this.
  const double noticeable =
      is_rotation ? 1e-4 : 1e-3 * (*high - *low) + 1e-6 * std::max(std::abs(*low), std::abs(*high));
  return std::abs(part.seam * part.values.back() - part.values.front()) <= noticeable;
}

}  // namespace

Channel smooth_channel(const Channel& channel, bool wraps) {
  const std::size_t count = channel.times.size();
  const auto is_sample = [&](std::size_t k) {
    return channel.times[k + 1] - channel.times[k] <= longest_sample;
  };
  bool some = false;
  for (std::size_t k = 0; k + 1 < count; ++k) some = some || is_sample(k);
  if (channel.interpolation != Interpolation::linear || count < 3 || !some) return channel;

  const bool is_rotation = channel.path == ChannelPath::rotation;
  const std::size_t width = is_rotation ? 4 : 3;
  const std::vector<double> values = is_rotation ? aligned(channel.values) : channel.values;
  std::vector<Samples> parts;
  for (std::size_t c = 0; c < width; ++c) {
    Samples part{channel.times, {}};
    for (std::size_t k = 0; k < count; ++k) part.values.push_back(values[k * width + c]);
    if (is_rotation && dot(values, 0, count - 1) < 0.0) part.seam = -1.0;
    parts.push_back(std::move(part));
  }
  wraps = wraps && std::all_of(parts.begin(), parts.end(),
                               [&](const Samples& part) { return ends_as_it_begins(part, is_rotation); });

  Channel smooth{channel.joint, channel.path, Interpolation::cubic_spline, channel.times, {}, {}};
  smooth.values.resize(3 * width * count);
  std::vector<char> is_curved;
  for (std::size_t k = 0; k + 1 < count; ++k) {
    is_curved.push_back(is_sample(k) ? 1 : 0);
    smooth.straight.push_back(is_sample(k) ? 0 : 1);
  }
  for (std::size_t c = 0; c < width; ++c) {
    Samples& part = parts[c];
    part.wraps = wraps;
    const std::vector<double> slopes = smooth_slopes(part, is_curved);
    for (std::size_t k = 0; k < count; ++k) {
      double* key = smooth.values.data() + 3 * width * k + c;
      key[0] = key[2 * width] = slopes[k];
      key[width] = part.values[k];
    }
  }
  return smooth;
}

Clip straight_clip(const Clip& clip) {
  Clip straight{clip.name, clip.duration, clip.channels};
  for (Channel& channel : straight.channels) {
    const bool is_rotation = channel.path == ChannelPath::rotation;
    const std::size_t width = is_rotation ? 4 : 3;
    if (!channel.straight.empty()) {
      // Of in-tangent, value and out-tangent, keeps the value.
      std::vector<double> values;
      for (std::size_t k = 0; k < channel.values.size(); ++k)
        if (k / width % 3 == 1) values.push_back(channel.values[k]);
      channel = {channel.joint, channel.path, Interpolation::linear, channel.times, values, {}};
    } else if (channel.interpolation == Interpolation::linear && is_rotation) {
      channel.values = aligned(channel.values);
    }
  }
  return straight;
}

Clip smooth_clip(const Clip& clip, bool repeats, double start, double end) {
  Clip smooth{clip.name, clip.duration, {}};
  for (const Channel& channel : clip.channels) {
    const bool is_whole = !channel.times.empty() &&
                          std::abs(channel.times.front() - start) < longest_sample &&
                          std::abs(channel.times.back() - end) < longest_sample;
    smooth.channels.push_back(smooth_channel(channel, repeats && is_whole));
  }
  return smooth;
}

}  // namespace fascicle::rig
