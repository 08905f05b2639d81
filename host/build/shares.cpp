#include "host/build/shares.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include <Eigen/Core>

namespace fascicle::build {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double share_steps = 65536.0;

// Rounds to steps. If rounding up exceeds the total, the largest share is reduced, which keeps the bits of
// models; where it is too small to bear all of the excess, as beside hundreds of neighbours, those that were
// rounded up most lose a step each. They are enough: what exceeds the total was rounded up, by at most half a
// step each.
void quantise(std::span<const double> exact, std::vector<std::int32_t>& steps) {
  steps.resize(exact.size());
  std::int32_t sum = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    steps[k] = static_cast<std::int32_t>(std::round(exact[k] * share_steps));
    sum += steps[k];
  }
  const std::int32_t excess = sum - static_cast<std::int32_t>(share_steps);
  if (excess <= 0) return;
  if (const auto largest = std::max_element(steps.begin(), steps.end()); *largest >= excess) {
    *largest -= excess;
    return;
  }
  std::vector<std::size_t> order(exact.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto rounded_up = [&](std::size_t k) { return steps[k] - exact[k] * share_steps; };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rounded_up(a) > rounded_up(b); });
  const std::size_t count = std::min(static_cast<std::size_t>(excess), order.size());
  for (std::size_t k = 0; k < count; ++k) --steps[order[k]];
}

// 1 minus the shares given away: exact, since all are multiples of 2^-16.
float own_share(const OneRings& rings, const std::vector<float>& given, std::size_t i) {
  float own = 1.0f;
  for (std::uint32_t k = rings.offset[i]; k < rings.offset[i + 1]; ++k) own -= given[k];
  return own;
}

// W_r, o_r = c0_r - q0_r and |A_r|_F at rest.
struct RegionSums {
  double weight = 0.0;
  Vector3d centre = Vector3d::Zero();
  double moment = 0.0;
};

RegionSums region_sums(const OneRings& rings, const RestState& state, const Shares& shares,
                       std::span<const double> pull, std::size_t r) {
  const Vector3d q0 = rest_at(state, r);
  RegionSums sums;
  sums.weight = pull[r] * static_cast<double>(own_share(rings, shares.given, r));
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (std::uint32_t k = rings.offset[r]; k < rings.offset[r + 1]; ++k) {
    const std::uint32_t i = rings.neighbour[k];
    const double w = pull[i] * static_cast<double>(shares.taken[k]);
    const Vector3d offset = rest_at(state, i) - q0;
    sums.weight += w;
    first += w * offset;
    second += w * (offset * offset.transpose());
  }
  if (!(sums.weight > 0.0)) return {};
  sums.centre = first / sums.weight;
  sums.moment = (second - first * sums.centre.transpose()).norm();
  return sums;
}

// The power of two that scales `mean` nearest to 1. The scaling is exact, so it changes no other bit.
double power_of_two_towards_one(double mean) {
  if (!(mean > 0.0) || !std::isfinite(mean)) return 1.0;
  int exponent = 0;
  const double mantissa = std::frexp(mean, &exponent);
  return std::ldexp(1.0, (mantissa < 0.70710678118654752 ? 1 : 0) - exponent);
}

// For moments scaled to a mean of about 1; the threshold of extract_rotation in kernel/rotation.inc.
constexpr double least_moment = 0x1p-40;

}  // namespace

Shares make_shares(const OneRings& rings, const RestState& state, const RegionWeights& weights,
                   std::span<const float> stiffness, bool momentum_scaled) {
  const std::size_t n = rings.size();
  const std::vector<std::uint32_t> mirror = mirror_entries(rings);
  Shares shares;
  shares.taken.resize(rings.neighbour.size());
  shares.given.resize(rings.neighbour.size());
  std::vector<double> pull(n);
  std::vector<double> exact;
  std::vector<std::int32_t> steps;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = weights.own[i];
    for (std::uint32_t k = rings.offset[i]; k < rings.offset[i + 1]; ++k) sum += weights.taken[mirror[k]];
    exact.clear();
    for (std::uint32_t k = rings.offset[i]; k < rings.offset[i + 1]; ++k)
      exact.push_back(weights.taken[mirror[k]] / sum);
    quantise(exact, steps);
    for (std::uint32_t k = rings.offset[i]; k < rings.offset[i + 1]; ++k) {
      const float share = static_cast<float>(steps[k - rings.offset[i]] / share_steps);
      shares.given[k] = share;
      shares.taken[mirror[k]] = share;
    }
    pull[i] = momentum_scaled ? static_cast<double>(stiffness[i]) * state.mass[i] : sum;
  }

  double moments = 0.0;
  std::size_t regions = 0;
  for (std::size_t r = 0; r < n; ++r) {
    const RegionSums sums = region_sums(rings, state, shares, pull, r);
    moments += sums.moment;
    regions += sums.weight > 0.0;
  }
  const double factor = power_of_two_towards_one(regions > 0 ? moments / static_cast<double>(regions) : 0.0);

  shares.pull.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    shares.pull[i] = model::as_factor(pull[i] * factor);
    pull[i] = static_cast<double>(shares.pull[i]);
  }
  shares.region_rest.assign(4 * n, 0.0f);
  for (std::size_t r = 0; r < n; ++r) {
    const RegionSums sums = region_sums(rings, state, shares, pull, r);
    if (!(sums.weight > 0.0)) {
      ++shares.skipped_regions;
      continue;
    }
    if (!(sums.moment > least_moment)) shares.still_regions.push_back(static_cast<std::uint32_t>(r));
    for (int a = 0; a < 3; ++a)
      shares.region_rest[4 * r + static_cast<std::size_t>(a)] = static_cast<float>(sums.centre[a]);
    shares.region_rest[4 * r + 3] = static_cast<float>(1.0 / sums.weight);
  }
  return shares;
}

}  // namespace fascicle::build
