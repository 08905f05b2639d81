// The stiffness of a body's regions about rest, K_i (x_i - g_i(x)) with rotations to first order. It is
// symmetric because the goals minimise the regions' energy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/build/one_ring.h"
#include "host/build/weights.h"

namespace fascicle::build {

struct ElasticBody {
  const OneRings& rings;
  const RestState& state;
  const RegionWeights& weights;  // w_ir of (12), without k_r
  std::span<const double> k;     // k_r of each region, 1/s^2
};

// The inverse of a symmetric matrix times a vector, by the adjugate; order xx yy zz xy xz yz.
Eigen::Vector3d solve_symmetric(const std::array<double, 6>& m, const Eigen::Vector3d& b);

// Keeps references to the body's data and to `is_free`.
class RegionStiffness {
 public:
  RegionStiffness(const ElasticBody& body, const std::vector<char>& is_free, std::size_t threads);

  std::size_t size() const { return pull_.size(); }
  std::size_t threads() const { return threads_; }
  const std::vector<char>& is_free() const { return is_free_; }
  Eigen::Vector3d rest(std::size_t i) const { return rest_at(state_, i); }
  double mass(std::size_t i) const { return state_.mass[i]; }
  // The diagonal entry of each of i's three coordinates.
  double diagonal(std::size_t i) const { return pull_[i]; }
  double mean_edge() const;

  // y = L x at the free vertices, 0 elsewhere; x must be 0 at the held ones.
  void apply(const std::vector<Eigen::Vector3d>& x, std::vector<Eigen::Vector3d>& y) const;

  bool touches_free(std::size_t r) const { return touches_[r] != 0; }
  double weight(std::size_t r) const { return regions_[r].weight; }
  const std::array<double, 6>& inertia(std::size_t r) const { return regions_[r].inertia; }
  // visit(i, w_ir, q0_i - c0_r), the region's own vertex first.
  template <class Visit>
  void for_each_member(std::size_t r, Visit visit) const {
    const Eigen::Vector3d here = rest(r), centre = centre_[r];
    visit(r, own_[r] * k_[r] * scale_[r], Eigen::Vector3d(Eigen::Vector3d::Zero() - centre));
    for (std::uint32_t e = rings_.offset[r]; e < rings_.offset[r + 1]; ++e) {
      const std::size_t i = rings_.neighbour[e];
      visit(i, taken_[e] * k_[r] * scale_[i], Eigen::Vector3d((rest(i) - here) - centre));
    }
  }

 private:
  struct Region {
    double weight = 0.0;
    std::array<double, 6> inertia{};  // sum w (|r|^2 I - r r^T)
  };
  void apply_to(std::size_t begin, std::size_t end, const std::vector<Eigen::Vector3d>& x,
                std::vector<Eigen::Vector3d>& y) const;

  const OneRings& rings_;
  RestState state_;
  std::span<const double> own_, taken_, k_;
  const std::vector<char>& is_free_;
  std::size_t threads_;
  std::vector<double> pull_, scale_;     // scale_: makes the k_r w_ir of a vertex sum to its pull
  std::vector<Eigen::Vector3d> centre_;  // c0_r relative to the region's own vertex
  std::vector<Region> regions_;
  std::vector<char> touches_;  // per region: whether it holds a free vertex
};

}  // namespace fascicle::build
