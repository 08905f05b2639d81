// Stage collide in double precision: solids, and how far flesh may move towards them.
#pragma once

#include <cstdint>
#include <span>

#include "cpu_reference/oracle/oracle_equations.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

struct Collided {
  Eigen::Vector3d place;
  Eigen::Vector3d velocity;                          // with the solids' impulses
  Eigen::Vector3d raised = Eigen::Vector3d::Zero();  // the part of the move that adds no velocity
  bool touches = false;
};

// Moves vertex i from `start` to `place` in h seconds, past one of the substep's solids after another.
Collided collided(const model::Model& model, std::span<const shader::Collider> solids, std::uint32_t i,
                  const Eigen::Vector3d& start, const Eigen::Vector3d& place, const Eigen::Vector3d& velocity,
                  double h);

}  // namespace fascicle::cpu_reference
