// Normals of the render mesh as it stands in a frame.
//
// A file's own normals are turned along, so that creases stay: the normal of a vertex is turned as the
// surface around it turned since rest. Where the file has none they are smooth, also over the seams where it
// splits a vertex for its texture coordinates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::formats {

// The surface around a vertex: the triangles at its place (render vertices that are equal at rest), and of
// those only the ones on its side of a crease, where its place has normals of several directions.
class SurfaceNormals {
 public:
  // `own`: the file's normals at rest, 3 values a vertex, of length 1; (0, 0, 0) where it has none. Empty:
  // none.
  explicit SurfaceNormals(const model::Model& model, std::vector<float> own = {});
  // Unit normals, 3 values a vertex, of positions (3 values a vertex, any unit).
  std::vector<float> of(std::span<const float> positions) const;
  // Without the file's: the sum of the cross products of the triangles around a vertex, which weighs each by
  // its area. (0, 1, 0) where that sum is nothing.
  std::vector<float> smooth_of(std::span<const float> positions) const;

 private:
  std::vector<float> own_, rest_;        // 3 values a vertex; both empty without normals of the file
  std::vector<double> rest_normals_;     // of the groups; empty as well
  std::vector<std::uint32_t> group_;     // a render vertex: number of its surroundings
  std::vector<std::uint32_t> triangle_;  // the model's, render vertices
  std::uint32_t groups_ = 0;

  std::vector<double> normals_of_groups(std::span<const float> positions) const;
};

}  // namespace fascicle::formats
