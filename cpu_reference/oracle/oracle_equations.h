// The method's equations, one function each, in double precision. Numbers in brackets are those of Kaneda et
// al., "Fiber-dependent Approach for Fast Dynamic Character Animation", CASA 2017. (12) to (14) are in
// oracle_weights.h.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "cpu_reference/oracle/oracle_weights.h"
#include "cpu_reference/oracle/points.h"

namespace fascicle::cpu_reference {

// (8) The weighted centre of region r: c_r from positions, c0_r from rest positions. A region whose weights
// are all zero has none; its own vertex is used.
Eigen::Vector3d region_centre(const Weights& weights, std::uint32_t r, const Points& points);

// A_r = sum w_ir (q_i - c_r) (T_r (q0_i - c0_r))^T, the moment whose best rotation (9) defines.
Eigen::Matrix3d region_moment(const Weights& weights, std::uint32_t r, const Eigen::Matrix3d& T,
                              const Points& rest, const Eigen::Vector3d& c0, const Points& positions,
                              const Eigen::Vector3d& c);

// (6)(7)(9) argmin over rotations R of sum w_ir |R T_r (q0_i - c0_r) - (q_i - c_r)|^2, which is the R that
// maximises trace(R^T A_r). If several are best (a moment of rank one or zero, some inversions), returns the
// one nearest to `previous`. Of the quaternions q and -q, returns the one on the side of `previous`.
Eigen::Quaterniond best_rotation(const Eigen::Matrix3d& A, const Eigen::Quaterniond& previous);

// (10) Region r's goal for a vertex.
Eigen::Vector3d region_goal(const Eigen::Matrix3d& R, const Eigen::Matrix3d& T, const Eigen::Vector3d& rest,
                            const Eigen::Vector3d& c0, const Eigen::Vector3d& c);

// What (10) needs from a region in one substep.
struct RegionPose {
  Eigen::Quaterniond R = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  Eigen::Vector3d c0 = Eigen::Vector3d::Zero();
  Eigen::Vector3d c = Eigen::Vector3d::Zero();
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();  // volume_push
};

// The volume term's addition to R_r T_r in (10), for a region whose moment with T = I is A, and A0 at rest.
// With both divided by det(A0)^(1/3), J = det(A), C = cof(A), the gradient of J, and x = 1 - J:
//   V = G / trace(A0^-1) x / (1 + |x|) min(1, |A0^-1|^2 / |C|^2) C.
// Near rest the map L = R + V changes J by G x of itself, as trace(C^T C A0) = trace(A0^-1) there.
Eigen::Matrix3d volume_push(const Eigen::Matrix3d& A, const Eigen::Matrix3d& A0, double G);

// (11) The goal of vertex i, the mean of its regions' goals. Without weights, its position is its goal.
Eigen::Vector3d blended_goal(const Weights& weights, std::uint32_t i, const std::vector<RegionPose>& regions,
                             const Points& rest, const Points& positions);

// The two halves of (4): the external acceleration f_i/m_i, and the pull to the goal.
Eigen::Vector3d velocity_with_forces(const Eigen::Vector3d& v, const Eigen::Vector3d& acceleration, double h);
Eigen::Vector3d velocity_to_goal(const Eigen::Vector3d& v, double alpha, const Eigen::Vector3d& goal,
                                 const Eigen::Vector3d& q, double h);

// The layer's damping, between (4) and (5): decay = exp(-damping h), relative to the skinned velocity u.
Eigen::Vector3d damped_velocity(const Eigen::Vector3d& v, const Eigen::Vector3d& u, double decay);

// (5)
Eigen::Vector3d moved_position(const Eigen::Vector3d& q, const Eigen::Vector3d& v, double h);

// (17) c, the stretch along n_r; `bulge` is what is added to 1: gain beta_r sin(theta) (n_r . tau), for all
// muscles.
double muscle_stretch(double bulge);

// (15)(16) T_r from the unit vector n_r (zero: no direction, identity) and the stretch c.
Eigen::Matrix3d muscle_scale(const Eigen::Vector3d& n, double c);

// The effect of twisting a limb on a place in it, without the rotation: `around` is perpendicular to `axis`,
// the bone's, and to the direction away from it; shear is the twist per length times the distance from the
// axis. Determinant 1.
Eigen::Matrix3d muscle_twist(const Eigen::Vector3d& axis, const Eigen::Vector3d& around, double shear);

}  // namespace fascicle::cpu_reference
