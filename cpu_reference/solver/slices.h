// One-rings laid out for stages in lanes: slices of slice_size vertices, as deep as the slice's largest
// one-ring, with entry k of all its vertices side by side (sliced ELL, Kreutzer et al., SIAM J. Sci. Comput.
// 36(5), 2014). Each vertex keeps the order of its entries, and padding is masked, so sums are the Model's.
#pragma once

#include <cstdint>
#include <vector>

#include "cpu_reference/solver/fields.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

inline constexpr std::uint32_t several_layers = ~std::uint32_t{0};
// How many slices ahead a stage prefetches.
inline constexpr std::uint32_t slices_ahead = 5;

struct Slices {
  explicit Slices(LineAllocator<float> from = {}) : memory(from) {}

  LineAllocator<float> memory;  // for the arrays by entry

  std::uint32_t count = 0;
  std::vector<std::uint32_t> first_row;  // count + 1: of slice_size entries each
  std::vector<std::uint32_t> degree;     // one per lane: its one-ring's size, 0 past the last vertex
  // Leading rows of a slice in which the regions of all its lanes take a vertex.
  std::vector<std::uint32_t> full_rows;    // count
  std::vector<std::int32_t> taken_degree;  // one per lane: entries that its region sums; 0 if it is skipped

  std::vector<std::uint8_t> is_held;  // count: all of the slice's vertices are kinematic
  std::vector<std::uint32_t> layer;   // count: the layer of all its vertices, or several_layers

  // One past the last vertex in the one-rings of slices up to this one; constant past the last slice.
  std::vector<std::uint32_t> reach;  // count + slices_ahead

  // Neighbours as differences from the slice's first vertex, 0 in padding. If all fit 16 bits and all shares
  // are below 1: `near_ring`, and shares in units of 2^-16. Otherwise `far_ring`, and shares as floats.
  LineVector<std::int16_t> near_ring{memory};
  LineVector<std::uint16_t> taken_parts{memory}, given_parts{memory};
  LineVector<std::int32_t> far_ring{memory};
  Floats taken{memory}, given{memory};

  bool is_compact() const { return !near_ring.empty(); }
};

Slices make_slices(const model::Model& model, LineAllocator<float> memory = {});

// Bytes per vertex that a substep of stages in lanes, without a skeleton, reads and writes: each array once
// per stage, with neighbours' records and maps counted once in their own slice. `passes` over the regions: 1,
// or for an implicit model the number of iterations; its first and last stages are not counted.
double substep_bytes(const model::Model& model, std::uint32_t passes);

// Fills in the constants next to the positions in Fields::vertices. With compact slices the pull is in units
// of 2^-16 too, so that share x pull needs no further product: scaling by a power of two is exact.
void fill_constants(const model::Model& model, const Slices& slices, Fields& fields);

}  // namespace fascicle::cpu_reference
