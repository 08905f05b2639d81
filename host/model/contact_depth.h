// How deep the points of contact lie in flesh: Model::contact_depth.
//
// In working units. First come n distances at rest, from each vertex to the boundary of all flesh that points
// may meet. Then come n more for each group of Model::contact_group up to the highest one used: the distance
// to the boundary of the flesh without that group. So a point that passes through flesh it ignores into flesh
// it does not ignore starts with a small depth.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "host/model/model.h"

namespace fascicle::model {

// Number of groups that have their own depths.
inline std::size_t contact_group_count(const Model& model) {
  std::uint32_t groups = 0;
  for (const std::uint32_t of : model.contact_group) groups |= of;
  return static_cast<std::size_t>(std::bit_width(groups));
}

// Size of contact_depth.
inline std::size_t contact_depth_count(const Model& model) {
  return model.vertex_count * (1 + contact_group_count(model));
}

// The depth of vertex i for point p: the smallest over the groups that p ignores.
inline float contact_depth_of(const Model& model, std::uint32_t p, std::uint32_t i) {
  float depth = model.contact_depth[i];
  if (!model.has_ignored_contact()) return depth;
  for (std::uint32_t left = model.contact_ignored[p]; left != 0; left &= left - 1) {
    const std::size_t group = static_cast<std::size_t>(std::countr_zero(left));
    const float other = model.contact_depth[(1 + group) * model.vertex_count + i];
    depth = other < depth ? other : depth;
  }
  return depth;
}

}  // namespace fascicle::model
