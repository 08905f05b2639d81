#include "host/build/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "host/build/points.h"

namespace fascicle::build {

namespace {

using Eigen::Vector3d;
using model::Model;

// Share of the gradients' mean square at rest. A tetrahedron collapsed below it is moved by less than its
// full deficit.
constexpr double least_square_share = 0.01;

Vector3d area(const Vector3d& u, const Vector3d& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

double square(const Vector3d& v) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

shader::Limit limit_of(const Model& model, const std::array<std::uint32_t, 4>& corner, double share) {
  const auto rest = [&](std::uint32_t i) { return vector_at(model.rest, i); };
  double edges = 0.0;
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t k = 0; k < j; ++k) edges += std::sqrt(square(rest(corner[j]) - rest(corner[k])));
  const double size = std::ldexp(1.0, std::ilogb(edges / 6.0));
  const Vector3d a = rest(corner[0]);
  const Vector3d u = (rest(corner[1]) - a) / size, v = (rest(corner[2]) - a) / size,
                 w = (rest(corner[3]) - a) / size;
  const Vector3d by_b = area(v, w), by_c = area(w, u), by_d = area(u, v), by_a = by_b + by_c + by_d;
  const double volume = u[0] * by_b[0] + u[1] * by_b[1] + u[2] * by_b[2];
  const double mean_square = (square(by_a) + square(by_b) + square(by_c) + square(by_d)) / 4.0;
  return {corner[0],
          corner[1],
          corner[2],
          corner[3],
          static_cast<float>(1.0 / size),
          static_cast<float>(size),
          model::as_factor(share * volume),
          model::as_factor(least_square_share * mean_square)};
}

}  // namespace

void write_limits(const std::vector<double>& least_volume, Model& model) {
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    std::array<std::uint32_t, 4> corner{};
    double share = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      corner[k] = model.tetrahedron[t + k];
      if (!model.is_kinematic(corner[k])) share = std::max(share, least_volume[model.layer_of(corner[k])]);
    }
    if (!(share > 0.0)) continue;
    const shader::Limit limit = limit_of(model, corner, share);
    // Skips slivers whose volume is only rounding.
    if (limit.least > 0.0f && limit.least_square > 0.0f) model.limit.push_back(limit);
  }
  if (model.limit.empty()) return;
  const auto number = [](const shader::Limit& l) {
    return std::min({l.corner_a, l.corner_b, l.corner_c, l.corner_d});
  };
  std::stable_sort(model.limit.begin(), model.limit.end(),
                   [&](const shader::Limit& a, const shader::Limit& b) { return number(a) < number(b); });
  std::vector<std::vector<std::uint32_t>> entries(model.vertex_count);
  for (std::uint32_t t = 0; t < model.limit.size(); ++t) {
    const shader::Limit& l = model.limit[t];
    std::uint32_t k = 0;
    for (const std::uint32_t i : {l.corner_a, l.corner_b, l.corner_c, l.corner_d})
      entries[i].push_back(4 * t + k++);
  }
  model.limit_offset.push_back(0);
  for (const std::vector<std::uint32_t>& of_vertex : entries) {
    model.limit_entry.insert(model.limit_entry.end(), of_vertex.begin(), of_vertex.end());
    model.limit_offset.push_back(static_cast<std::uint32_t>(model.limit_entry.size()));
  }
  write_mobility(model);
}

void write_mobility(Model& model) {
  double mass = 0.0, free = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    mass += model.mass[i];
    free += 1.0;
  }
  model.mobility.clear();
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    model.mobility.push_back(
        model.is_kinematic(i)
            ? 0.0f
            : std::max(static_cast<float>(mass / (free * model.mass[i])), model::least_factor));
}

}  // namespace fascicle::build
