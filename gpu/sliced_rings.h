// One-rings laid out for the GPU: slices of slice_width vertices, as deep as the slice's largest one-ring,
// entry k of all its vertices side by side (sliced ELL, Kreutzer et al., SIAM J. Sci. Comput. 36(5), 2014).
// Each vertex loops over its own degree, so the entries that fill a slice up are never read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::gpu {

struct SlicedRings {
  std::vector<std::uint32_t> slice;  // first entry of each slice
  // Where all neighbours lie near (is_near): neighbour and share in one word each, as shaders/buffers.h says,
  // and no ring. Else the neighbours, and the shares' bits. Unused entries are 0.
  std::vector<std::uint32_t> ring, share_taken, share_given;
};

// Whether every neighbour's number less that of its slice's first vertex fits 16 signed bits, and every share
// is below 1.
bool is_near(const model::Model& model);

// Entries with the filling, without building anything.
std::uint64_t sliced_entry_count(const model::Model& model);

// sliced_entry_count must fit 32 bits.
SlicedRings slice_rings(const model::Model& model);

}  // namespace fascicle::gpu
