#include "cpu_reference/solver/sweeps.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <optional>
#include <utility>

namespace fascicle::cpu_reference {

namespace {

// The first pass advances by this many slices at a time: regions are processed in pairs, and each call has a
// cost.
constexpr std::uint32_t slices_of_step = 128;

// One past the last slice of regions whose maps the vertices of slices up to this one use.
std::uint32_t end_of_reach(const std::uint32_t* reach, std::uint32_t slice) {
  return (reach[slice] + slice_size - 1) / slice_size;
}

// The lowest slice in the one-rings of each slice and of those after it; at the end, the slice count.
std::vector<std::uint32_t> lowest_slices(const model::Model& model, const Slices& slices) {
  std::vector<std::uint32_t> lowest(slices.count + 1, slices.count);
  for (std::uint32_t i = model.vertex_count; i-- > 0;) {
    std::uint32_t& low = lowest[i / slice_size];
    low = std::min({low, i / slice_size, lowest[i / slice_size + 1]});
    // Rings are ascending: the first is the lowest.
    if (model.ring_offset[i] < model.ring_offset[i + 1])
      low = std::min(low, model.ring[model.ring_offset[i]] / slice_size);
  }
  return lowest;
}

// The reach of one-rings: `end` for slices up to each, `begin` for slices from each on; both ascend.
struct Reach {
  std::vector<std::uint32_t> end, begin;
  std::uint32_t count;
  std::uint32_t widest, mean;  // slices from one to the end of its reach

  // The slices whose one-rings lie inside the range; the body's ends are no bounds.
  Range inside(Range range) const {
    Range result{0, count};
    if (range.first > 0)
      result.first = static_cast<std::uint32_t>(
          std::lower_bound(begin.begin(), begin.end() - 1, range.first) - begin.begin());
    if (range.last < count)
      result.last =
          static_cast<std::uint32_t>(std::upper_bound(end.begin(), end.end(), range.last) - end.begin());
    return result;
  }
};

Reach reach_of(const model::Model& model, const Slices& slices) {
  Reach reach{std::vector<std::uint32_t>(slices.count), lowest_slices(model, slices), slices.count, 1, 1};
  std::uint64_t sum = 0;
  for (std::uint32_t s = 0; s < slices.count; ++s) {
    reach.end[s] = end_of_reach(slices.reach.data(), s);
    reach.widest = std::max(reach.widest, reach.end[s] - s);
    sum += reach.end[s] - s;
  }
  reach.mean = std::max(1u, static_cast<std::uint32_t>(sum / slices.count));
  return reach;
}

// Where tile k of `count` begins: the tiles at the body's ends are narrower by what passes lose at one end,
// so that all have the same work.
std::uint32_t cut(const Reach& reach, std::uint32_t k, std::uint32_t count, std::uint32_t passes) {
  if (k == 0 || k == count) return k == 0 ? 0 : reach.count;
  // A pass loses the reach of its vertices and that of its regions: this, averaged over all passes.
  const std::uint64_t lost = std::uint64_t{reach.mean} * (passes + 1);
  const std::uint64_t at = (reach.count + 2 * lost) * k / count;
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(at, lost, lost + reach.count) - lost);
}

// Nothing if a pass would be empty.
std::optional<Parts> tile_of(const Reach& reach, Range range, std::uint32_t passes) {
  Parts tile;
  for (std::uint32_t p = 0; p < passes; ++p) {
    const Range regions = reach.inside(range);
    if (regions.first >= regions.last) return std::nullopt;
    range = reach.inside(regions);
    if (range.first >= range.last) return std::nullopt;
    tile.push_back({regions, range});
  }
  return tile;
}

Sweeps sweeps_of(const Reach& reach, std::uint32_t count, std::uint32_t passes) {
  Sweeps sweeps;
  for (std::uint32_t k = 0; k < count; ++k) {
    std::optional<Parts> tile =
        tile_of(reach, {cut(reach, k, count, passes), cut(reach, k + 1, count, passes)}, passes);
    if (!tile) return {};
    sweeps.tiles.push_back(std::move(*tile));
  }
  for (std::size_t k = 0; k + 1 < sweeps.tiles.size(); ++k) {
    Parts joint;
    for (std::uint32_t p = 0; p < passes; ++p) {
      const Part &before = sweeps.tiles[k][p], &behind = sweeps.tiles[k + 1][p];
      joint.push_back(
          {{before.regions.last, behind.regions.first}, {before.vertices.last, behind.vertices.first}});
    }
    sweeps.joints.push_back(std::move(joint));
  }
  return sweeps;
}

// The share of all passes' vertices that tiles cover.
double share_inside(const Sweeps& sweeps, const Reach& reach) {
  std::uint64_t inside = 0;
  for (const Parts& tile : sweeps.tiles)
    for (const Part& of_pass : tile) inside += of_pass.vertices.last - of_pass.vertices.first;
  return static_cast<double>(inside) / static_cast<double>(std::uint64_t{sweeps.passes()} * reach.count);
}

// Bytes that a solver keeps per vertex, one-rings included.
constexpr std::size_t bytes_of_vertex = 350;
// Working set of all threads' sweeps: half of a typical last-level cache.
constexpr std::size_t bytes_of_sweeps = std::size_t{16} << 20U;

// The number of passes for which all data between the first pass and the last stays in the cache.
std::uint32_t passes_in_cache(const Reach& reach, unsigned threads) {
  // A pass lags behind the previous one by the reach of its regions and that of its vertices.
  const std::size_t bytes = 2 * bytes_of_vertex * slice_size * reach.widest * threads;
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(bytes_of_sweeps / bytes, 1, most_swept_passes));
}

}  // namespace

Sweeps make_sweeps(const model::Model& model, const Slices& slices, unsigned threads, std::uint32_t fewest) {
  if (slices.count == 0 || model.vertex_count < fewest) return {};
  const Reach reach = reach_of(model, slices);
  constexpr double least_inside = 0.5;
  Sweeps best;
  double least_cost = std::numeric_limits<double>::infinity();
  for (std::uint32_t passes = passes_in_cache(reach, threads); passes > 0; --passes)
    // Two tiles per thread let threads help each other.
    for (const unsigned of_thread : {2u, 1u}) {
      if (threads == 1 && of_thread > 1) continue;
      Sweeps sweeps = sweeps_of(reach, threads * of_thread, passes);
      if (sweeps.empty()) continue;
      const double inside = share_inside(sweeps, reach);
      // How often memory is read: once for all passes of a tile, once for each pass of a joint.
      const double cost = inside / passes + (1.0 - inside);
      if (inside < least_inside || cost >= least_cost) continue;
      best = std::move(sweeps);
      least_cost = cost;
    }
  return best;
}

void run_tile(const Parts& tile, std::span<const Pass> passes) {
  assert(!passes.empty() && passes.size() <= tile.size());
  // Not on the heap: jobs of the pool must not throw.
  std::array<Part, most_swept_passes> parts{};
  std::copy_n(tile.begin(), passes.size(), parts.begin());
  const std::span<Part> left(parts.data(), passes.size());
  // The slices that a pass may process, an even number while more follow: regions are processed in pairs.
  const auto take = [](Range& mine, const std::uint32_t* reach, const Range& needed) {
    const bool all = needed.first >= needed.last;
    std::uint32_t end = mine.first;
    while (end < mine.last && (all || end_of_reach(reach, end) <= needed.first)) ++end;
    if (end < mine.last) end -= (end - mine.first) % 2;
    return Range{std::exchange(mine.first, end), end};
  };
  const auto is_left = [](const Range& range) { return range.first < range.last; };
  const auto has_more = [&](const Part& part) { return is_left(part.regions) || is_left(part.vertices); };
  while (std::any_of(left.begin(), left.end(), has_more)) {
    for (std::size_t p = 0; p < passes.size(); ++p) {
      const LaneInput& in = passes[p].in;
      Range regions;
      if (p == 0) {
        regions = left[0].regions;
        regions.last = std::min(regions.first + slices_of_step, regions.last);
        left[0].regions.first = regions.last;
      } else {
        regions = take(left[p].regions, in.reach, left[p - 1].vertices);
      }
      if (is_left(regions)) passes[p].region(in, regions);
      const Range vertices = take(left[p].vertices, in.reach, left[p].regions);
      if (!is_left(vertices)) continue;
      if (passes[p].skin != nullptr) passes[p].skin(in, vertices);
      passes[p].move(in, vertices);
    }
  }
}

std::uint32_t slices_of_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which) {
  std::uint32_t count = 0;
  for (const Parts& joint : sweeps.joints) count += (joint[pass].*which).last - (joint[pass].*which).first;
  return count;
}

void run_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which, Range counted, LaneStage stage,
                const LaneInput& in) {
  std::uint32_t before = 0;
  for (const Parts& joint : sweeps.joints) {
    const Range mine = joint[pass].*which;
    const std::uint32_t end = before + (mine.last - mine.first);
    const std::uint32_t first = std::max(counted.first, before), last = std::min(counted.last, end);
    if (first < last) stage(in, {mine.first + (first - before), mine.first + (last - before)});
    before = end;
  }
}

}  // namespace fascicle::cpu_reference
