// The render mesh on the host: for frame 0, which no solver has stepped, and for rest.obj.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/model/model.h"

namespace fascicle::bake {

// Stage embed, with its bits: the same products and sums in the same order, values below 2^-40 made zero.
std::vector<float> embed(const model::Model& model, std::span<const float> positions);

// Positions of a frame in metres in the world, rounded once to float: 3 values a vertex.
std::vector<float> world_positions(std::span<const float> positions, double unit,
                                   const std::array<double, 3>& origin);

// Normals of the render mesh as it stands in a frame: smooth everywhere, also over the seams where a file
// splits a vertex for its texture coordinates. Render vertices of equal place at rest count as one.
class SurfaceNormals {
 public:
  explicit SurfaceNormals(const model::Model& model);
  // Unit normals, 3 values a vertex, of positions (3 values a vertex, any unit): the sum of the cross
  // products of the triangles around a place, which weighs each by its area. (0, 1, 0) where that sum is
  // nothing.
  std::vector<float> of(std::span<const float> positions) const;

 private:
  std::vector<std::uint32_t> place_;     // a render vertex: number of its place
  std::vector<std::uint32_t> triangle_;  // the model's, render vertices
  std::uint32_t places_ = 0;
};

// Least and greatest coordinates of points, x y z x y z. All 0 without points.
std::array<float, 6> bounds(std::span<const float> points);

// Wavefront OBJ of the render mesh at rest (characters: in the bind pose), in its vertex order, metres, Y up.
// A PC2 of the bake can be played on it.
std::string rest_obj(const model::Model& model);

}  // namespace fascicle::bake
