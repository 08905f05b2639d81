#include "tests/support/limit_models.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

namespace fascicle::tests {

using Eigen::Vector3d;

void add_limits(model::Model& model, double share) {
  const auto rest = [&](std::uint32_t i) {
    return Vector3d(model.rest[3 * i], model.rest[3 * i + 1], model.rest[3 * i + 2]);
  };
  double mass = 0.0;
  int free = 0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (!model.is_kinematic(i)) {
      mass += model.mass[i];
      ++free;
    }
  model.limit.clear();
  model.mobility.clear();
  std::vector<std::vector<std::uint32_t>> entries(model.vertex_count);
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4) {
    std::array<std::uint32_t, 4> c{};
    bool some_free = false;
    for (std::size_t k = 0; k < 4; ++k) {
      c[k] = model.tetrahedron[t + k];
      some_free = some_free || !model.is_kinematic(c[k]);
    }
    const double six = (rest(c[1]) - rest(c[0])).cross(rest(c[2]) - rest(c[0])).dot(rest(c[3]) - rest(c[0]));
    if (!some_free || !(six > 0.0)) continue;
    double edges = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t j = 0; j < k; ++j) edges += (rest(c[k]) - rest(c[j])).norm();
      const std::uint32_t x = c[(k + 1) % 4], y = c[(k + 2) % 4], z = c[(k + 3) % 4];
      squares += (rest(y) - rest(x)).cross(rest(z) - rest(x)).squaredNorm();
      entries[c[k]].push_back(std::uint32_t(4 * model.limit.size() + k));
    }
    const double size = std::exp2(std::floor(std::log2(edges / 6.0)));
    model.limit.push_back({c[0], c[1], c[2], c[3], float(1.0 / size), float(size),
                           float(share * six / std::pow(size, 3)),
                           float(0.01 * squares / 4.0 / std::pow(size, 4))});
  }
  model.limit_offset = {0};
  model.limit_entry.clear();
  for (const auto& of_vertex : entries) {
    model.limit_entry.insert(model.limit_entry.end(), of_vertex.begin(), of_vertex.end());
    model.limit_offset.push_back(std::uint32_t(model.limit_entry.size()));
  }
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    model.mobility.push_back(model.is_kinematic(i) ? 0.0f : float(mass / free / model.mass[i]));
}

}  // namespace fascicle::tests
