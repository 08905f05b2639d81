// The implicit integrator's formulas in double precision: stiffness in Pa, BDF2, and the fixed point.
// They are ours and not the paper's.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"

namespace fascicle::cpu_reference {

// k_r = E_r V_r C_r, 1/s^2: V_r is a quarter of each tetrahedron at r, C_r the region's compliance under a
// uniaxial stress, averaged over the directions that transmit stress: all directions inside, those along the
// surface at a free surface. A sheet of sliding skin has no others.
std::vector<double> region_stiffness(const model::Model& model);

// K_i = sum_{r: i in N_r} k_r m_i, kg/s^2.
std::vector<double> vertex_stiffness(const model::Model& model, const std::vector<double>& region);

// One step of h seconds: backward Euler from one substep of history; from two, its blend with BDF2,
//   x' = (1 - t) (x - x_1)/h + t (3 x - 4 x_1 + x_2)/(2h),  t = 1 - viscosity/h, at least 0.
struct Stepping {
  double h;
  bool has_history;
  double viscosity;      // s
  double bdf2() const {  // t
    return has_history ? std::max(0.0, 1.0 - viscosity / h) : 0.0;
  }
  // x' = (x - (1 + b) x_1 + b x_2)/H
  double length() const {  // H
    return 1.0 / ((1.0 - bdf2()) / h + 1.5 * bdf2() / h);
  }
  double second() const {  // b
    return bdf2() / (2.0 * h) * length();
  }
};

// A vertex's state now and one substep earlier.
struct VertexHistory {
  Eigen::Vector3d q, q_before, v, v_before;
};

// y of a vertex under the acceleration f, damped by d (1/s) towards the velocity u.
Eigen::Vector3d predicted_position(const VertexHistory& past, const Stepping& step, const Eigen::Vector3d& f,
                                   double d, const Eigen::Vector3d& u);

// The start of the iterations; `share` of the previous acceleration continues.
Eigen::Vector3d start_of_iterations(const VertexHistory& past, const Stepping& step, const Eigen::Vector3d& f,
                                    double d, const Eigen::Vector3d& u, double share);

// x_hat = y + a (g - y)
Eigen::Vector3d pulled_position(const Eigen::Vector3d& y, const Eigen::Vector3d& g, double mass,
                                double stiffness, double d, const Stepping& step);

// v at the substep's end.
Eigen::Vector3d differentiated_position(const Eigen::Vector3d& q, const VertexHistory& past,
                                        const Stepping& step);

// Chebyshev's semi-iteration, for a matrix with eigenvalues in [0, a], a the lesser of a_N and `stiffest`:
// step k = 0, 1, ... changes x by x - x_prev = omega (gain (x_hat - x) + x - x_prev). The last step is a
// plain one. `overshoot`: with a volume term eigenvalues go down to about -overshoot a.
struct Chebyshev {
  Chebyshev(std::uint32_t steps, double largest, double overshoot = 0.0);
  double omega(std::uint32_t k) const;
  double gain(std::uint32_t k) const;
  // The share of the last acceleration that the iterations start with: 1 if a_N reaches `stiffest`, otherwise
  // falling with the stiffness a / (1 - a).
  double extrapolated() const;
  std::uint32_t iterations;
  double stiffest;
  double share;  // the part of each pass that is applied
  double rho = 0.0;
};

}  // namespace fascicle::cpu_reference
