#include "cpu_reference/oracle/oracle_limit.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include <Eigen/Geometry>

namespace fascicle::cpu_reference {

using Eigen::Vector3d;

namespace {

// The share of its initial lack by which a tetrahedron opens per substep: at most, and per second.
constexpr double most_opening = 1.0, opening_rate = 240.0;

}  // namespace

// V = (b - a) . (c - a) x (d - a) / 6; the gradient by a corner is a third of the opposite face's vector
// area, directed towards the corner.
VolumeGradients volume_gradients(const Points& q, const std::array<std::uint32_t, 4>& corner) {
  const Vector3d &a = q[corner[0]], &b = q[corner[1]], &c = q[corner[2]], &d = q[corner[3]];
  VolumeGradients g;
  g.by[0] = (d - b).cross(c - b) / 6.0;
  g.by[1] = (c - a).cross(d - a) / 6.0;
  g.by[2] = (d - a).cross(b - a) / 6.0;
  g.by[3] = (b - a).cross(c - a) / 6.0;
  g.volume = g.by[1].dot(b - a);
  return g;
}

// A Limit stores 6 times the volume and 36 times squared gradients, in units of its size.
Limits::Limits(const model::Model& model) {
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    mobility_.push_back(model.is_kinematic(i) ? 0.0 : 1.0 / model.mass[i]);
  for (const shader::Limit& l : model.limit) {
    const double size = double{l.size};
    tetrahedra_.push_back({.corner = {l.corner_a, l.corner_b, l.corner_c, l.corner_d},
                           .least_volume = double{l.least} * size * size * size / 6.0,
                           .least_square = double{l.least_square} * size * size * size * size / 36.0});
  }
}

void Limits::apply(Points& q, const Points& before, double step) const {
  std::vector<double> least;
  for (const Tetrahedron& t : tetrahedra_) {
    const double lacked = std::max(0.0, t.least_volume - volume_gradients(before, t.corner).volume);
    least.push_back(t.least_volume - lacked * (1.0 - std::min(most_opening, opening_rate * step)));
  }
  for (std::uint32_t pass = 0; pass < shader::limit_passes; ++pass) {
    std::vector<double> crowd(q.size(), 0.0);
    std::vector<std::optional<VolumeGradients>> lacking;
    for (std::size_t k = 0; k < tetrahedra_.size(); ++k) {
      const VolumeGradients g = volume_gradients(q, tetrahedra_[k].corner);
      lacking.push_back(g.volume < least[k] ? std::optional(g) : std::nullopt);
      if (!lacking.back()) continue;
      for (const std::uint32_t i : tetrahedra_[k].corner) crowd[i] += 1.0;
    }
    Points moved = q;
    for (std::size_t k = 0; k < tetrahedra_.size(); ++k) {
      if (!lacking[k]) continue;
      const auto& [corner, least_volume, least_square] = tetrahedra_[k];
      double sum = 0.0;
      for (std::size_t j = 0; j < 4; ++j)
        sum += crowd[corner[j]] * mobility_[corner[j]] * (lacking[k]->by[j].squaredNorm() + least_square);
      const double push = (least[k] - lacking[k]->volume) / sum;
      for (std::size_t j = 0; j < 4; ++j) moved[corner[j]] += mobility_[corner[j]] * push * lacking[k]->by[j];
    }
    q = moved;
  }
}

}  // namespace fascicle::cpu_reference
