// Tetrahedra that resist crushing, in double precision: those that lack volume are projected onto the volume
// that they keep, all together, each with its share of its corners' masses. Ours and not the paper's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "cpu_reference/oracle/oracle_equations.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class Limits {
 public:
  explicit Limits(const model::Model& model);
  bool empty() const { return tetrahedra_.empty(); }
  // Moves the vertices of tetrahedra that lack volume, in all passes of a substep of the integrator's step H.
  // `before` holds their positions when it began.
  void apply(Points& q, const Points& before, double step) const;

 private:
  struct Tetrahedron {
    std::array<std::uint32_t, 4> corner;
    double least_volume;  // working units^3
    double least_square;  // added to the square of each gradient, working units^4
  };
  std::vector<Tetrahedron> tetrahedra_;
  std::vector<double> mobility_;  // inverse masses, 0 for kinematic vertices
};

// A tetrahedron's volume and its gradients by the corners.
struct VolumeGradients {
  double volume;
  std::array<Eigen::Vector3d, 4> by;
};
VolumeGradients volume_gradients(const Points& q, const std::array<std::uint32_t, 4>& corner);

}  // namespace fascicle::cpu_reference
