#include "host/build/skin_inside.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "host/base/trigonometry.h"
#include "host/build/unions.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

// This many directions give the winding number of an open part to about a tenth.
constexpr std::size_t direction_count = 24;
// If this many agree that the skin encloses the point, or that nothing does, the rest are skipped.
constexpr std::size_t first_directions = 6;

// Evenly distributed over the sphere, also the first few: by irrational increments of height and angle.
std::array<Vector3d, direction_count> even_directions() {
  std::array<Vector3d, direction_count> directions;
  constexpr double turn = 0.6180339887498949, rise = 0.7548776662466927;
  for (std::size_t k = 0; k < direction_count; ++k) {
    const double z = 2.0 * std::fmod(0.5 + rise * static_cast<double>(k), 1.0) - 1.0;
    const double angle = 2.0 * std::numbers::pi * std::fmod(0.3 + turn * static_cast<double>(k), 1.0);
    const double radius = std::sqrt(1.0 - z * z);
    directions[k] = {radius * base::exact_cos(angle), radius * base::exact_sin(angle), z + 1e-9};
  }
  return directions;
}

}  // namespace

SkinInside::SkinInside(const mesh::SurfaceMesh& surface) : search_(surface) {
  std::map<std::tuple<double, double, double>, std::uint32_t> at_place;
  Unions parts(surface.vertices.size());
  for (std::uint32_t v = 0; v < surface.vertices.size(); ++v) {
    const Vector3d& p = surface.vertices[v];
    parts.join(v, at_place.try_emplace({p.x(), p.y(), p.z()}, v).first->second);
  }
  for (const auto& t : surface.triangles) {
    parts.join(t[0], t[1]);
    parts.join(t[1], t[2]);
  }
  part_of_triangle_.reserve(surface.triangles.size());
  for (const auto& t : surface.triangles) part_of_triangle_.push_back(parts.find(t[0]));
}

bool SkinInside::contains(const Vector3d& point) const {
  static const std::array<Vector3d, direction_count> directions = even_directions();
  std::vector<std::pair<std::uint32_t, int>> of_parts;  // part, outward minus inward crossings
  const auto add = [&](std::uint32_t triangle, int outward) {
    const std::uint32_t part = part_of_triangle_[triangle];
    for (auto& [known, sum] : of_parts)
      if (known == part) {
        sum += outward;
        return;
      }
    of_parts.emplace_back(part, outward);
  };
  std::size_t around = 0, apart = 0;
  int whole = 0;
  const auto goes_around = [](int crossings, std::size_t rays) {
    return 2 * static_cast<std::size_t>(std::abs(crossings)) > rays;
  };
  for (std::size_t k = 0; k < direction_count; ++k) {
    int all = 0;
    bool is_crossed = false;
    search_.for_each_crossing(point, directions[k], [&](std::uint32_t triangle, bool is_outward) {
      add(triangle, is_outward ? 1 : -1);
      all += is_outward ? 1 : -1;
      is_crossed = true;
    });
    whole += all;
    around += all > 0 ? 1 : 0;
    apart += is_crossed ? 0 : 1;
    if (k + 1 != first_directions) continue;
    if (around == first_directions) return true;
    if (apart == first_directions) return false;
  }
  return goes_around(whole, direction_count) ||
         std::any_of(of_parts.begin(), of_parts.end(),
                     [&](const auto& part) { return goes_around(part.second, direction_count); });
}

}  // namespace fascicle::build
