#include "cpu_reference/oracle/oracle_weights.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "cpu_reference/oracle/oracle_implicit.h"
#include "cpu_reference/oracle/points.h"

namespace fascicle::cpu_reference {
namespace {

using Eigen::Vector3d;
using model::Model;

// Rest positions and fibres are floats, so the direction between neighbours is accurate to about 1e-5 at best
// (6e-8 of the body's size over a spacing of a hundredth of it). What is exactly zero in the formulas becomes
// rounding error: an r_i shorter than this share of the longest in the region has no direction,
constexpr double no_length = 1e-4;
// and weights with a sum below this share of that for w_ir = m_i come from cosines below 1e-5.
constexpr double nothing = 1e-10;

// Calls visit(i) for each i in N_r: vertex r and its one-ring.
void for_each_in_region(const Model& model, std::uint32_t r,
                        const std::function<void(std::uint32_t)>& visit) {
  visit(r);
  for (std::uint32_t k = model.ring_offset[r]; k < model.ring_offset[r + 1]; ++k) visit(model.ring[k]);
}

// The one-ring relation is symmetric, so the regions that vertex i lies in are those of N_i.
void for_each_region_of(const Model& model, std::uint32_t i,
                        const std::function<void(std::uint32_t)>& visit) {
  for_each_in_region(model, i, visit);
}

// The formula as printed, for all pairs: equations (12), (13), (14).
Eigen::SparseMatrix<double> printed_weights(const Model& model) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    const Vector3d d = vector_at(model.fibre, r).stableNormalized();
    double longest = 0.0;
    for_each_in_region(model, r, [&](std::uint32_t i) {
      longest = std::max(longest, offset_from_mass_centre(model, i, r).norm());
    });
    for_each_in_region(model, r, [&](std::uint32_t i) {
      Vector3d r_i = offset_from_mass_centre(model, i, r);
      if (r_i.norm() <= no_length * longest) r_i.setZero();
      entries.emplace_back(int(i), int(r),
                           model.mass[i] * fibre_weight(d, model.beta[r], r_i, model.weight_form));
    });
  }
  Eigen::SparseMatrix<double> w(model.vertex_count, model.vertex_count);
  w.setFromTriplets(entries.begin(), entries.end());
  return w;
}

// A region whose weights sum to nothing falls back to w_ir = m_i; then so does a vertex whose weights do.
void fall_back_to_mass(const Model& model, Eigen::SparseMatrix<double>& w) {
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    double sum = 0.0;
    double mass = 0.0;
    for_each_in_region(model, r, [&](std::uint32_t i) {
      sum += w.coeff(i, r);
      mass += model.mass[i];
    });
    if (sum <= nothing * mass)
      for_each_in_region(model, r, [&](std::uint32_t i) { w.coeffRef(i, r) = model.mass[i]; });
  }
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    double sum = 0.0;
    double mass = 0.0;
    for_each_region_of(model, i, [&](std::uint32_t r) {
      sum += w.coeff(i, r);
      mass += model.mass[i];
    });
    if (sum <= nothing * mass)
      for_each_region_of(model, i, [&](std::uint32_t r) { w.coeffRef(i, r) = model.mass[i]; });
  }
}

// s_i: alpha_i m_i, or m_i for kinematic vertices; K_i for an implicit model.
std::vector<double> pulls(const Model& model) {
  if (model.is_implicit()) return vertex_stiffness(model, region_stiffness(model));
  std::vector<double> s(model.vertex_count);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    s[i] = model.is_kinematic(i) ? model.mass[i] : double(model.alpha[i]) * model.mass[i];
  return s;
}

// w_ir <- w_ir s_i / sum_r w_ir. Then the pulls on a region's vertices sum to zero, and a vertex with s_i = 0
// neither exerts nor receives any.
void scale_for_momentum(const Model& model, Eigen::SparseMatrix<double>& w) {
  const std::vector<double> s = pulls(model);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    double sum = 0.0;
    for_each_region_of(model, i, [&](std::uint32_t r) { sum += w.coeff(i, r); });
    for_each_region_of(model, i, [&](std::uint32_t r) { w.coeffRef(i, r) *= s[i] / sum; });
  }
}

}  // namespace

// (13) r_i = q0_i - (sum_{k in N_r} m_k q0_k) / (sum_{k in N_r} m_k)
Vector3d offset_from_mass_centre(const Model& model, std::uint32_t i, std::uint32_t r) {
  Vector3d moment = Vector3d::Zero();
  double mass = 0.0;
  for_each_in_region(model, r, [&](std::uint32_t k) {
    moment += model.mass[k] * vector_at(model.rest, k);
    mass += model.mass[k];
  });
  return vector_at(model.rest, i) - moment / mass;
}

// (14) s = (beta d + (1 - beta) r_i/|r_i|) / sqrt(beta^2 + (1 - beta)^2)
// (12) w_ir / m_i = (s . r_i)^2 / |r_i|^2
// `symmetric` first turns d to the side of r_i, which gives |c| in place of c: a fibre is a line, not an
// arrow. An r_i of zero (often the middle vertex) has no direction: the weight is then the mass.
double fibre_weight(const Vector3d& d, double beta, const Vector3d& r_i, model::WeightForm form) {
  const double length = r_i.norm();
  if (d.isZero(0.0) || beta == 0.0 || length == 0.0) return 1.0;
  const Vector3d towards = r_i / length;
  const bool turn = form == model::WeightForm::symmetric && d.dot(towards) < 0.0;
  const Vector3d s = (beta * (turn ? Vector3d(-d) : d) + (1.0 - beta) * towards) /
                     std::sqrt(beta * beta + (1.0 - beta) * (1.0 - beta));
  const double along = s.dot(towards);
  return along * along;
}

Weights region_weights(const Model& model) {
  Eigen::SparseMatrix<double> w = printed_weights(model);
  fall_back_to_mass(model, w);
  if (model.is_implicit()) {
    const std::vector<double> k = region_stiffness(model);
    for (std::uint32_t r = 0; r < model.vertex_count; ++r) w.col(int(r)) *= k[r];
  }
  if (model.momentum_scaled) scale_for_momentum(model, w);
  return {w, w};
}

}  // namespace fascicle::cpu_reference
