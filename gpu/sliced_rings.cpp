#include "gpu/sliced_rings.h"

#include <algorithm>
#include <bit>

#include "shaders/buffers.h"

namespace fascicle::gpu {
namespace {

using shader::slice_width;

std::uint32_t slice_depth(const model::Model& model, std::uint32_t first) {
  std::uint32_t depth = 0;
  for (std::uint32_t i = first; i < std::min(first + slice_width, model.vertex_count); ++i)
    depth = std::max(depth, model.ring_offset[i + 1] - model.ring_offset[i]);
  return depth;
}

// `difference` is modulo 2^32. Shares are multiples of 2^-16.
std::uint32_t near_word(std::uint32_t difference, float share) {
  return (difference & 0xffffu) | static_cast<std::uint32_t>(share * 65536.0f) << shader::share_shift;
}

}  // namespace

bool is_near(const model::Model& model) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e) {
      const std::int64_t difference = std::int64_t{model.ring[e]} - i / slice_width * slice_width;
      if (difference != static_cast<std::int16_t>(difference)) return false;
      if (model.share_taken[e] >= 1.0f || model.share_given[e] >= 1.0f) return false;
    }
  return true;
}

std::uint64_t sliced_entry_count(const model::Model& model) {
  std::uint64_t entries = 0;
  for (std::uint32_t first = 0; first < model.vertex_count; first += slice_width)
    entries += std::uint64_t{slice_depth(model, first)} * slice_width;
  return entries;
}

SlicedRings slice_rings(const model::Model& model) {
  const std::uint64_t entries = sliced_entry_count(model);
  SlicedRings rings;
  const bool near = is_near(model);
  if (!near) rings.ring.resize(entries);
  rings.share_taken.resize(entries);
  rings.share_given.resize(entries);
  std::size_t base = 0;
  for (std::uint32_t first = 0; first < model.vertex_count; first += slice_width) {
    rings.slice.push_back(static_cast<std::uint32_t>(base));
    for (std::uint32_t i = first; i < std::min(first + slice_width, model.vertex_count); ++i) {
      std::size_t at = base + (i - first);
      for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e, at += slice_width) {
        if (!near) rings.ring[at] = model.ring[e];
        rings.share_taken[at] = near ? near_word(model.ring[e] - first, model.share_taken[e])
                                     : std::bit_cast<std::uint32_t>(model.share_taken[e]);
        rings.share_given[at] = near ? near_word(model.ring[e] - first, model.share_given[e])
                                     : std::bit_cast<std::uint32_t>(model.share_given[e]);
      }
    }
    base += std::size_t{slice_depth(model, first)} * slice_width;
  }
  return rings;
}

}  // namespace fascicle::gpu
