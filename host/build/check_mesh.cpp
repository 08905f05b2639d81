#include "host/build/check_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/build/mass.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

constexpr double flat_ratio = 1e-12;

double longest_edge_squared(const scene::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  double longest = 0.0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b)
      longest = std::max(longest, (mesh.vertices[t[a]] - mesh.vertices[t[b]]).squaredNorm());
  return longest;
}

bool names_a_corner_twice(std::array<std::uint32_t, 4> t) {
  std::sort(t.begin(), t.end());
  return std::adjacent_find(t.begin(), t.end()) != t.end();
}

}  // namespace

void check_and_orient(scene::TetMesh& mesh, const std::string& source, Report& report) {
  const std::size_t vertex_count = mesh.vertices.size();
  const std::size_t tetrahedron_count = mesh.tetrahedra.size();
  if (tetrahedron_count == 0) fail(source, "mesh: there are no tetrahedra");
  // Corner lists and one-rings are indexed in 32 bits.
  if (vertex_count > std::numeric_limits<std::uint32_t>::max() / 4 ||
      tetrahedron_count > std::numeric_limits<std::uint32_t>::max() / 4)
    fail(source, "mesh: " + std::to_string(tetrahedron_count) +
                     " tetrahedra are more than can be numbered; use a coarser mesh");

  std::vector<std::uint32_t> bad;
  for (std::uint32_t i = 0; i < vertex_count; ++i)
    if (!mesh.vertices[i].allFinite()) bad.push_back(i);
  if (!bad.empty())
    fail(source, "mesh: coordinates are not finite at vertex " + list_of(bad) + " (counted from 0)");

  std::vector<char> used(vertex_count, 0);
  std::vector<std::uint32_t> out_of_range, repeated, flat;
  for (std::uint32_t k = 0; k < tetrahedron_count; ++k) {
    auto& t = mesh.tetrahedra[k];
    if (*std::max_element(t.begin(), t.end()) >= vertex_count) {
      out_of_range.push_back(k);
      continue;
    }
    for (const std::uint32_t corner : t) used[corner] = 1;
    if (names_a_corner_twice(t)) {
      repeated.push_back(k);
      continue;
    }
    const double volume = signed_volume(mesh, t);
    const double edge2 = longest_edge_squared(mesh, t);
    if (!(std::abs(volume) > flat_ratio * (edge2 * std::sqrt(edge2)))) {
      flat.push_back(k);
    } else if (volume < 0.0) {
      std::swap(t[2], t[3]);
      ++report.flipped_tetrahedra;
    }
  }
  if (!out_of_range.empty())
    fail(source, "mesh: a corner is not below the " + std::to_string(vertex_count) +
                     " vertices in tetrahedron " + list_of(out_of_range) + " (counted from 0)");
  if (!repeated.empty())
    fail(source, "mesh: one vertex is named twice in tetrahedron " + list_of(repeated) +
                     " (counted from 0); remove it");
  if (!flat.empty())
    fail(source, "mesh: no volume in tetrahedron " + list_of(flat) +
                     " (counted from 0); remove it or move its corners");

  std::vector<std::uint32_t> unused;
  for (std::uint32_t i = 0; i < vertex_count; ++i)
    if (!used[i]) unused.push_back(i);
  if (!unused.empty())
    fail(source, "mesh: no tetrahedron uses vertex " + list_of(unused) + " (counted from 0); remove it");
}

}  // namespace fascicle::build
