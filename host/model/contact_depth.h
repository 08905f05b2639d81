// How deep flesh lies for the points of contact: Model::contact_depth.
//
// First come n numbers: of each vertex the distance at rest to the boundary of what may be met. Then, for
// each group of Model::contact_group up to the last that is there, n more: the distance to the boundary of
// what may be met without that group. So what passes through flesh that it ignores, and comes into flesh that
// it does not, is at first not deep.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "host/model/model.h"

namespace fascicle::model {

// Groups that have depths of their own.
inline std::size_t contact_group_count(const Model& model) {
  std::uint32_t groups = 0;
  for (const std::uint32_t of : model.contact_group) groups |= of;
  return static_cast<std::size_t>(std::bit_width(groups));
}

// How many numbers contact_depth has.
inline std::size_t contact_depth_count(const Model& model) {
  return model.vertex_count * (1 + contact_group_count(model));
}

// The depth of vertex i for point p: the least of those of the groups that it ignores.
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
