// How far away flesh may be. Farther away, products of four lengths, as in the normals of a surface, exceed
// single precision. Nothing that anybody could see is so large.
#pragma once

#include <array>
#include <span>

namespace fascicle::model {

// In metres and in working units.
inline constexpr double farthest = 1e9;

// Whether positions relative to a frame's origin, or the origin itself (m), are nearer. False also for
// numbers that are not finite.
bool is_in_reach(std::span<const float> positions, double unit);
bool is_in_reach(const std::array<double, 3>& origin);

}  // namespace fascicle::model
