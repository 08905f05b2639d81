#include "host/build/region_stiffness.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "host/base/parallel.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;

// A thread takes at least this many vertices: starting one costs a tenth of this work.
constexpr std::size_t least_vertices_a_thread = 16384;

struct Member {
  std::size_t vertex;
  double weight;
  Vector3d place;
};

}  // namespace

Vector3d solve_symmetric(const std::array<double, 6>& m, const Vector3d& b) {
  const auto [xx, yy, zz, xy, xz, yz] = m;
  const double a0 = yy * zz - yz * yz, a1 = xz * yz - xy * zz, a2 = xy * yz - xz * yy;
  const double a3 = xx * zz - xz * xz, a4 = xy * xz - xx * yz, a5 = xx * yy - xy * xy;
  const double determinant = xx * a0 + xy * a1 + xz * a2;
  return Vector3d(a0 * b[0] + a1 * b[1] + a2 * b[2], a1 * b[0] + a3 * b[1] + a4 * b[2],
                  a2 * b[0] + a4 * b[1] + a5 * b[2]) /
         determinant;
}

RegionStiffness::RegionStiffness(const ElasticBody& body, const std::vector<char>& is_free,
                                 std::size_t threads)
    : rings_(body.rings),
      state_(body.state),
      own_(body.weights.own),
      taken_(body.weights.taken),
      k_(body.k),
      is_free_(is_free),
      threads_(threads) {
  const std::size_t n = rings_.size();
  pull_.assign(k_.begin(), k_.end());
  for (std::size_t i = 0; i < n; ++i) {
    for (const std::uint32_t r : rings_[i]) pull_[i] += k_[r];
    pull_[i] *= state_.mass[i];
  }
  std::vector<double> given(n);
  for (std::size_t r = 0; r < n; ++r) given[r] += own_[r] * k_[r];
  for (std::size_t r = 0; r < n; ++r)
    for (std::uint32_t e = rings_.offset[r]; e < rings_.offset[r + 1]; ++e)
      given[rings_.neighbour[e]] += taken_[e] * k_[r];
  scale_ = std::move(given);
  for (std::size_t i = 0; i < n; ++i) scale_[i] = pull_[i] / scale_[i];

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
    // If the weights lie along a line, the rotation about it is undetermined: it becomes 0.
    const double little = 1e-9 * (region.inertia[0] + region.inertia[1] + region.inertia[2]);
    for (std::size_t c = 0; c < 3; ++c) region.inertia[c] += little;
  }
}

double RegionStiffness::mean_edge() const {
  double sum = 0.0;
  for (std::size_t r = 0; r < size(); ++r)
    for (const std::uint32_t i : rings_[r]) {
      const Vector3d d = rest(i) - rest(r);
      sum += std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
  return sum / static_cast<double>(rings_.neighbour.size());
}

// Each piece computes every region that reaches into it, so that a vertex's sum runs over its regions in
// ascending order however the body is divided.
void RegionStiffness::apply(const std::vector<Vector3d>& x, std::vector<Vector3d>& y) const {
  y.resize(size());
  const std::size_t pieces = std::clamp<std::size_t>(size() / least_vertices_a_thread, 1, threads_);
  base::for_each_in_parallel(pieces, pieces, [&](std::size_t piece, std::size_t) {
    apply_to(size() * piece / pieces, size() * (piece + 1) / pieces, x, y);
  });
}

void RegionStiffness::apply_to(std::size_t begin, std::size_t end, const std::vector<Vector3d>& x,
                               std::vector<Vector3d>& y) const {
  std::size_t first = begin, last = end;
  for (std::size_t i = begin; i < end; ++i) {
    y[i] = Vector3d::Zero();
    if (rings_.degree(i) == 0) continue;
    first = std::min<std::size_t>(first, rings_[i].front());
    last = std::max<std::size_t>(last, rings_[i].back() + 1);
  }
  std::vector<Member> members;
  for (std::size_t r = first; r < last; ++r) {
    if (!touches_[r]) continue;
    const bool inside = r >= begin && r < end;
    if (!inside) {
      const auto ring = rings_[r];
      const auto reached = std::lower_bound(ring.begin(), ring.end(), begin);
      if (reached == ring.end() || *reached >= end) continue;
    }
    Vector3d moved = Vector3d::Zero(), turned = Vector3d::Zero();
    members.clear();
    for_each_member(r, [&](std::size_t i, double w, const Vector3d& p) {
      moved += w * x[i];
      turned += w * p.cross(x[i]);
      members.push_back({i, w, p});
    });
    const Vector3d c = moved / regions_[r].weight;
    const Vector3d turn = solve_symmetric(regions_[r].inertia, turned);
    for (const auto& [i, w, p] : members)
      if (i >= begin && i < end && is_free_[i]) y[i] += w * (x[i] - c - turn.cross(p));
  }
}

}  // namespace fascicle::build
