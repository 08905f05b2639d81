// Quantises and codes the motion of points. The quantisation error is bounded; everything else is lossless.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/page/range_encoder.h"

namespace fascicle::page {

// Positions are origin + step x integers of at most 24 bits.
struct Grid {
  std::array<double, 3> origin{};  // m
  double step = 1.0;               // m

  // m: the largest distance between a point and its grid position.
  double error() const;
};

// The grid that moves no point of the box (min x y z, max x y z, m) by more than `error` (m), or the finest
// that the integers' range allows.
Grid grid_for(const std::array<double, 6>& box, double error);

using Cell = std::array<std::int32_t, 3>;
Cell cell_of(const Grid& grid, const float* place);

// Up to four neighbours per point with lower indices than its own: the highest of those, ascending. CSR.
struct Neighbours {
  std::vector<std::uint32_t> offset;  // points + 1
  std::vector<std::uint32_t> point;
};
Neighbours lower_neighbours(std::uint32_t points, std::span<const std::array<std::uint32_t, 3>> triangles);

// An order of the points in which nearly every point comes after one of its neighbours: entry k is the k-th
// point.
std::vector<std::uint32_t> walk(std::uint32_t points,
                                std::span<const std::array<std::uint32_t, 3>> triangles);

// Codes one moving set of points. For each frame it chooses the cheapest order of differences over time, then
// codes each point's residual from its neighbours' mean.
class MotionEncoder {
 public:
  // `neighbours` must outlive it.
  explicit MotionEncoder(const Neighbours& neighbours);
  // `cells`: one per point. `base`: expected positions; empty: the grid's origin.
  void put(RangeEncoder& to, std::span<const Cell> cells, std::span<const Cell> base = {});

 private:
  void predict(unsigned order);
  std::uint64_t cost() const;

  const Neighbours& neighbours_;
  NumberEncoder numbers_;
  std::uint64_t frames_ = 0;
  std::array<std::vector<Cell>, 4> offset_;  // from the base: in this frame and the three before
  // Residuals: after temporal prediction; after spatial prediction, too; the latter in the previous frame.
  std::vector<Cell> rest_, left_, before_;
};

}  // namespace fascicle::page
