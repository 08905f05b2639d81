#include "cpu_reference/oracle/oracle_collide.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

namespace fascicle::cpu_reference {

using Eigen::Vector3d;

namespace {

// A vertex nearer than this touches, as in the kernel.
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

// The share of the path from p0 to p1 at which it first comes near the solid; 1 if it never does. The
// distance from a convex solid is a convex function along the path: ternary search finds its minimum, and
// bisection finds where it first becomes small enough on the way there.
double share_until_near(const shader::Collider& solid, const Vector3d& p0, const Vector3d& p1) {
  const auto distance_at = [&](double share) { return side_of(solid, p0 + share * (p1 - p0)).distance; };
  if (distance_at(0.0) <= near) return 0.0;
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 90; ++k) {
    const double third = (high - low) / 3.0;
    if (distance_at(low + third) <= distance_at(high - third))
      high -= third;
    else
      low += third;
  }
  if (!(distance_at(high) <= near)) return 1.0;
  low = 0.0;
  for (int k = 0; k < 60; ++k) {
    const double half = (low + high) / 2.0;
    (distance_at(half) <= near ? high : low) = half;
  }
  return high;
}

// The part of `sliding` that Coulomb friction removes under a push of `pressed` along the normal.
Vector3d held_by_friction(const Vector3d& sliding, double pressed, double friction) {
  const double slid = sliding.norm();
  return slid > 0.0 ? Vector3d(std::min(1.0, friction * pressed / slid) * sliding) : Vector3d(sliding);
}

struct Push {
  Vector3d move, raised, away;  // in the solid's own space
};

// The push on a vertex that moves from p0 to p1, both relative to the solid; nothing if it does not touch.
std::optional<Push> push_of(const shader::Collider& solid, double friction, const Vector3d& p0,
                            const Vector3d& p1) {
  const Vector3d way = p1 - p0;
  if (!(side_of(solid, p0).distance - near <= way.norm())) return std::nullopt;
  const Vector3d place = p0 + share_until_near(solid, p0, p1) * way;
  const Side side = side_of(solid, place);
  if (!(side.distance <= near)) return std::nullopt;
  const double counted = side.distance < 0.0 ? side.distance * double(solid.lifted) : side.distance;
  const double gap = side.away.dot(p1 - place) + counted;
  if (!(gap <= near)) return std::nullopt;
  const double lift = std::max(0.0, -gap), along = way.dot(side.away);
  const double stopped = std::min(lift, std::max(0.0, -along));
  return Push{lift * side.away - held_by_friction(way - along * side.away, stopped, friction),
              (lift - stopped) * side.away, side.away};
}

// The impulse that stops motion into the solid, for a velocity relative to it.
Vector3d impulse_of(double friction, const Vector3d& velocity, const Vector3d& away) {
  const double along = velocity.dot(away), stopped = std::max(0.0, -along);
  return stopped * away - held_by_friction(velocity - along * away, stopped, friction);
}

// Turns a push along `away` into one along the other solid's plane: it leads as far away, and no nearer to
// the other solid.
Vector3d led_along(const Vector3d& push, const Vector3d& away, const std::optional<Vector3d>& other) {
  if (!other || away.dot(*other) >= 0.0) return push;
  const Vector3d along = away - away.dot(*other) * *other;
  return along.squaredNorm() > 1.0 / 64.0 ? Vector3d(push.norm() / along.squaredNorm() * along) : push;
}

}  // namespace

Collided collided(const model::Model& model, std::span<const shader::Collider> solids, std::uint32_t i,
                  const Vector3d& start, const Vector3d& place, const Vector3d& velocity, double h) {
  Collided now{place, velocity};
  struct Pressed {
    std::size_t solid;
    Vector3d away;
  };
  std::vector<Pressed> order;  // the newest is last
  // Repeats until every solid has been passed since the last touch.
  std::size_t looks = 0, left = solids.size();
  for (; left > 0 && looks < shader::collide_passes * solids.size(); ++looks, --left) {
    const std::size_t k = looks % solids.size();
    if ((model.spared[i] >> k & 1U) != 0) continue;
    const bool is_first = looks < solids.size();
    const double friction = is_first ? double(solids[k].friction) : 0.0;
    const Eigen::Affine3d map = map_of(&solids[k].xx), map_before = map_of(&solids[k].before_xx);
    const auto push = push_of(solids[k], friction, map_before * start, map * now.place);
    if (!push) continue;
    const Eigen::Matrix3d back = map.linear().transpose();
    const Vector3d away = back * push->away;
    std::erase_if(order, [&](const Pressed& p) { return p.solid == k; });
    const std::optional<Vector3d> other =
        is_first || order.empty() ? std::nullopt : std::optional(order.back().away);
    order.push_back({k, away});
    now.place += led_along(back * push->move, away, other);
    if (is_first) now.raised += back * push->raised;
    // The solid's own velocity at that place.
    const Vector3d own = (now.place - map_before.inverse() * (map * now.place)) / h;
    now.velocity +=
        led_along(back * impulse_of(friction, map.linear() * (now.velocity - own), push->away), away, other);
    now.touches = true;
    left = solids.size();
  }
  return now;
}

}  // namespace fascicle::cpu_reference
