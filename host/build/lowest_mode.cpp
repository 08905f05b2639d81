// Minimises the Rayleigh quotient x.Lx / x.Mx by preconditioned conjugate gradients: for few vertices from
// noise with a diagonal preconditioner, for many from the guess of a cascade of cube grids, which also
// precondition. All sums run in vertex order, in plain loops, for the same bits on every machine.
#include "host/build/lowest_mode.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Core>

#include "host/build/cube_modes.h"
#include "host/build/rayleigh.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using Field = std::vector<Vector3d>;

// Settled: the quotient fell by less than this share in this many iterations.
struct Settled {
  double fall;
  int iterations;
};
constexpr Settled settled{1e-6, 20};
// With grids, one iteration does the work of some fifty.
constexpr Settled settled_with_grids{1e-5, 5};

Field first_guess(const std::vector<char>& is_free) {
  Noise noise;
  Field x(is_free.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int c = 0; c < 3 && is_free[i]; ++c) x[i][c] = noise.next();
  return x;
}

// Each pass over the body does everything possible with the data it reads: passes are memory-bound.
LowestMode minimise(const RegionStiffness& stiffness, const CubeCascade* cascade, Field x,
                    int iteration_limit) {
  const std::vector<char>& is_free = stiffness.is_free();
  const std::size_t n = x.size();
  const auto [fall, window] = cascade != nullptr ? settled_with_grids : settled;
  Field Lx, p(n, Vector3d::Zero()), Lp(n, Vector3d::Zero()), w(n, Vector3d::Zero());
  stiffness.apply(x, Lx);
  double xmx = 0.0, xlx = 0.0, rw_before = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_free[i]) continue;
    xmx += scalar_product(x[i], stiffness.mass(i) * x[i]);
    xlx += scalar_product(x[i], Lx[i]);
  }
  std::vector<double> quotients;
  for (int k = 0; k < iteration_limit; ++k) {
    const double quotient = xlx / xmx;
    quotients.push_back(quotient);
    if (k >= window && quotients[static_cast<std::size_t>(k - window)] - quotient <= fall * quotient)
      return {quotient, true};
    double rw = 0.0, rw_of_before = 0.0;
    Field& r = Lp;  // until the next product
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      r[i] = Lx[i] - quotient * Vector3d(stiffness.mass(i) * x[i]);
      rw_of_before += scalar_product(r[i], w[i]);
      w[i] = r[i] / stiffness.diagonal(i);
      rw += scalar_product(r[i], w[i]);
    }
    if (cascade != nullptr) {
      cascade->add_response(r, w);
      rw = 0.0;
      for (std::size_t i = 0; i < n; ++i)
        if (is_free[i]) rw += scalar_product(r[i], w[i]);
    }
    const double beta = k == 0 ? 0.0 : std::max(0.0, (rw - rw_of_before) / rw_before);
    rw_before = rw;
    for (std::size_t i = 0; i < n; ++i)
      if (is_free[i]) p[i] = beta * p[i] - w[i];
    stiffness.apply(p, Lp);
    double xlp = 0.0, plp = 0.0, xmp = 0.0, pmp = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      const Vector3d mp = stiffness.mass(i) * p[i];
      xlp += scalar_product(x[i], Lp[i]);
      plp += scalar_product(p[i], Lp[i]);
      xmp += scalar_product(x[i], mp);
      pmp += scalar_product(p[i], mp);
    }
    const double t = best_step(xlx, xlp, plp, xmx, xmp, pmp);
    // Normalised, so that values stay in range.
    const double scale = 1.0 / std::sqrt(xmx + 2.0 * t * xmp + t * t * pmp);
    xmx = xlx = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      x[i] = scale * (x[i] + t * p[i]);
      Lx[i] = scale * (Lx[i] + t * Lp[i]);
      xmx += scalar_product(x[i], stiffness.mass(i) * x[i]);
      xlx += scalar_product(x[i], Lx[i]);
    }
  }
  return {quotients.back(), false};
}

}  // namespace

std::optional<LowestMode> lowest_mode(const ElasticBody& body, const std::vector<char>& is_free,
                                      const LowestModeSearch& search) {
  const RegionStiffness stiffness(body, is_free, search.threads);
  double highest = 0.0;
  std::size_t free_vertices = 0;
  for (std::size_t i = 0; i < is_free.size(); ++i) {
    if (!is_free[i]) continue;
    highest = std::max(highest, stiffness.diagonal(i) / stiffness.mass(i));
    ++free_vertices;
  }
  if (highest == 0.0) return std::nullopt;
  Field guess;
  std::optional<CubeCascade> cascade;
  if (free_vertices >= search.least_for_grids)
    cascade.emplace(stiffness, guess);
  else
    guess = first_guess(is_free);
  const LowestMode lowest =
      minimise(stiffness, cascade ? &*cascade : nullptr, std::move(guess), search.most_iterations);
  // The lowest modes of a free body are its rigid motions, at 0 to rounding.
  if (!(lowest.square >= 1e-9 * highest)) return std::nullopt;
  return lowest;
}

}  // namespace fascicle::build
