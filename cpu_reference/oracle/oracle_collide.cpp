#include "cpu_reference/oracle/oracle_collide.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace fascicle::cpu_reference {

using Eigen::Vector3d;

namespace {

// What is nearer than this touches, as in the kernel.
const double near = std::ldexp(1.0, -18);

Eigen::Affine3d map_of(const float* rows) {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) map.matrix()(r, c) = double(rows[4 * r + c]);
  return map;
}

struct Side {
  double distance;
  Vector3d away;
};

Side side_of(const shader::Collider& solid, const Vector3d& p) {
  if (solid.is_plane > 0.0f) return {p.y() - double(solid.radius), Vector3d::UnitY()};
  const Vector3d beyond =
      p.cwiseAbs() - Vector3d(double(solid.half_x), double(solid.half_y), double(solid.half_z));
  const Vector3d off = beyond.cwiseMax(0.0);
  Vector3d away = Vector3d::Zero();
  double distance = off.norm();
  if (distance > std::ldexp(1.0, -30)) {
    away = off / distance;
  } else {
    Eigen::Index nearest_face = 0;
    distance = beyond.maxCoeff(&nearest_face);
    away[nearest_face] = 1.0;
  }
  for (int a = 0; a < 3; ++a) away[a] = std::copysign(away[a], p[a]);
  return {distance - double(solid.radius), away};
}

// The move, in the solid's own space, of what goes from p0 to p1.
Collided held(const shader::Collider& solid, const Vector3d& p0, const Vector3d& p1) {
  const Vector3d way = p1 - p0;
  double share = 0.0;
  Side side = side_of(solid, p0);
  Vector3d place = p0;
  for (int step = 0; step < 12 && side.distance > near && share < 1.0 && way.norm() > 0.0; ++step) {
    share = std::min(1.0, share + side.distance / way.norm());
    place = p0 + share * way;
    side = side_of(solid, place);
  }
  const Side end = side_of(solid, p1);
  if (!(side.distance <= near) && !(end.distance < 0.0)) return {Vector3d::Zero(), false};
  const double counted = side.distance < 0.0 ? side.distance * double(solid.lifted) : side.distance;
  double gap = side.away.dot(p1 - place) + counted;
  if (side.distance > near && gap >= 0.0) {
    side = end;
    gap = end.distance;
  }
  if (!(gap <= near)) return {Vector3d::Zero(), false};
  const double lift = std::max(0.0, -gap);
  const Vector3d sliding = way - way.dot(side.away) * side.away;
  const double slid = sliding.norm();
  const Vector3d friction = slid > 0.0
                                ? Vector3d(-std::min(slid, double(solid.friction) * lift) / slid * sliding)
                                : Vector3d(Vector3d::Zero());
  return {lift * side.away + friction, true};
}

}  // namespace

Collided collided(const model::Model& model, std::span<const shader::Collider> solids, std::uint32_t i,
                  const Vector3d& start, const Vector3d& place) {
  Collided now{place};
  for (std::size_t k = 0; k < solids.size(); ++k) {
    if ((model.spared[i] >> k & 1U) != 0) continue;
    const Eigen::Affine3d map = map_of(&solids[k].xx);
    const Collided move = held(solids[k], map_of(&solids[k].before_xx) * start, map * now.place);
    if (!move.touches) continue;
    now.place += map.linear().transpose() * move.place;
    now.touches = true;
  }
  return now;
}

}  // namespace fascicle::cpu_reference
