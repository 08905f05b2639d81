#include "cpu_reference/sweeps.h"

#include <algorithm>
#include <cassert>

namespace fascicle::cpu_reference {

namespace {

// Vertices are moved so many slices at a time: regions are worked on by twos, and a call has its cost.
constexpr std::uint32_t slices_of_step = 32;

// Slices of regions that the vertices of slices up to this one take maps of lie below.
std::uint32_t end_of_reach(const std::uint32_t* reach, std::uint32_t slice) {
  return (reach[slice] + slice_size - 1) / slice_size;
}

// The lowest slice in the one-rings of each slice and of those after it.
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

}  // namespace

std::vector<Sweep> make_sweeps(const model::Model& model, const Slices& slices, unsigned threads,
                               std::uint32_t fewest) {
  if (slices.count == 0 || model.vertex_count < fewest) return {};
  const std::vector<std::uint32_t> lowest = lowest_slices(model, slices);
  // More than one a thread let threads help each other; each adds regions that are shared.
  constexpr unsigned most_of_thread = 4;
  for (unsigned of_thread = threads == 1 ? 1 : most_of_thread; of_thread > 0; --of_thread) {
    const std::uint32_t count = threads * of_thread;
    std::vector<Sweep> sweeps;
    std::uint64_t inside = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      const auto cut = [&](std::uint32_t at) {
        return static_cast<std::uint32_t>(std::uint64_t{slices.count} * at / count);
      };
      const std::uint32_t first = cut(k), last = cut(k + 1);
      if (first == last) continue;
      const std::uint32_t front =
          first == 0 ? 0 : std::clamp(end_of_reach(slices.reach.data(), first - 1), first, last);
      const std::uint32_t back = last == slices.count ? last : std::clamp(lowest[last], front, last);
      sweeps.push_back({{first, last}, front, back});
      inside += back - front;
    }
    constexpr double enough = 0.75;
    if (static_cast<double>(inside) >= enough * slices.count) return sweeps;
  }
  return {};
}

void run_shared_regions(const LaneStages& stages, const LaneInput& in, const Sweep& sweep) {
  if (sweep.slices.first < sweep.front) stages.region(in, {sweep.slices.first, sweep.front});
  if (sweep.back < sweep.slices.last) stages.region(in, {sweep.back, sweep.slices.last});
}

void run_sweep(const LaneStages& stages, LaneStage move, const LaneInput& in, const Sweep& sweep) {
  std::uint32_t done = sweep.front;
  for (std::uint32_t first = sweep.slices.first; first < sweep.slices.last; first += slices_of_step) {
    const std::uint32_t last = std::min(first + slices_of_step, sweep.slices.last);
    const std::uint32_t needed = end_of_reach(in.reach, last - 1);
    if (done < std::min(needed, sweep.back)) {
      // Regions are worked on by twos.
      const std::uint32_t end = std::min(needed + (needed - done) % 2, sweep.back);
      stages.region(in, {done, end});
      done = end;
    }
    move(in, {first, last});
  }
  assert(done == sweep.back);
}

}  // namespace fascicle::cpu_reference
