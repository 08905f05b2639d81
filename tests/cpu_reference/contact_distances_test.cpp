// The distances that the lanes of the search for contacts keep between points and boxes of tetrahedra: a pair
// is not looked at again while they last, so they must never be too long.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "cpu_reference/solver/contact_lanes.h"
#include "cpu_reference/solver/lane_stages.h"
#include "cpu_reference/solver/simd.h"

namespace fascicle::tests::contact_distances_test {
namespace {

namespace cpu = cpu_reference;

// Moving points and a tetrahedron, as the lanes of the search see them.
class Approaching {
 public:
  explicit Approaching(unsigned seed) : random_(seed) {
    // All sizes, near the origin and far from it, drifting fast or slowly; the tetrahedron may be a point.
    const double size = std::pow(10.0, uniform(-3, 2)), thick = size * std::pow(10.0, uniform(-6, 0));
    const double away = uniform(0, 1) < 0.5 ? 0.0 : std::pow(10.0, uniform(-1, 3));
    speed_ = size * std::pow(10.0, uniform(-4, 0));
    for (std::size_t i = 0; i < vertices; ++i)
      for (std::size_t a = 0; a < 3; ++a)
        now[4 * i + a] = static_cast<float>(away + (i < 4 ? thick : size) * uniform(-1, 1));
    drift_ = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
  }

  void move() {
    before = now;
    // The tetrahedron moves one way and the points the other, along an axis or diagonally.
    for (std::size_t i = 0; i < vertices; ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        const double by = (i < 4 ? 1.0 : -1.0) * drift_[a] * (uniform(0, 1) < 0.9 ? 1.0 : uniform(-1, 1));
        now[4 * i + a] = static_cast<float>(double{now[4 * i + a]} + speed_ * (100.0 * drift_[1] + by));
      }
  }

  // The distance of the nearest point from the tetrahedron's box, along the axis on which it is largest.
  long double apart() const {
    long double nearest = std::numeric_limits<long double>::infinity();
    for (std::size_t p = 4; p < vertices; ++p) {
      long double farthest = -nearest;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto [low, high] = std::minmax({now[a], now[4 + a], now[8 + a], now[12 + a]});
        const long double x = now[4 * p + a];
        farthest = std::max({farthest, low - x, x - high});
      }
      nearest = p == 4 ? farthest : std::min(nearest, farthest);
    }
    return nearest;
  }

  // Four corners, then points.
  static constexpr std::size_t vertices = 7;
  std::array<float, 4 * vertices> now{}, before{};

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  std::mt19937 random_;
  double speed_ = 0.0;
  std::array<double, 3> drift_{};
};

cpu::ContactBounds bounds_of(const cpu::ContactLanes& lanes, const Approaching& body, std::uint32_t first,
                             std::uint32_t count) {
  std::array<std::uint32_t, Approaching::vertices> numbers{};
  for (std::uint32_t k = 0; k < count; ++k) numbers[k] = first + k;
  cpu::ContactBounds bounds;
  lanes.bound(
      {.now = body.now.data(), .before = body.before.data(), .vertex = numbers.data(), .count = count},
      bounds);
  return bounds;
}

// The distance returned by a look; checks its 16-bit form too.
float look_at(const cpu::ContactLanes& lanes, const Approaching& body) {
  std::array<float, 3 * cpu::contact_points_together> points{};
  points.fill(std::numeric_limits<float>::infinity());
  for (std::size_t p = 4; p < Approaching::vertices; ++p)
    for (std::size_t a = 0; a < 3; ++a)
      points[a * cpu::contact_points_together + (p - 4)] = body.now[4 * p + a];
  const std::array<std::uint32_t, 4> corners{0, 1, 2, 3};
  std::array<std::uint16_t, cpu::contact_boxes_together> apart{};
  cpu::ContactLook look{.points = points.data(),
                        .places = body.now.data(),
                        .corners = corners.data(),
                        .relevant = nullptr,
                        .all = 7,
                        .tetrahedra = 1,
                        .gone = 0.0f,
                        .apart = apart.data(),
                        .nearest = 0.0f,
                        .hits = 0,
                        .inside = {}};
  lanes.look(look);
  const auto kept = std::bit_cast<float>(std::uint32_t{apart[0]} << 16);
  EXPECT_LE(kept, std::max(look.nearest, 0.0f));
  EXPECT_LE(std::abs(look.nearest - kept), std::max(-look.nearest, 0.01f * look.nearest));
  return look.nearest;
}

// The remaining distance is never overestimated, whatever moves. A tetrahedron may be a single point and head
// straight for the points; then only the direction of rounding keeps the search correct.
TEST(ContactSearch, DistancesAreNeverTakenForMoreThanTheyAre) {
  for (const cpu::Simd simd : cpu::available_simd()) {
    if (simd == cpu::Simd::scalar) continue;
    SCOPED_TRACE(cpu::name_of(simd));
    const cpu::ContactLanes& lanes = cpu::lane_stages(simd)->contact;
    int begun_apart = 0;
    for (unsigned seed = 0; seed < 4000; ++seed) {
      Approaching body(seed);
      const float looked = look_at(lanes, body);
      if (!(looked > 0.0f)) continue;
      ASSERT_LE(looked, body.apart()) << seed;
      ++begun_apart;
      std::array<float, cpu::contact_boxes_stride> boxes{}, motions{};
      std::array<float, cpu::contact_boxes_together> nearest{}, gone{};
      const std::uint32_t number = seed % cpu::contact_boxes_together;
      nearest[number] = looked;
      for (int step = 0; step < 4; ++step) {
        body.move();
        const cpu::ContactBounds of_corners = bounds_of(lanes, body, 0, 4),
                                 of_points = bounds_of(lanes, body, 4, 3);
        for (std::size_t a = 0; a < 3; ++a) {
          boxes[a * cpu::contact_boxes_together + number] = of_corners.low[a];
          boxes[(a + 3) * cpu::contact_boxes_together + number] = of_corners.high[a];
          motions[a * cpu::contact_boxes_together + number] = of_corners.least[a];
          motions[(a + 3) * cpu::contact_boxes_together + number] = of_corners.most[a];
        }
        const std::uint32_t due = lanes.approach({.boxes = boxes.data(),
                                                  .motions = motions.data(),
                                                  .points = &of_points,
                                                  .nearest = nearest.data(),
                                                  .gone = gone.data()});
        const float left = looked - gone[number];
        ASSERT_LE(static_cast<long double>(looked) - gone[number], body.apart()) << seed << ", step " << step;
        if (body.apart() <= 0.0L) {
          ASSERT_TRUE(left <= 0.0f) << seed;
        }
        const bool is_near = (due >> number & 1U) != 0;
        if (is_near) {
          ASSERT_GE(gone[number], looked) << seed;
        }
      }
    }
    EXPECT_GT(begun_apart, 1000);
  }
}

}  // namespace
}  // namespace fascicle::tests::contact_distances_test
