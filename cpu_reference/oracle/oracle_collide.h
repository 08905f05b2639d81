// Stage collide in double precision: the solids, and how far flesh may go towards them.
#pragma once

#include <cstdint>
#include <span>

#include "cpu_reference/oracle/oracle_equations.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

struct Collided {
  Eigen::Vector3d place;
  Eigen::Vector3d velocity;                          // with the solids' impulses
  Eigen::Vector3d raised = Eigen::Vector3d::Zero();  // on the way there, without speed
  bool touches = false;
};

// Vertex i on its way of h seconds from `start` to `place`, one solid of the substep after the other.
Collided collided(const model::Model& model, std::span<const shader::Collider> solids, std::uint32_t i,
                  const Eigen::Vector3d& start, const Eigen::Vector3d& place, const Eigen::Vector3d& velocity,
                  double h);

}  // namespace fascicle::cpu_reference
