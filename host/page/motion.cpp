#include "host/page/motion.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace fascicle::page {

namespace {

constexpr std::size_t axes = 3;
constexpr std::size_t contexts = 13;  // per axis
constexpr double most_cells = 1 << 24;
constexpr std::size_t most_neighbours = 4;

// Rounded to nearest, halves up.
std::int32_t rounded_mean(std::int64_t sum, std::int64_t count) {
  const std::int64_t twice = 2 * sum + count, by = 2 * count;
  return static_cast<std::int32_t>(twice >= 0 ? twice / by : -((-twice + by - 1) / by));
}

std::vector<std::vector<std::uint32_t>> neighbour_lists(
    std::uint32_t points, std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<std::vector<std::uint32_t>> lists(points);
  for (const auto& triangle : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      for (const std::uint32_t other : {triangle[(k + 1) % 3], triangle[(k + 2) % 3]})
        if (other != triangle[k]) lists[triangle[k]].push_back(other);
  for (auto& list : lists) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return lists;
}

}  // namespace

double Grid::error() const {
  return 0.5 * std::sqrt(3.0) * step;
}

Grid grid_for(const std::array<double, 6>& box, double error) {
  Grid grid{{box[0], box[1], box[2]}, error * 2.0 / std::sqrt(3.0)};
  for (std::size_t axis = 0; axis < axes; ++axis)
    grid.step = std::max(grid.step, (box[3 + axis] - box[axis]) / most_cells);
  if (!(grid.step > 0.0)) grid.step = 1.0;
  return grid;
}

Cell cell_of(const Grid& grid, const float* place) {
  Cell cell;
  for (std::size_t axis = 0; axis < axes; ++axis)
    cell[axis] =
        static_cast<std::int32_t>(std::lround((double{place[axis]} - grid.origin[axis]) / grid.step));
  return cell;
}

Neighbours lower_neighbours(std::uint32_t points, std::span<const std::array<std::uint32_t, 3>> triangles) {
  Neighbours neighbours{{0}, {}};
  const auto lists = neighbour_lists(points, triangles);
  for (std::uint32_t i = 0; i < points; ++i) {
    const auto end = std::lower_bound(lists[i].begin(), lists[i].end(), i);
    const auto begin = end - std::min<std::ptrdiff_t>(end - lists[i].begin(), most_neighbours);
    neighbours.point.insert(neighbours.point.end(), begin, end);
    neighbours.offset.push_back(static_cast<std::uint32_t>(neighbours.point.size()));
  }
  return neighbours;
}

std::vector<std::uint32_t> walk(std::uint32_t points,
                                std::span<const std::array<std::uint32_t, 3>> triangles) {
  const auto lists = neighbour_lists(points, triangles);
  std::vector<char> seen(points, 0);
  std::vector<std::uint32_t> order;
  for (std::uint32_t first = 0; first < points; ++first) {
    if (seen[first] != 0) continue;
    seen[first] = 1;
    order.push_back(first);
    for (std::size_t k = order.size() - 1; k < order.size(); ++k)
      for (const std::uint32_t next : lists[order[k]])
        if (seen[next] == 0) {
          seen[next] = 1;
          order.push_back(next);
        }
  }
  return order;
}

MotionEncoder::MotionEncoder(const Neighbours& neighbours)
    : neighbours_(neighbours),
      numbers_(axes * contexts),
      rest_(neighbours.offset.size() - 1),
      left_(rest_.size()),
      before_(rest_.size(), Cell{}) {
  for (auto& offset : offset_) offset.assign(rest_.size(), Cell{});
}

// Order n assumes that the n-th difference over time is 0.
void MotionEncoder::predict(unsigned order) {
  static constexpr std::array<Cell, 4> factors{{{0, 0, 0}, {1, 0, 0}, {2, -1, 0}, {3, -3, 1}}};
  const Cell& factor = factors[order];
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const std::uint32_t begin = neighbours_.offset[i], end = neighbours_.offset[i + 1];
    for (std::size_t axis = 0; axis < axes; ++axis) {
      rest_[i][axis] = offset_[0][i][axis] - factor[0] * offset_[1][i][axis] -
                       factor[1] * offset_[2][i][axis] - factor[2] * offset_[3][i][axis];
      std::int64_t sum = 0;
      for (std::uint32_t k = begin; k < end; ++k) sum += rest_[neighbours_.point[k]][axis];
      left_[i][axis] = rest_[i][axis] - (begin == end ? 0 : rounded_mean(sum, end - begin));
    }
  }
}

std::uint64_t MotionEncoder::cost() const {
  std::uint64_t bits = 0;
  for (const Cell& left : left_)
    for (const std::int32_t number : left) bits += bit_length(number);
  return bits;
}

void MotionEncoder::put(RangeEncoder& to, std::span<const Cell> cells, std::span<const Cell> base) {
  std::rotate(offset_.begin(), offset_.end() - 1, offset_.end());
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t axis = 0; axis < axes; ++axis)
      offset_[0][i][axis] = cells[i][axis] - (base.empty() ? 0 : base[i][axis]);
  unsigned best = 0;
  std::uint64_t least = 0;
  for (unsigned order = 0; order <= std::min<std::uint64_t>(frames_, 3); ++order) {
    predict(order);
    if (const std::uint64_t bits = cost(); order == 0 || bits < least) {
      least = bits;
      best = order;
    }
  }
  predict(best);
  to.direct(best, 2);
  for (std::size_t i = 0; i < left_.size(); ++i) {
    const std::uint32_t begin = neighbours_.offset[i], end = neighbours_.offset[i + 1];
    for (std::size_t axis = 0; axis < axes; ++axis) {
      // The residuals of the neighbours, and the point's in the previous frame, predict the size of this one.
      std::int64_t around = std::abs(before_[i][axis]);
      for (std::uint32_t k = begin; k < end; ++k) around += std::abs(left_[neighbours_.point[k]][axis]);
      const std::size_t context = std::min<std::size_t>(bit_length(around), contexts - 1);
      numbers_.put(to, left_[i][axis], axis * contexts + context);
    }
  }
  std::swap(before_, left_);
  ++frames_;
}

}  // namespace fascicle::page
