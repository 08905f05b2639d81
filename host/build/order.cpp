#include "host/build/order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "host/build/cube_root.h"
#include "host/build/mass.h"

namespace fascicle::build {

namespace {

constexpr double slab_spacings = 2.0;
constexpr std::size_t degree_window = 256;

// An even permutation of corners that puts the two lowest first, in order.
std::array<std::uint32_t, 4> lowest_first(std::array<std::uint32_t, 4> t) {
  const auto rotate = [&](std::size_t a, std::size_t b, std::size_t c) {
    const std::uint32_t kept = t[a];
    t[a] = t[b];
    t[b] = t[c];
    t[c] = kept;
  };
  const std::ptrdiff_t lowest = std::min_element(t.begin(), t.end()) - t.begin();
  if (lowest == 1) rotate(0, 1, 2);
  if (lowest == 2) rotate(0, 2, 3);
  if (lowest == 3) rotate(0, 3, 1);
  const std::ptrdiff_t second = std::min_element(t.begin() + 1, t.end()) - t.begin();
  if (second == 2) rotate(1, 2, 3);
  if (second == 3) rotate(1, 3, 2);
  return t;
}

}  // namespace

std::vector<std::uint32_t> locality_order(const mesh::TetMesh& mesh, const OneRings& rings) {
  const std::size_t n = mesh.vertices.size();
  Vector3d low = mesh.vertices[0], high = mesh.vertices[0];
  for (const Vector3d& p : mesh.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  std::array<int, 3> axis{0, 1, 2};
  std::stable_sort(axis.begin(), axis.end(),
                   [&](int a, int b) { return high[a] - low[a] > high[b] - low[b]; });
  const double thickness = slab_spacings * cube_root(total_volume(mesh) / static_cast<double>(n));

  // Ties are broken by the other coordinates, so that vertices in different places are ordered by position
  // alone.
  struct Place {
    double slab, strip;
    Vector3d point;  // along the third, second and longest axis
    std::uint32_t vertex;
    bool operator<(const Place& other) const {
      return std::tie(slab, strip, point[0], point[1], point[2], vertex) <
             std::tie(other.slab, other.strip, other.point[0], other.point[1], other.point[2], other.vertex);
    }
  };
  std::vector<Place> places(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vector3d p = mesh.vertices[i] - low;
    places[i] = {std::floor(p[axis[0]] / thickness),
                 std::floor(p[axis[1]] / thickness),
                 {p[axis[2]], p[axis[1]], p[axis[0]]},
                 i};
  }
  std::sort(places.begin(), places.end());

  std::vector<std::uint32_t> order(n);
  std::transform(places.begin(), places.end(), order.begin(), [](const Place& p) { return p.vertex; });
  for (std::size_t begin = 0; begin < n; begin += degree_window) {
    const auto first = order.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = order.begin() + static_cast<std::ptrdiff_t>(std::min(n, begin + degree_window));
    std::stable_sort(first, last,
                     [&](std::uint32_t a, std::uint32_t b) { return rings.degree(a) > rings.degree(b); });
  }
  return order;
}

void renumber(Body& body, const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> number(order.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) number[order[k]] = k;

  std::vector<Vector3d> vertices(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) vertices[k] = body.mesh.vertices[order[k]];
  body.mesh.vertices = std::move(vertices);
  for (auto& t : body.mesh.tetrahedra) {
    for (std::uint32_t& corner : t) corner = number[corner];
    t = lowest_first(t);
  }
  std::sort(body.mesh.tetrahedra.begin(), body.mesh.tetrahedra.end());
  for (auto& corners : body.render.corners)
    for (std::uint32_t& corner : corners) corner = number[corner];

  if (!body.holding.empty()) {
    std::vector<Holding> holding;
    for (const std::uint32_t old : order) holding.push_back(body.holding[old]);
    body.holding = std::move(holding);
  }

  if (body.skin.offset.empty()) return;
  SkinWeights skin;
  skin.offset.push_back(0);
  for (const std::uint32_t old : order) {
    for (std::uint32_t k = body.skin.offset[old]; k < body.skin.offset[old + 1]; ++k) {
      skin.joint.push_back(body.skin.joint[k]);
      skin.weight.push_back(body.skin.weight[k]);
    }
    skin.offset.push_back(static_cast<std::uint32_t>(skin.joint.size()));
  }
  body.skin = std::move(skin);
}

}  // namespace fascicle::build
