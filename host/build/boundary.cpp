#include "host/build/boundary.h"

#include <algorithm>
#include <limits>

#include "host/build/embedding.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

// Corners in ascending order; `outward`: whether this order faces outward.
struct Face {
  std::array<std::uint32_t, 3> corners;
  bool outward;
};

Face make_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  bool outward = true;
  if (a > b) std::swap(a, b), outward = !outward;
  if (b > c) std::swap(b, c), outward = !outward;
  if (a > b) std::swap(a, b), outward = !outward;
  return {{a, b, c}, outward};
}

// A range of lowest corners whose faces are processed together: all faces of a mesh at once would take a
// third of the memory of building it.
struct Band {
  std::uint32_t begin, end;
};

using Corners = std::array<std::uint32_t, 4>;

// `corners` returns the corners of tetrahedron k.
template <class CornersOf>
void collect_faces(std::size_t tetrahedra, const CornersOf& corners, Band band, std::vector<Face>& faces) {
  faces.clear();
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::uint32_t lowest = std::min({a, b, c});
    if (lowest >= band.begin && lowest < band.end) faces.push_back(make_face(a, b, c));
  };
  for (std::size_t k = 0; k < tetrahedra; ++k) {
    const Corners t = corners(k);
    add(t[1], t[2], t[3]);
    add(t[0], t[3], t[2]);
    add(t[0], t[1], t[3]);
    add(t[0], t[2], t[1]);
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.corners < b.corners; });
}

void append_boundary(const std::vector<Face>& faces, const std::string& source,
                     std::vector<std::array<std::uint32_t, 3>>& triangles) {
  for (std::size_t k = 0; k < faces.size();) {
    std::size_t end = k + 1;
    while (end < faces.size() && faces[end].corners == faces[k].corners) ++end;
    const auto [a, b, c] = faces[k].corners;
    if (end - k > 2 || (end - k == 2 && faces[k].outward == faces[k + 1].outward))
      fail(source, "mesh: tetrahedra overlap at the triangle of vertices " + std::to_string(a) + ", " +
                       std::to_string(b) + ", " + std::to_string(c) +
                       " (counted from 0); a triangle must have one tetrahedron on each side at most");
    if (end - k == 1) triangles.push_back(faces[k].outward ? std::array{a, b, c} : std::array{a, c, b});
    k = end;
  }
}

template <class CornersOf>
std::vector<std::array<std::uint32_t, 3>> boundary_of(std::size_t tetrahedra, const CornersOf& corners,
                                                      std::uint32_t vertices, const std::string& source) {
  constexpr std::uint32_t bands = 8;
  std::vector<Face> faces;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t band = 0; band < bands; ++band) {
    const auto begin = [&](std::uint32_t k) {
      return static_cast<std::uint32_t>(std::uint64_t{vertices} * k / bands);
    };
    collect_faces(tetrahedra, corners, {begin(band), begin(band + 1)}, faces);
    append_boundary(faces, source, triangles);
  }
  return triangles;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> boundary_triangles(const mesh::TetMesh& mesh,
                                                             const std::string& source) {
  return boundary_of(
      mesh.tetrahedra.size(), [&](std::size_t k) { return mesh.tetrahedra[k]; },
      static_cast<std::uint32_t>(mesh.vertices.size()), source);
}

std::vector<std::array<std::uint32_t, 3>> boundary_triangles(const model::Model& model,
                                                             const std::string& source) {
  const std::vector<std::uint32_t>& corners = model.tetrahedron;
  return boundary_of(
      corners.size() / 4,
      [&](std::size_t k) {
        return Corners{corners[4 * k], corners[4 * k + 1], corners[4 * k + 2], corners[4 * k + 3]};
      },
      model.vertex_count, source);
}

RenderMesh boundary_render_mesh(const mesh::TetMesh& mesh, const std::string& source) {
  RenderMesh render;
  render.triangles = boundary_triangles(mesh, source);
  constexpr std::uint32_t inside = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> number(mesh.vertices.size(), inside);
  for (const auto& t : render.triangles)
    for (const std::uint32_t corner : t) number[corner] = 0;
  for (std::uint32_t i = 0; i < number.size(); ++i)
    if (number[i] != inside) {
      number[i] = static_cast<std::uint32_t>(render.corners.size());
      ride_on_vertex(render, i);
    }
  for (auto& t : render.triangles)
    for (std::uint32_t& corner : t) corner = number[corner];
  return render;
}

}  // namespace fascicle::build
