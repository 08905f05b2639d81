#include "host/build/refine.h"

#include <map>
#include <utility>

namespace fascicle::build {

namespace {

constexpr int most_rounds = 6;

using Corner = std::array<double, 3>;

Corner middle(const Corner& a, const Corner& b) {
  return {(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0, (a[2] + b[2]) / 2.0};
}

// Appends the mean of two rows.
void add_mean(SkinWeights& weights, std::uint32_t a, std::uint32_t b) {
  std::map<std::uint32_t, double> sum;
  for (const std::uint32_t v : {a, b})
    for (std::uint32_t k = weights.offset[v]; k < weights.offset[v + 1]; ++k)
      sum[weights.joint[k]] += weights.weight[k] / 2.0;
  for (const auto& [joint, weight] : sum) {
    weights.joint.push_back(joint);
    weights.weight.push_back(weight);
  }
  weights.offset.push_back(static_cast<std::uint32_t>(weights.joint.size()));
}

bool halve_sides(RefinedSkin& skin, double longest) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> halves;
  for (const auto& t : skin.surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto side = std::minmax(t[k], t[(k + 1) % 3]);
      const scene::Vector3d a = skin.surface.vertices[side.first], b = skin.surface.vertices[side.second];
      if (!((a - b).norm() > longest) || halves.contains(side)) continue;
      halves[side] = static_cast<std::uint32_t>(skin.surface.vertices.size());
      skin.surface.vertices.push_back((a + b) / 2.0);
      if (!skin.weights.offset.empty()) add_mean(skin.weights, side.first, side.second);
    }
  if (halves.empty()) return false;
  RefinedSkin finer;
  const auto add = [&](std::size_t from, std::array<std::uint32_t, 3> t, std::array<Corner, 3> corners) {
    finer.surface.triangles.push_back(t);
    finer.parent.push_back(skin.parent[from]);
    finer.corners.push_back(corners);
  };
  for (std::size_t i = 0; i < skin.surface.triangles.size(); ++i) {
    std::array<std::uint32_t, 3> t = skin.surface.triangles[i];
    std::array<Corner, 3> c = skin.corners[i];
    const auto half = [&](std::size_t k) { return halves.find(std::minmax(t[k], t[(k + 1) % 3])); };
    const auto is_halved = [&](std::size_t k) { return half(k) != halves.end(); };
    const int count = (is_halved(0) ? 1 : 0) + (is_halved(1) ? 1 : 0) + (is_halved(2) ? 1 : 0);
    // Turned so that side 0 is halved, and side 1 next, or side 2 is not.
    for (int turn = 0; turn < 2 && (count == 1 ? !is_halved(0) : count == 2 && is_halved(2)); ++turn) {
      t = {t[1], t[2], t[0]};
      c = {c[1], c[2], c[0]};
    }
    const Corner c01 = middle(c[0], c[1]), c12 = middle(c[1], c[2]), c20 = middle(c[2], c[0]);
    if (count == 0) {
      add(i, t, c);
    } else if (count == 1) {
      const std::uint32_t m = half(0)->second;
      add(i, {t[0], m, t[2]}, {c[0], c01, c[2]});
      add(i, {m, t[1], t[2]}, {c01, c[1], c[2]});
    } else {
      const std::uint32_t m = half(0)->second, n = half(1)->second;
      add(i, {m, t[1], n}, {c01, c[1], c12});
      if (count == 2) {
        add(i, {t[0], m, n}, {c[0], c01, c12});
        add(i, {t[0], n, t[2]}, {c[0], c12, c[2]});
      } else {
        const std::uint32_t o = half(2)->second;
        add(i, {t[0], m, o}, {c[0], c01, c20});
        add(i, {n, t[2], o}, {c12, c[2], c20});
        add(i, {m, n, o}, {c01, c12, c20});
      }
    }
  }
  skin.surface.triangles = std::move(finer.surface.triangles);
  skin.parent = std::move(finer.parent);
  skin.corners = std::move(finer.corners);
  return true;
}

}  // namespace

SkinPoint RefinedSkin::on_skin(const SkinPoint& point) const {
  SkinPoint result{parent[point.triangle], {0.0, 0.0, 0.0}};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t k = 0; k < 3; ++k) result.weights[k] += point.weights[c] * corners[point.triangle][c][k];
  return result;
}

RefinedSkin refine_skin(const scene::SurfaceMesh& skin, const SkinWeights& weights, double longest) {
  RefinedSkin refined{skin, weights, {}, {}};
  for (std::uint32_t i = 0; i < skin.triangles.size(); ++i) {
    refined.parent.push_back(i);
    refined.corners.push_back({Corner{1, 0, 0}, Corner{0, 1, 0}, Corner{0, 0, 1}});
  }
  for (int round = 0; round < most_rounds && halve_sides(refined, longest); ++round) {
  }
  return refined;
}

}  // namespace fascicle::build
