// Minimises the Rayleigh quotient x.Lx / x.Mx by preconditioned conjugate gradients. L is the regions'
// stiffness about rest, K_i (x_i - g_i(x)) with rotations to first order: symmetric, because the goals are
// those that minimise the regions' energy. All sums run in vertex order, in plain loops: the same bits on
// every machine.
#include "host/build/lowest_mode.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using Field = std::vector<Vector3d>;

// Settled: the quotient fell by less than this share in as many iterations.
constexpr double settled = 1e-6;
constexpr int settled_iterations = 20;

// The inverse of a symmetric matrix times a vector, by its adjugate; xx yy zz xy xz yz.
Vector3d solve(const std::array<double, 6>& m, const Vector3d& b) {
  const auto [xx, yy, zz, xy, xz, yz] = m;
  const double a0 = yy * zz - yz * yz, a1 = xz * yz - xy * zz, a2 = xy * yz - xz * yy;
  const double a3 = xx * zz - xz * xz, a4 = xy * xz - xx * yz, a5 = xx * yy - xy * xy;
  const double determinant = xx * a0 + xy * a1 + xz * a2;
  return Vector3d(a0 * b[0] + a1 * b[1] + a2 * b[2], a1 * b[0] + a3 * b[1] + a4 * b[2],
                  a2 * b[0] + a4 * b[1] + a5 * b[2]) /
         determinant;
}

double inner(const Field& a, const Field& b, const std::vector<char>& is_free) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (is_free[i]) sum += a[i][0] * b[i][0] + a[i][1] * b[i][1] + a[i][2] * b[i][2];
  return sum;
}

class Stiffness {
 public:
  Stiffness(const ElasticBody& body, const std::vector<char>& is_free);
  // y = L x on the free vertices, 0 elsewhere; x is 0 on the held ones.
  void apply(const Field& x, Field& y) const;
  double diagonal(std::size_t i) const { return pull_[i]; }

 private:
  struct Region {
    double weight = 0.0;
    std::array<double, 6> inertia{};  // sum w (|r|^2 I - r r^T)
  };
  template <class Visit>
  void for_each_member(std::size_t r, Visit visit) const {
    const Vector3d here = rest(r), centre = centre_[r];
    visit(r, own_[r], Vector3d(Vector3d::Zero() - centre));
    for (std::uint32_t e = rings_.offset[r]; e < rings_.offset[r + 1]; ++e)
      visit(std::size_t{rings_.neighbour[e]}, taken_[e],
            Vector3d((rest(rings_.neighbour[e]) - here) - centre));
  }
  Vector3d rest(std::size_t i) const { return {rest_[3 * i], rest_[3 * i + 1], rest_[3 * i + 2]}; }

  const OneRings& rings_;
  const std::vector<char>& is_free_;
  std::vector<double> pull_;
  std::vector<double> own_, taken_;  // w_ir, scaled, as in RegionWeights
  std::span<const float> rest_;
  Field centre_;  // c0_r, from the region's own vertex; q0_i - c0_r follow, as to keep them takes the most
  std::vector<Region> regions_;
  std::vector<char> touches_;  // a region that holds a free vertex
};

Stiffness::Stiffness(const ElasticBody& body, const std::vector<char>& is_free)
    : rings_(body.rings), is_free_(is_free), rest_(body.state.rest) {
  const std::size_t n = rings_.size();
  pull_.assign(body.k.begin(), body.k.end());
  for (std::size_t i = 0; i < n; ++i) {
    for (const std::uint32_t r : rings_[i]) pull_[i] += body.k[r];
    pull_[i] *= body.state.mass[i];
  }
  own_ = body.weights.own;
  taken_ = body.weights.taken;
  std::vector<double> given(n);
  for (std::size_t r = 0; r < n; ++r) given[r] += own_[r] *= body.k[r];
  for (std::size_t r = 0; r < n; ++r)
    for (std::uint32_t e = rings_.offset[r]; e < rings_.offset[r + 1]; ++e)
      given[rings_.neighbour[e]] += taken_[e] *= body.k[r];
  for (std::size_t r = 0; r < n; ++r) own_[r] *= pull_[r] / given[r];
  for (std::size_t e = 0; e < taken_.size(); ++e)
    taken_[e] *= pull_[rings_.neighbour[e]] / given[rings_.neighbour[e]];

  centre_.assign(n, Vector3d::Zero());
  regions_.resize(n);
  touches_.assign(n, 0);
  for (std::size_t r = 0; r < n; ++r) {
    Region& region = regions_[r];
    Vector3d centre = Vector3d::Zero();
    for_each_member(r, [&](std::size_t i, double w, const Vector3d& p) {
      region.weight += w;
      centre += w * p;
      if (is_free_[i]) touches_[r] = 1;
    });
    centre_[r] = centre / region.weight;
    for_each_member(r, [&](std::size_t, double w, const Vector3d& p) {
      const double xx = p[0] * p[0], yy = p[1] * p[1], zz = p[2] * p[2];
      const std::array<double, 6> terms{yy + zz, xx + zz, xx + yy, -p[0] * p[1], -p[0] * p[2], -p[1] * p[2]};
      for (std::size_t c = 0; c < 6; ++c) region.inertia[c] += w * terms[c];
    });
    // Weights along one line leave the turn about it open: it is 0.
    const double little = 1e-9 * (region.inertia[0] + region.inertia[1] + region.inertia[2]);
    for (std::size_t c = 0; c < 3; ++c) region.inertia[c] += little;
  }
}

void Stiffness::apply(const Field& x, Field& y) const {
  y.assign(x.size(), Vector3d::Zero());
  for (std::size_t r = 0; r < x.size(); ++r) {
    if (!touches_[r]) continue;
    Vector3d moved = Vector3d::Zero(), turned = Vector3d::Zero();
    for_each_member(r, [&](std::size_t i, double w, const Vector3d& p) {
      moved += w * x[i];
      turned += w * p.cross(x[i]);
    });
    const Vector3d c = moved / regions_[r].weight;
    const Vector3d turn = solve(regions_[r].inertia, turned);
    for_each_member(r, [&](std::size_t i, double w, const Vector3d& p) {
      if (is_free_[i]) y[i] += w * (x[i] - c - turn.cross(p));
    });
  }
}

// Numbers from -1 to 1 without a pattern.
Field first_guess(const std::vector<char>& is_free) {
  std::uint64_t state = 1;
  Field x(is_free.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int c = 0; c < 3 && is_free[i]; ++c) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      x[i][c] = static_cast<double>(state >> 33) / 1073741824.0 - 1.0;
    }
  return x;
}

// t that minimises (a11 + 2 a12 t + a22 t^2)/(m11 + 2 m12 t + m22 t^2).
double best_step(double a11, double a12, double a22, double m11, double m12, double m22) {
  const double a = a22 * m12 - a12 * m22, b = a22 * m11 - a11 * m22, c = a12 * m11 - a11 * m12;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  const double t = -2.0 * c / (b + root);
  return std::isfinite(t) ? t : 0.0;
}

}  // namespace

std::optional<LowestMode> lowest_mode(const ElasticBody& body, const std::vector<char>& is_free,
                                      int most_iterations) {
  const Stiffness stiffness(body, is_free);
  const std::size_t n = is_free.size();
  double highest = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    if (is_free[i]) highest = std::max(highest, stiffness.diagonal(i) / body.state.mass[i]);
  if (highest == 0.0) return std::nullopt;

  const auto weighed = [&](const Field& x) {
    Field m(n, Vector3d::Zero());
    for (std::size_t i = 0; i < n; ++i)
      if (is_free[i]) m[i] = body.state.mass[i] * x[i];
    return m;
  };
  Field x = first_guess(is_free), Lx, p(n, Vector3d::Zero()), Lp, r(n, Vector3d::Zero()), w = r, w_before = r;
  stiffness.apply(x, Lx);
  double rw_before = 0.0;
  std::vector<double> quotients;
  bool has_settled = false;
  for (int k = 0; k < most_iterations; ++k) {
    const Field Mx = weighed(x);
    const double xmx = inner(x, Mx, is_free), xlx = inner(x, Lx, is_free);
    const double quotient = xlx / xmx;
    quotients.push_back(quotient);
    has_settled =
        k >= settled_iterations &&
        quotients[static_cast<std::size_t>(k - settled_iterations)] - quotient <= settled * quotient;
    if (has_settled) break;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      r[i] = Lx[i] - quotient * Mx[i];
      w_before[i] = w[i];
      w[i] = r[i] / stiffness.diagonal(i);
    }
    const double rw = inner(r, w, is_free);
    const double beta = k == 0 ? 0.0 : std::max(0.0, (rw - inner(r, w_before, is_free)) / rw_before);
    rw_before = rw;
    for (std::size_t i = 0; i < n; ++i)
      if (is_free[i]) p[i] = beta * p[i] - w[i];
    stiffness.apply(p, Lp);
    const Field Mp = weighed(p);
    const double t = best_step(xlx, inner(x, Lp, is_free), inner(p, Lp, is_free), xmx, inner(x, Mp, is_free),
                               inner(p, Mp, is_free));
    // Of length 1, so that nothing grows out of the numbers.
    const double scale =
        1.0 / std::sqrt(xmx + 2.0 * t * inner(x, Mp, is_free) + t * t * inner(p, Mp, is_free));
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_free[i]) continue;
      x[i] = scale * (x[i] + t * p[i]);
      Lx[i] = scale * (Lx[i] + t * Lp[i]);
    }
  }
  // A free body's lowest modes are its rigid motions, at rounding's distance from 0.
  if (quotients.back() < 1e-9 * highest) return std::nullopt;
  return LowestMode{quotients.back(), has_settled};
}

}  // namespace fascicle::build
