// How much of a body lies inside itself, beyond what its rest shape does: what stage contact is there to
// prevent, measured in double precision.
//
// A rest shape may lie in itself: fingers and thighs that touch, or parts that are modelled into each other.
// A point that does counts only where it lies deeper, by how much deeper.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

struct Overlap {
  std::uint32_t vertices = 0;  // of the surface, in flesh that they may meet, deeper than at rest
  double deepest = 0.0;        // m: of these, below the surface of that flesh, less the point's depth at rest
  double volume = 0.0;         // m^3: half the sum of their areas times their depths, as two sides overlap
};

// A point of the surface that lies in flesh which it may meet.
struct PointOverlap {
  std::uint32_t point;        // of Model::contact
  std::uint32_t tetrahedron;  // of Model::contact_tetrahedron: the first that holds it
  double depth;               // m, as above
};

// What the search for such points knows of a model beforehand.
struct OverlapTables {
  // Tetrahedra by ascending number, and the vertices of each leaf of them.
  struct Part {
    std::vector<std::uint32_t> tetrahedron, leaf_offset, leaf_vertex;
  };
  explicit OverlapTables(const Model& model);
  std::vector<std::uint32_t> order;  // the points: first those that can move by themselves
  std::uint32_t free_points = 0;     // how many these are
  Part free, held;                   // tetrahedra of which a corner can move by itself, and the others
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
  const Model& model_;
  OverlapTables tables_;
  std::vector<double> area_;     // of each point, square working units
  std::vector<double> at_rest_;  // of each point, working units: its depth at rest; below 0 in no other flesh
};

}  // namespace fascicle::model
