// Motion decodes to what was encoded, up to the stated rounding.
#include "host/page/motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/page/range_encoder.h"
#include "tests/page/range_decoder.h"

namespace fascicle::page {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// A sheet of n x n points.
Triangles sheet(std::uint32_t n) {
  Triangles triangles;
  for (std::uint32_t y = 0; y + 1 < n; ++y)
    for (std::uint32_t x = 0; x + 1 < n; ++x) {
      const std::uint32_t a = y * n + x;
      triangles.push_back({a, a + 1, a + n});
      triangles.push_back({a + 1, a + n + 1, a + n});
    }
  return triangles;
}

TEST(RangeEncoder, BitsOfAnyLikelihoodComeBack) {
  std::mt19937 random(1);
  for (const unsigned share : {0u, 1u, 2048u, 4095u, 4096u}) {
    RangeEncoder to;
    Probability probability;
    std::vector<bool> bits;
    for (int k = 0; k < 20000; ++k) {
      bits.push_back(random() % 4096 < share);
      to.bit(probability, bits.back());
    }
    const std::string bytes = to.finish();
    tests::RangeDecoder from(bytes);
    std::uint64_t of_zero = 2048;
    for (std::size_t k = 0; k < bits.size(); ++k) ASSERT_EQ(from.bit(of_zero), bits[k]) << share << ' ' << k;
    // Constant bits cost almost nothing, even odds cost one bit each; 5 bytes end the stream.
    if (share == 0 || share == 4096) {
      EXPECT_LT(bytes.size(), 60u);
    }
    if (share == 2048) {
      EXPECT_NEAR(static_cast<double>(bytes.size()), 2500.0, 100.0);
    }
  }
}

// A carry propagates through pending bytes: low is driven to just below 2^32 and past it.
TEST(RangeEncoder, CarriesRunThroughManyBytes) {
  for (int tail = 0; tail < 64; ++tail) {
    RangeEncoder to;
    for (int k = 0; k < 40; ++k) to.direct(0x7fffffff, 31);
    for (int k = 0; k < tail; ++k) to.direct(1, 1);
    to.direct(0x55555555, 32);
    tests::RangeDecoder from(to.finish());
    for (int k = 0; k < 40; ++k) ASSERT_EQ(from.plain(31), 0x7fffffffu);
    for (int k = 0; k < tail; ++k) ASSERT_EQ(from.plain(1), 1u);
    ASSERT_EQ(from.plain(32), 0x55555555u);
  }
}

TEST(NumberEncoder, NumbersOfAllSizesComeBack) {
  std::mt19937 random(2);
  std::vector<std::int32_t> numbers{0, 1, -1, (1 << 30) - 1, 1 - (1 << 30)};
  for (int k = 0; k < 30000; ++k) {
    const auto size = static_cast<std::int32_t>(random() >> (2 + random() % 30));
    numbers.push_back(random() % 2 == 0 ? size : -size);
  }
  RangeEncoder to;
  NumberEncoder encoder(4);
  for (std::size_t k = 0; k < numbers.size(); ++k) encoder.put(to, numbers[k], k % 4);
  tests::RangeDecoder from(to.finish());
  tests::NumberDecoder decoder;
  for (std::size_t k = 0; k < numbers.size(); ++k) ASSERT_EQ(decoder.take(from, k % 4), numbers[k]) << k;
  EXPECT_EQ(from.left_over(), 0u);
}

TEST(Grid, NoPointIsFurtherThanItSays) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1.0f, 2.0f);
  for (const double error : {1e-5, 1e-4, 0.01}) {
    const Grid grid = grid_for({-1.0, -1.0, -1.0, 2.0, 2.0, 2.0}, error);
    EXPECT_NEAR(grid.error(), error, 1e-9 * error);
    double largest = 0.0;
    for (int k = 0; k < 20000; ++k) {
      const std::array<float, 3> point{place(random), place(random), place(random)};
      const Cell cell = cell_of(grid, point.data());
      double square = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        square += std::pow(grid.origin[axis] + grid.step * cell[axis] - double{point[axis]}, 2);
      largest = std::max(largest, std::sqrt(square));
    }
    EXPECT_LE(largest, grid.error() * (1.0 + 1e-9));
    // The bound is tight.
    EXPECT_GT(largest, 0.8 * grid.error());
  }
}

TEST(Grid, ACoarserOneIsTakenAndSaidWhereABodyGoesFar) {
  const Grid grid = grid_for({0.0, 0.0, 0.0, 1e6, 1.0, 1.0}, 1e-5);
  EXPECT_GT(grid.error(), 1e-2);
  const std::array<float, 3> end{1e6f, 1.0f, 1.0f};
  EXPECT_LE(cell_of(grid, end.data())[0], 1 << 24);
}

TEST(Walk, IsEveryPointOnceWithNeighboursBefore) {
  Triangles triangles = sheet(9);
  triangles.push_back({81, 82, 83});  // a separate piece; point 84 is in no triangle
  const std::vector<std::uint32_t> order = walk(85, triangles);
  std::vector<std::uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t k = 0; k < 85; ++k) ASSERT_EQ(sorted[k], k);
  std::vector<std::uint32_t> at(85);
  for (std::uint32_t k = 0; k < 85; ++k) at[order[k]] = k;
  for (auto& triangle : triangles)
    for (std::uint32_t& corner : triangle) corner = at[corner];
  const Neighbours neighbours = lower_neighbours(85, triangles);
  int without = 0;
  for (std::uint32_t i = 0; i < 85; ++i) without += neighbours.offset[i] == neighbours.offset[i + 1] ? 1 : 0;
  EXPECT_EQ(without, 3);  // the first of each piece, and the isolated point
}

struct Coded {
  std::string bytes;
  std::vector<std::vector<Cell>> ghost, flesh;
};

// A swinging sheet with trailing flesh; `noise` is the range of added noise in cells.
Coded coded_sheet(std::uint32_t n, std::size_t frames, int noise) {
  Coded coded;
  std::mt19937 random(4);
  const auto chance = [&] {
    return noise == 0 ? 0 : static_cast<int>(random() % static_cast<unsigned>(noise));
  };
  const Neighbours neighbours = lower_neighbours(n * n, sheet(n));
  MotionEncoder ghost(neighbours), flesh(neighbours);
  RangeEncoder to;
  for (std::size_t k = 0; k < frames; ++k) {
    std::vector<Cell> skinned, soft;
    for (std::uint32_t i = 0; i < n * n; ++i) {
      const double angle = 0.1 * static_cast<double>(k), x = 40.0 * (i % n), y = 40.0 * (i / n);
      skinned.push_back({static_cast<int>(x * std::cos(angle)), static_cast<int>(y),
                         static_cast<int>(x * std::sin(angle))});
      soft.push_back(skinned.back());
      soft.back()[1] += static_cast<int>(20.0 * std::sin(0.4 * static_cast<double>(k) + 0.01 * x)) + chance();
    }
    ghost.put(to, skinned);
    flesh.put(to, soft, skinned);
    coded.ghost.push_back(skinned);
    coded.flesh.push_back(soft);
  }
  coded.bytes = to.finish();
  return coded;
}

// Decodes one set of points by the format's description.
std::vector<Cell> decoded(tests::RangeDecoder& from, tests::NumberDecoder& numbers,
                          const Neighbours& neighbours, std::vector<std::vector<Cell>>& past,
                          std::vector<Cell>& before, const std::vector<Cell>& base) {
  const std::size_t points = neighbours.offset.size() - 1;
  const std::uint64_t order = from.plain(2);
  std::vector<Cell> rest(points), left(points), offsets(points), cells(points);
  for (std::size_t i = 0; i < points; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::int64_t around = std::abs(before[i][axis]);
      double sum = 0.0;
      const std::uint32_t begin = neighbours.offset[i], end = neighbours.offset[i + 1];
      for (std::uint32_t k = begin; k < end; ++k) {
        around += std::abs(left[neighbours.point[k]][axis]);
        sum += rest[neighbours.point[k]][axis];
      }
      std::uint64_t length = 0;
      for (std::int64_t size = around; size > 0; size /= 2) ++length;
      left[i][axis] =
          static_cast<std::int32_t>(numbers.take(from, 13 * axis + std::min<std::uint64_t>(length, 12)));
      const double mean = begin == end ? 0.0 : std::floor(sum / (end - begin) + 0.5);
      rest[i][axis] = left[i][axis] + static_cast<std::int32_t>(mean);
      const std::int32_t a = past[0][i][axis], b = past[1][i][axis], c = past[2][i][axis];
      const std::int32_t foreseen = order == 0   ? 0
                                    : order == 1 ? a
                                    : order == 2 ? 2 * a - b
                                                 : 3 * a - 3 * b + c;
      offsets[i][axis] = rest[i][axis] + foreseen;
      cells[i][axis] = offsets[i][axis] + base[i][axis];
    }
  past = {offsets, past[0], past[1]};
  before = left;
  return cells;
}

TEST(Motion, ComesBackToTheLastCell) {
  constexpr std::uint32_t n = 12;
  const Neighbours neighbours = lower_neighbours(n * n, sheet(n));
  for (const int noise : {0, 3, 100000}) {
    const Coded coded = coded_sheet(n, 20, noise);
    tests::RangeDecoder from(coded.bytes);
    const std::vector<Cell> zero(n * n, Cell{});
    std::vector<std::vector<Cell>> ghost_past(3, zero), flesh_past(3, zero);
    std::vector<Cell> ghost_before = zero, flesh_before = zero;
    tests::NumberDecoder ghost_numbers, flesh_numbers;
    for (std::size_t k = 0; k < coded.flesh.size(); ++k) {
      const auto ghost = decoded(from, ghost_numbers, neighbours, ghost_past, ghost_before, zero);
      ASSERT_EQ(ghost, coded.ghost[k]) << "noise " << noise << " frame " << k;
      ASSERT_EQ(decoded(from, flesh_numbers, neighbours, flesh_past, flesh_before, ghost), coded.flesh[k])
          << "noise " << noise << " frame " << k;
    }
    EXPECT_EQ(from.left_over(), 0u);
  }
}

// The purpose of the coder: smooth motion takes a small part of 12 bytes per point and set.
TEST(Motion, IsSmallWhereItIsSmooth) {
  constexpr std::size_t frames = 60;
  constexpr std::uint32_t n = 40;
  const double plain = 2.0 * 12.0 * n * n * frames;
  EXPECT_LT(static_cast<double>(coded_sheet(n, frames, 0).bytes.size()), 0.06 * plain);
  // The control: noise is incompressible.
  EXPECT_GT(static_cast<double>(coded_sheet(n, frames, 1 << 16).bytes.size()), 0.08 * plain);
}

}  // namespace
}  // namespace fascicle::page
