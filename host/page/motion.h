// How points move over frames, quantised and coded. What quantisation moves is bounded; all else comes back
// as it was.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/page/range_encoder.h"

namespace fascicle::page {

// Places are origin + step x whole numbers, which have at most 24 bits.
struct Grid {
  std::array<double, 3> origin{};  // m
  double step = 1.0;               // m

  // m: no point is further from its place on the grid.
  double error() const;
};

// The grid that moves no point of the box (least x y z, most x y z, m) further than `error` (m), or the
// finest that its numbers allow.
Grid grid_for(const std::array<double, 6>& box, double error);

using Cell = std::array<std::int32_t, 3>;
Cell cell_of(const Grid& grid, const float* place);

// Of each point at most four neighbours of lower numbers: those of the highest numbers, ascending. CSR.
struct Neighbours {
  std::vector<std::uint32_t> offset;  // points + 1
  std::vector<std::uint32_t> point;
};
Neighbours lower_neighbours(std::uint32_t points, std::span<const std::array<std::uint32_t, 3>> triangles);

// An order of the points in which almost each has neighbours before it: entry k is the point that comes k-th.
std::vector<std::uint32_t> walk(std::uint32_t points,
                                std::span<const std::array<std::uint32_t, 3>> triangles);

// One moving set of points. Of each frame the order of differences over time that costs least is coded, then
// what is left of each point after its neighbours' mean was taken off.
class MotionEncoder {
 public:
  // `neighbours` must outlive it.
  explicit MotionEncoder(const Neighbours& neighbours);
  // `cells`: one a point. `base`: where the points are expected to be; empty: at the grid's origin.
  void put(RangeEncoder& to, std::span<const Cell> cells, std::span<const Cell> base = {});

 private:
  void predict(unsigned order);
  std::uint64_t cost() const;

  const Neighbours& neighbours_;
  NumberEncoder numbers_;
  std::uint64_t frames_ = 0;
  std::array<std::vector<Cell>, 4> offset_;  // from the base: now, and in the three frames before
  std::vector<Cell> rest_, left_,
      before_;  // after the past; after the neighbours too; the same a frame before
};

}  // namespace fascicle::page
