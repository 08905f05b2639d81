// Triangles as the camera sees them, in bands of pixel rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/render/camera.h"
#include "host/render/scan.h"
#include "host/render/shape.h"

namespace fascicle::render {

using Eigen::Matrix3f;

inline constexpr unsigned band_rows = 8;

struct FacetCorner {
  GridPoint place;
  float nearness = 0.0f;  // 1 / distance
};

// A triangle, or a piece of one that reaches behind the camera or too far aside.
struct Facet {
  std::array<FacetCorner, 3> corners;
  std::uint32_t shape = 0, triangle = 0;  // index of the shape, index of the triangle in it
  std::uint32_t piece = 0;                // index in `pieces`; 0: all of the triangle
};

struct Facets {
  std::span<const Shape> shapes;
  std::vector<Facet> facets;          // in the order of shapes and triangles
  std::vector<std::uint32_t> number;  // index of each facet's triangle among those of all shapes
  // The corners of each piece, in columns, as weights of its triangle's corners.
  std::vector<Matrix3f> pieces;
  std::vector<std::vector<std::uint32_t>> of_band;
};

// Leaves out triangles that are not finite.
Facets project(std::span<const Shape> shapes, const Camera& camera);

inline std::array<GridPoint, 3> places_of(const Facet& facet) {
  return {facet.corners[0].place, facet.corners[1].place, facet.corners[2].place};
}

// Barycentric coordinates in the triangle in space, not in the picture.
Vector3f weights_at(const Facets& facets, const Facet& facet, const Edges& edges, const GridPoint& at);

// Of the triangle's area.
float share_of(const Facets& facets, const Facet& facet);

// Whether a facet's side opposite its corner k lies on a side of the triangle.
bool is_edge_of_triangle(const Facets& facets, const Facet& facet, std::size_t k);

}  // namespace fascicle::render
