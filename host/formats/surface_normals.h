// Normals of the render mesh in a frame.
//
// A file's own normals are rotated, which keeps creases: each vertex's normal follows the rotation of the
// surface around it since rest. Without normals in the file, they are smooth, also across seams where the
// file splits a vertex for its texture coordinates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::formats {

// The surface around a vertex is made of the triangles at its position (render vertices that coincide at
// rest); if normals differ there, only of those on its side of the crease.
class SurfaceNormals {
 public:
  // `own`: the file's unit normals at rest, 3 values per vertex; (0, 0, 0) where it has none. Empty: none.
  explicit SurfaceNormals(const model::Model& model, std::vector<float> own = {});
  // Unit normals, 3 values per vertex, for positions (3 values per vertex, any unit).
  std::vector<float> of(std::span<const float> positions) const;
  // Ignores the file's normals: the sum of the cross products of the triangles around a vertex, which is
  // area-weighted. (0, 1, 0) if that sum is zero.
  std::vector<float> smooth_of(std::span<const float> positions) const;

 private:
  std::vector<float> own_, rest_;        // 3 values per vertex; both empty if the file has no normals
  std::vector<double> rest_normals_;     // per group; likewise empty
  std::vector<std::uint32_t> group_;     // per render vertex: its group
  std::vector<std::uint32_t> triangle_;  // the model's triangles, by render vertex
  std::uint32_t groups_ = 0;

  std::vector<double> normals_of_groups(std::span<const float> positions) const;
};

}  // namespace fascicle::formats
