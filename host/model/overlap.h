// How much of a body lies inside itself: what stage contact is there to prevent, measured in double
// precision.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

struct Overlap {
  std::uint32_t vertices = 0;  // of the surface, in flesh that is far from them at rest
  double deepest = 0.0;        // m: of these, below the surface of that flesh at rest
  double volume = 0.0;         // m^3: half the sum of their areas times their depths, as two sides overlap
};

// A point of the surface that lies in flesh which it may meet.
struct PointOverlap {
  std::uint32_t point;        // of Model::contact
  std::uint32_t tetrahedron;  // of Model::contact_tetrahedron: the first that holds it
  double depth;               // m, as above
};

class OverlapMeter {
 public:
  // The model has contact arrays and must outlive the meter.
  explicit OverlapMeter(const Model& model);

  // Of a body whose vertices are at these places, 3 numbers each, in working units. Flesh that follows the
  // skeleton on both sides is left out.
  Overlap of(std::span<const float> positions) const;
  // Of such a body, by ascending point.
  std::vector<PointOverlap> points(std::span<const float> positions) const;

 private:
  // How deep, in working units, point p lies in tetrahedron t, whose box holds it; below 0: not in it, or it
  // may not meet it.
  double depth_in(std::uint32_t p, std::uint32_t t, std::span<const float> positions) const;

  const Model& model_;
  std::vector<double> area_;  // of each point, square working units
  float box_size_;            // of a tetrahedron, in the mean
};

}  // namespace fascicle::model
