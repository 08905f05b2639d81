#include "gpu/sliced_rings.h"

#include <algorithm>

namespace fascicle::gpu {
namespace {

constexpr std::uint32_t width = shader::slice_width;

std::uint32_t slice_depth(const model::Model& model, std::uint32_t first) {
  std::uint32_t depth = 0;
  for (std::uint32_t i = first; i < std::min(first + width, model.vertex_count); ++i)
    depth = std::max(depth, model.ring_offset[i + 1] - model.ring_offset[i]);
  return depth;
}

}  // namespace

std::uint64_t sliced_entry_count(const model::Model& model) {
  std::uint64_t entries = 0;
  for (std::uint32_t first = 0; first < model.vertex_count; first += width)
    entries += std::uint64_t{slice_depth(model, first)} * width;
  return entries;
}

SlicedRings slice_rings(const model::Model& model) {
  const std::uint64_t entries = sliced_entry_count(model);
  SlicedRings rings;
  rings.ring.resize(entries);
  rings.share_taken.resize(entries);
  rings.share_given.resize(entries);
  std::size_t base = 0;
  for (std::uint32_t first = 0; first < model.vertex_count; first += width) {
    rings.slice.push_back(static_cast<std::uint32_t>(base));
    for (std::uint32_t i = first; i < std::min(first + width, model.vertex_count); ++i) {
      std::size_t at = base + (i - first);
      for (std::uint32_t e = model.ring_offset[i]; e < model.ring_offset[i + 1]; ++e, at += width) {
        rings.ring[at] = model.ring[e];
        rings.share_taken[at] = model.share_taken[e];
        rings.share_given[at] = model.share_given[e];
      }
    }
    base += std::size_t{slice_depth(model, first)} * width;
  }
  return rings;
}

}  // namespace fascicle::gpu
