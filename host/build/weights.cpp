#include "host/build/weights.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace fascicle::build {

namespace {

using Eigen::Vector3d;

// Rest positions are floats: a region two hundredths of the body wide has them to about 3e-6 of its size. So
// a shorter r_i is mostly rounding, and its direction is arbitrary.
constexpr double no_direction = 1e-4;
// For the same reason cosines below 1e-5 count as none; these sums are their squares.
constexpr double no_weight = 1e-10;

// The members of one region: calls visit(place, i) for the vertex itself and its one-ring; place is -1 for
// itself.
template <class Visit>
void for_each_member(const OneRings& rings, std::size_t r, Visit visit) {
  visit(std::ptrdiff_t{-1}, r);
  for (std::uint32_t k = rings.offset[r]; k < rings.offset[r + 1]; ++k)
    visit(std::ptrdiff_t{k}, std::size_t{rings.neighbour[k]});
}

// Equation (13)'s mass centre, relative to the region's vertex.
Vector3d mass_centre(const OneRings& rings, const RestState& state, std::size_t r, const Vector3d& q0) {
  Vector3d sum = Vector3d::Zero();
  double mass = 0.0;
  for_each_member(rings, r, [&](std::ptrdiff_t, std::size_t i) {
    sum += state.mass[i] * (rest_at(state, i) - q0);
    mass += state.mass[i];
  });
  return sum / mass;
}

// The factor of m_i in (12).
double fibre_factor(double beta, double cosine, model::WeightForm form) {
  const double c = form == model::WeightForm::symmetric ? std::abs(cosine) : cosine;
  const double s = beta * c + (1.0 - beta);
  return s * s / (beta * beta + (1.0 - beta) * (1.0 - beta));
}

// Writes region r's weights; false if they sum to nothing.
bool weigh_region(const OneRings& rings, const RestState& state, model::WeightForm form, std::size_t r,
                  RegionWeights& weights) {
  const Vector3d q0 = rest_at(state, r);
  const Vector3d centre = mass_centre(rings, state, r, q0);
  const Vector3d d = vector_at(state.fibre, r);
  const double beta = static_cast<double>(state.beta[r]);
  double reach = 0.0;
  for_each_member(rings, r, [&](std::ptrdiff_t, std::size_t i) {
    reach = std::max(reach, (rest_at(state, i) - q0 - centre).norm());
  });
  double sum = 0.0, masses = 0.0;
  for_each_member(rings, r, [&](std::ptrdiff_t place, std::size_t i) {
    const Vector3d r_i = rest_at(state, i) - q0 - centre;
    const double length = r_i.norm();
    double w = state.mass[i];
    if (length > no_direction * reach) w *= fibre_factor(beta, d.dot(r_i) / length, form);
    (place < 0 ? weights.own[r] : weights.taken[static_cast<std::size_t>(place)]) = w;
    sum += w;
    masses += state.mass[i];
  });
  return sum > no_weight * masses;
}

void take_masses(const OneRings& rings, const RestState& state, std::size_t r, RegionWeights& weights) {
  for_each_member(rings, r, [&](std::ptrdiff_t place, std::size_t i) {
    (place < 0 ? weights.own[r] : weights.taken[static_cast<std::size_t>(place)]) = state.mass[i];
  });
}

}  // namespace

RegionWeights region_weights(const OneRings& rings, const RestState& state, model::WeightForm form) {
  const std::size_t n = rings.size();
  RegionWeights weights;
  weights.own.resize(n);
  weights.taken.resize(rings.neighbour.size());
  for (std::size_t r = 0; r < n; ++r) {
    if (state.beta[r] > 0.0f) {
      if (weigh_region(rings, state, form, r, weights)) continue;
      ++weights.region_fallbacks;
    }
    take_masses(rings, state, r, weights);
  }

  std::vector<double> given = weights.own;
  for (std::size_t k = 0; k < rings.neighbour.size(); ++k) given[rings.neighbour[k]] += weights.taken[k];
  std::vector<char> empty(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (given[i] <= no_weight * state.mass[i] * (1.0 + rings.degree(i))) {
      empty[i] = 1;
      weights.own[i] = state.mass[i];
      ++weights.vertex_fallbacks;
    }
  if (weights.vertex_fallbacks > 0)
    for (std::size_t k = 0; k < rings.neighbour.size(); ++k)
      if (empty[rings.neighbour[k]]) weights.taken[k] = state.mass[rings.neighbour[k]];
  return weights;
}

}  // namespace fascicle::build
