#include "cpu_reference/sweeps.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace fascicle::cpu_reference {

namespace {

// The first pass goes ahead by so many slices at a time: regions are worked on by twos, and a call has its
// cost.
constexpr std::uint32_t slices_of_step = 128;

// Slices of regions that the vertices of slices up to this one take maps of lie below.
std::uint32_t end_of_reach(const std::uint32_t* reach, std::uint32_t slice) {
  return (reach[slice] + slice_size - 1) / slice_size;
}

// The lowest slice in the one-rings of each slice and of those after it; behind the last slice the end.
std::vector<std::uint32_t> lowest_slices(const model::Model& model, const Slices& slices) {
  std::vector<std::uint32_t> lowest(slices.count + 1, slices.count);
  for (std::uint32_t i = model.vertex_count; i-- > 0;) {
    std::uint32_t& low = lowest[i / slice_size];
    low = std::min({low, i / slice_size, lowest[i / slice_size + 1]});
    // Ascending: the first is the lowest.
    if (model.ring_offset[i] < model.ring_offset[i + 1])
      low = std::min(low, model.ring[model.ring_offset[i]] / slice_size);
  }
  return lowest;
}

// How far one-rings reach, of the slices up to each and from each on.
struct Reach {
  std::vector<std::uint32_t> end, begin;
  std::uint32_t count;

  // The slices whose one-rings lie inside the range; the body's ends bound nothing.
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
  Reach reach{std::vector<std::uint32_t>(slices.count), lowest_slices(model, slices), slices.count};
  for (std::uint32_t s = 0; s < slices.count; ++s) reach.end[s] = end_of_reach(slices.reach.data(), s);
  return reach;
}

// None where a tile would have no inside.
Sweeps sweeps_of(const Reach& reach, std::uint32_t count, std::uint32_t passes) {
  Sweeps sweeps;
  for (std::uint32_t k = 0; k < count; ++k) {
    const auto cut = [&](std::uint32_t at) {
      return static_cast<std::uint32_t>(std::uint64_t{reach.count} * at / count);
    };
    Range range{cut(k), cut(k + 1)};
    Sweep tile;
    for (std::uint32_t p = 0; p < passes; ++p) {
      Part mine;
      mine.regions = reach.inside(range);
      if (mine.regions.first >= mine.regions.last) return {};
      mine.vertices = range = reach.inside(mine.regions);
      tile.push_back(mine);
      if (range.first >= range.last) return {};
    }
    sweeps.tiles.push_back(std::move(tile));
  }
  for (std::size_t k = 0; k + 1 < sweeps.tiles.size(); ++k) {
    Sweep joint;
    for (std::uint32_t p = 0; p < passes; ++p) {
      const Part &before = sweeps.tiles[k][p], &behind = sweeps.tiles[k + 1][p];
      joint.push_back(
          {{before.regions.last, behind.regions.first}, {before.vertices.last, behind.vertices.first}});
    }
    sweeps.joints.push_back(std::move(joint));
  }
  return sweeps;
}

// Of what a solver keeps of a vertex, one-rings included.
constexpr std::size_t bytes_of_vertex = 350;
// What the passes of all threads' sweeps may have underway: half of a usual processor's last cache.
constexpr std::size_t bytes_of_sweeps = std::size_t{16} << 20U;

// So many that what lies between the first pass and the last stays in the cache.
std::uint32_t passes_in_cache(const Reach& reach, unsigned threads) {
  std::uint32_t widest = 1;
  for (std::uint32_t s = 0; s < reach.count; ++s) widest = std::max(widest, reach.end[s] - s);
  // A pass stays behind the one before by what its regions reach and what its vertices do.
  const std::size_t bytes = 2 * bytes_of_vertex * slice_size * widest * threads;
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(bytes_of_sweeps / bytes, 1, most_passes));
}

}  // namespace

Sweeps make_sweeps(const model::Model& model, const Slices& slices, unsigned threads, std::uint32_t fewest) {
  if (slices.count == 0 || model.vertex_count < fewest) return {};
  const Reach reach = reach_of(model, slices);
  // More than one a thread let threads help each other.
  constexpr unsigned most_of_thread = 2;
  for (std::uint32_t passes = passes_in_cache(reach, threads); passes > 0; --passes)
    for (unsigned of_thread = threads == 1 ? 1 : most_of_thread; of_thread > 0; --of_thread) {
      Sweeps sweeps = sweeps_of(reach, threads * of_thread, passes);
      if (!sweeps.empty()) return sweeps;
    }
  return {};
}

void run_tile(const Sweep& tile, std::span<const Pass> passes) {
  assert(!passes.empty() && passes.size() <= tile.size());
  Sweep left(tile.begin(), tile.begin() + static_cast<std::ptrdiff_t>(passes.size()));
  // Slices that a pass may take, and takes by twos while more follow: regions are worked on so.
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
  for (const Sweep& joint : sweeps.joints) count += (joint[pass].*which).last - (joint[pass].*which).first;
  return count;
}

void run_joints(const Sweeps& sweeps, std::size_t pass, Range Part::*which, Range counted, LaneStage stage,
                const LaneInput& in) {
  std::uint32_t before = 0;
  for (const Sweep& joint : sweeps.joints) {
    const Range mine = joint[pass].*which;
    const std::uint32_t end = before + (mine.last - mine.first);
    const std::uint32_t first = std::max(counted.first, before), last = std::min(counted.last, end);
    if (first < last) stage(in, {mine.first + (first - before), mine.first + (last - before)});
    before = end;
  }
}

}  // namespace fascicle::cpu_reference
