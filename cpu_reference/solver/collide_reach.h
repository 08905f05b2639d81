// Tests in a few operations which vertices a solid may reach in a substep. It only rejects vertices that the
// kernel would leave unchanged, so it affects no bit: the GPU runs the kernel on every vertex.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpu_reference/solver/stages.h"
#include "shaders/shared.h"

namespace fascicle::cpu_reference {

// A place on a vertex's path through the substep, and the square of the path's greatest length.
struct Way {
  const float* place;
  float squared;
};

ColliderReach reach_of(const shader::Collider& collider);

// The kernel handles a vertex whose initial distance from the solid is at most the length of its path
// relative to the solid. That path is at most as long as the vertex's own plus the solid's motion there; from
// any other place on it, and from the solid's final position, the distance is at most twice that. Squares of
// sums are bounded by three times the sum of squares. NaN, and distances whose squares overflow, are left to
// the kernel.
template <bool is_plane>
bool may_reach(const ColliderReach& solid, const Way& way) {
  constexpr float far = 1e36f;
  const float* x = way.place;
  const float limit = solid.reach + 13.3f * way.squared +
                      solid.turning * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + way.squared);
  if constexpr (is_plane) {
    const float distance = solid.x * x[0] + solid.y * x[1] + solid.z * x[2] + solid.height;
    const float squared = distance * distance;
    return !((distance > 0.0f) & (squared > limit) & (squared < far));
  } else {
    const float a = x[0] - solid.x, b = x[1] - solid.y, c = x[2] - solid.z;
    const float squared = a * a + b * b + c * c;
    return !((squared > limit) & (squared < far));
  }
}

// Sets the solid's bit in the marks of the vertices in the range that it may reach; the first mark belongs to
// the range's first vertex.
template <class WayOf>
void mark_reached(const ColliderReach& solid, const WayOf& way_of, Range range, std::uint32_t* marks) {
  const auto mark = [&](auto reaches) {
    for (std::uint32_t i = range.first; i < range.last; ++i)
      marks[i - range.first] |= reaches(way_of(i)) ? solid.bit : 0U;
  };
  if (solid.is_plane)
    mark([&](const Way& way) { return may_reach<true>(solid, way); });
  else
    mark([&](const Way& way) { return may_reach<false>(solid, way); });
}

// For each of a substep's solids; the first has bit 0.
std::vector<ColliderReach> reaches_of(std::span<const shader::Collider> colliders);

}  // namespace fascicle::cpu_reference
