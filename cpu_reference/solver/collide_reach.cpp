#include "cpu_reference/solver/collide_reach.h"

#include <cmath>

#include "shaders/kernel/collide.inc"

namespace fascicle::cpu_reference {

namespace {

// Generous bounds on rounding errors: near the origin, and as a share of the distance. A product of matrix
// and vector has an error below 2^-21 of their lengths, and so does a rounded rotation.
constexpr float spare = 1e-4f, share_spare = 1e-5f;

float length(float x, float y, float z) {
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

ColliderReach reach_of(const shader::Collider& c) {
  float turn = 0.0f;
  const float *now = &c.xx, *before = &c.before_xx;
  for (std::size_t k = 0; k < 12; ++k)
    if (k % 4 != 3) turn += (now[k] - before[k]) * (now[k] - before[k]);
  const float shift = length(c.xt - c.before_xt, c.yt - c.before_yt, c.zt - c.before_zt);
  // Slightly more than twice the solid's motion: its translation, and its rotation per working unit from the
  // origin.
  const float turning = 2.1f * std::sqrt(turn) + share_spare;
  float reach = 2.1f * shift + spare + share_spare * (length(c.xt, c.yt, c.zt) + c.radius);

  ColliderReach solid;
  solid.is_plane = c.is_plane > 0.0f;
  if (solid.is_plane) {
    solid.x = c.yx;
    solid.y = c.yy;
    solid.z = c.yz;
    solid.height = c.yt - c.radius;
  } else {
    const kernel::Matrix<float> map{c.xx, c.xy, c.xz, c.yx, c.yy, c.yz, c.zx, c.zy, c.zz};
    const kernel::Vector<float> back = kernel::collide_turned_back<float>(map, {c.xt, c.yt, c.zt});
    solid.x = -back.x;
    solid.y = -back.y;
    solid.z = -back.z;
    reach += length(c.half_x, c.half_y, c.half_z) * (1.0f + share_spare) + c.radius;
  }
  solid.reach = 3.0f * reach * reach;
  solid.turning = 6.0f * turning * turning;
  return solid;
}

std::vector<ColliderReach> reaches_of(std::span<const shader::Collider> colliders) {
  std::vector<ColliderReach> reaches;
  for (const shader::Collider& c : colliders) {
    ColliderReach& solid = reaches.emplace_back(reach_of(c));
    solid.bit = 1U << (reaches.size() - 1);
  }
  return reaches;
}

}  // namespace fascicle::cpu_reference
