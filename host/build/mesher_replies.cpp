#include "host/build/mesher_replies.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <locale>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <string.h>

#include "host/build/boundary.h"
#include "host/build/mass.h"
#include "host/build/mesher.h"

namespace fascicle::build {
namespace {

using mesh::SurfaceMesh;
using mesh::TetMesh;
using scene::SceneError;

constexpr std::size_t kinds_of_findings = 9;

Finding* finding_of(SurfaceFindings& findings, const std::string& name) {
  if (name == "parts") return &findings.parts;
  if (name == "loose_vertices") return &findings.loose_vertices;
  if (name == "flat_triangles") return &findings.flat_triangles;
  if (name == "open_edges") return &findings.open_edges;
  if (name == "non_manifold_edges") return &findings.non_manifold_edges;
  if (name == "non_manifold_vertices") return &findings.non_manifold_vertices;
  if (name == "turned_edges") return &findings.turned_edges;
  if (name == "inverted_parts") return &findings.inverted_parts;
  if (name == "intersections") return &findings.intersections;
  return nullptr;
}

[[noreturn]] void fail_report() {
  fail_result("its report ends early or cannot be read");
}

// TetGen orients all tetrahedra the same way; ours have positive volume. One that differs from the rest, or
// is flat, is an error and not reoriented: it would be an overlap.
void orient(TetMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.tetrahedra) sum += signed_volume(mesh, t);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    auto& t = mesh.tetrahedra[i];
    if (sum < 0.0) std::swap(t[2], t[3]);
    if (!(signed_volume(mesh, t) > 0.0)) {
      fail_result("tetrahedron " + std::to_string(i) + " is flat or turned inside out");
    }
  }
}

void check_surface_vertices(const TetMesh& mesh, const SurfaceMesh& surface) {
  if (mesh.vertices.size() < surface.vertices.size()) fail_result("it lacks vertices of the surface");
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    if (::memcmp(mesh.vertices[i].data(), surface.vertices[i].data(), 3 * sizeof(double)) != 0) {
      fail_result("vertex " + std::to_string(i) + " of the surface was moved");
    }
  }
}

// Removes points that TetGen left out because they lie outside or on another vertex.
void drop_unused(TetMesh& mesh, std::size_t surface_count) {
  constexpr std::uint32_t unused = UINT32_MAX;
  std::vector<std::uint32_t> number(mesh.vertices.size(), unused);
  for (const auto& t : mesh.tetrahedra) {
    for (const std::uint32_t v : t) number[v] = 0;
  }
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == unused) {
      if (i < surface_count)
        fail_result("vertex " + std::to_string(i) + " of the surface is in no tetrahedron");
      continue;
    }
    mesh.vertices[next] = mesh.vertices[i];
    number[i] = next++;
  }
  mesh.vertices.resize(next);
  for (auto& t : mesh.tetrahedra) {
    for (std::uint32_t& v : t) v = number[v];
  }
}

std::vector<std::array<std::uint32_t, 3>> sorted_corners(
    std::vector<std::array<std::uint32_t, 3>> triangles) {
  for (auto& t : triangles) std::sort(t.begin(), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

// The boundary must equal the surface, triangle for triangle. With positive volumes this also makes the total
// volume the surface's.
void check_boundary(const TetMesh& mesh, const SurfaceMesh& surface) {
  const auto boundary = sorted_corners(boundary_triangles(mesh, mesher_name));
  const auto wanted = sorted_corners(surface.triangles);
  if (boundary == wanted) return;
  if (!std::includes(wanted.begin(), wanted.end(), boundary.begin(), boundary.end())) {
    fail_result("its outside is not the surface");
  }
  std::vector<std::array<std::uint32_t, 3>> enclosed;
  std::set_difference(wanted.begin(), wanted.end(), boundary.begin(), boundary.end(),
                      std::back_inserter(enclosed));
  const auto& t = enclosed.front();
  throw SceneError("part of the surface lies inside another part (the triangle of vertices " +
                   std::to_string(t[0]) + ", " + std::to_string(t[1]) + " and " + std::to_string(t[2]) +
                   ", counted from 0, and " + std::to_string(enclosed.size() - 1) +
                   " more); remove the inner part");
}

}  // namespace

void check_filling(TetMesh& mesh, const SurfaceMesh& surface) {
  check_surface_vertices(mesh, surface);
  orient(mesh);
  drop_unused(mesh, surface.vertices.size());
  check_boundary(mesh, surface);
}

SurfaceFindings parse_findings(const std::string& text, std::size_t vertex_count) {
  SurfaceFindings findings;
  std::set<std::string> read;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    std::string name;
    words >> name;
    if (name == "end" && read.size() == kinds_of_findings + 1) return findings;
    Finding* finding = finding_of(findings, name);
    if ((finding == nullptr && name != "genus") || !read.insert(name).second) break;
    // Signed: a stream would read -1 as the largest unsigned number.
    std::vector<std::int64_t> numbers;
    while (!(words >> std::ws).eof()) {
      std::int64_t number = 0;
      if (!(words >> number)) fail_report();
      numbers.push_back(number);
    }
    if (numbers.empty()) break;
    if (finding == nullptr) {
      if (numbers.size() != 1) break;
      findings.genus = numbers[0];
      continue;
    }
    if (numbers[0] < 0) break;
    finding->count = static_cast<std::uint64_t>(numbers[0]);
    for (std::size_t k = 1; k < numbers.size(); ++k) {
      if (!std::in_range<std::uint32_t>(numbers[k]) || static_cast<std::uint64_t>(numbers[k]) >= vertex_count)
        fail_result("its report names a vertex that does not exist");
      finding->vertices.push_back(static_cast<std::uint32_t>(numbers[k]));
    }
  }
  fail_report();
}

WrapLengths parse_wrap_lengths(const std::string& line) {
  std::istringstream words(line);
  words.imbue(std::locale::classic());
  std::string alpha, offset;
  WrapLengths used;
  words >> alpha >> used.alpha >> offset >> used.offset;
  if (!words || alpha != "alpha" || offset != "offset" || !(used.alpha > 0.0) || !(used.offset > 0.0))
    fail_result("it does not say its alpha and offset");
  return used;
}

}  // namespace fascicle::build
