// One-rings laid out for the GPU: slices of slice_width vertices, as deep as the slice's largest one-ring,
// with entry k of all its vertices side by side (sliced ELL, Kreutzer et al., SIAM J. Sci. Comput. 36(5),
// 2014). Each vertex loops over its own degree, so padding is never read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::gpu {

struct SlicedRings {
  std::vector<std::uint32_t> slice;  // first entry of each slice
  // If all neighbours are near (is_near): neighbour and share packed in one word each, see shaders/buffers.h,
  // and no ring. Otherwise the neighbours, and the shares' bits. Unused entries are 0.
  std::vector<std::uint32_t> ring, share_taken, share_given;
};

// Whether each neighbour's number, minus that of its slice's first vertex, fits 16 signed bits, and each
// share is below 1.
bool is_near(const model::Model& model);

// Number of entries including padding, without building anything.
std::uint64_t sliced_entry_count(const model::Model& model);

// Requires sliced_entry_count to fit 32 bits.
SlicedRings slice_rings(const model::Model& model);

}  // namespace fascicle::gpu
