#include "host/build/check_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "host/build/mass.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

using scene::Vector3d;

constexpr double flat_ratio = 1e-12;

// Bars whose cells get finer along all axes towards where they are held, floats against the Oracle: 1:10
// costs 1e-6 of the length, 1:15 4e-5, 1:20 1e-4, 1:30 5e-4, 1:60 and 1:100 1e-3, 1:300 1e-2. Against other
// programs in double precision, which read the file's exact positions, 1:30 cost 2e-3 and 1:100 1e-2. From
// this limit on, errors exceed 1e-3.
constexpr double least_flatness = 1.0 / 20.0;

// A few such vertices of many are chance: a cage of 7,000 has one at 1:23. They deserve a warning only from
// 1:30 on, where errors exceed 2e-3 of the length, which can be seen. Uneven meshes have whole slices.
constexpr double share_by_chance = 1e-3;
constexpr double visible_flatness = 1.0 / 30.0;

double longest_edge_squared(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
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

bool has_volume(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  const double edge2 = longest_edge_squared(mesh, t);
  return std::abs(signed_volume(mesh, t)) > flat_ratio * (edge2 * std::sqrt(edge2));
}

}  // namespace

std::vector<std::uint32_t> tetrahedra_without_volume(const mesh::TetMesh& mesh) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t k = 0; k < mesh.tetrahedra.size(); ++k)
    if (!has_volume(mesh, mesh.tetrahedra[k])) found.push_back(k);
  return found;
}

void check_and_orient(mesh::TetMesh& mesh, const std::string& source, Report& report) {
  const std::size_t vertex_count = mesh.vertices.size();
  const std::size_t tetrahedron_count = mesh.tetrahedra.size();
  if (tetrahedron_count == 0) fail(source, "mesh: there are no tetrahedra");
  // Corner lists and one-rings are indexed in 32 bits.
  if (vertex_count > std::numeric_limits<std::uint32_t>::max() / 4 ||
      tetrahedron_count > std::numeric_limits<std::uint32_t>::max() / 4)
    fail(source, "mesh: " + std::to_string(tetrahedron_count) +
                     " tetrahedra are too many to index; use a coarser mesh");

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
    if (!has_volume(mesh, t)) {
      flat.push_back(k);
    } else if (signed_volume(mesh, t) < 0.0) {
      std::swap(t[2], t[3]);
      ++report.flipped_tetrahedra;
    }
  }
  if (!out_of_range.empty())
    fail(source, "mesh: corner numbers must be below " + std::to_string(vertex_count) +
                     ", the number of vertices, but are not in tetrahedron " + list_of(out_of_range) +
                     " (counted from 0)");
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

double flatness(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  double largest = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3d& a = mesh.vertices[t[k]];
    const Vector3d face = (mesh.vertices[t[(k + 1) % 4]] - a).cross(mesh.vertices[t[(k + 2) % 4]] - a);
    largest = std::max(largest, face.norm() / 2.0);
  }
  return 3.0 * std::abs(signed_volume(mesh, t)) / largest / std::sqrt(2.0 * largest);
}

void warn_of_flat_tetrahedra(const mesh::TetMesh& mesh, const std::vector<char>& is_kinematic,
                             const std::vector<std::uint32_t>& source_vertex, Report& report) {
  std::vector<double> best(mesh.vertices.size(), 0.0);
  for (const auto& t : mesh.tetrahedra) {
    const double of_this = flatness(mesh, t);
    for (const std::uint32_t corner : t) best[corner] = std::max(best[corner], of_this);
  }
  std::vector<std::uint32_t> flat;
  std::size_t soft = 0;
  double flattest = least_flatness;
  for (std::uint32_t i = 0; i < best.size(); ++i) {
    if (is_kinematic[i]) continue;
    ++soft;
    if (best[i] >= least_flatness) continue;
    flat.push_back(source_vertex[i]);
    flattest = std::min(flattest, best[i]);
  }
  const bool is_chance = static_cast<double>(flat.size()) <= share_by_chance * static_cast<double>(soft);
  if (flat.empty() || (is_chance && flattest >= visible_flatness)) return;
  std::sort(flat.begin(), flat.end());
  warn_of_flesh(
      report,
      counted(flat.size(), "vertex lies", "vertices lie") +
          " among tetrahedra flatter than 1:" + std::to_string(std::lround(1.0 / least_flatness)) +
          ", down to 1:" + std::to_string(std::lround(1.0 / flattest)) +
          ": rounding may move flesh there by 0.001 of the body's length or more; make the mesh more even",
      flat);
}

}  // namespace fascicle::build
