// How much a body intersects itself beyond its rest shape, in double precision: what stage contact has to
// prevent.
//
// A rest shape may intersect itself: fingers and thighs that touch, or parts modelled into each other. A
// point that does so counts only if it lies deeper than at rest, and only by the difference.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

struct Overlap {
  std::uint32_t vertices = 0;  // of the surface, deeper than at rest in flesh that they may meet
  double deepest = 0.0;        // m: the largest depth of these, minus the depth at rest
  double volume = 0.0;         // m^3: half the sum of areas times depths, as both sides count
};

// A surface point that lies in flesh it may meet.
struct PointOverlap {
  std::uint32_t point;        // of Model::contact
  std::uint32_t tetrahedron;  // of Model::contact_tetrahedron: the first that holds it
  double depth;               // m, minus the depth at rest
};

// What the search precomputes from a model.
struct OverlapTables {
  // Tetrahedra by ascending number, and the vertices of each leaf of them.
  struct Part {
    std::vector<std::uint32_t> tetrahedron, leaf_offset, leaf_vertex;
  };
  explicit OverlapTables(const Model& model);
  std::vector<std::uint32_t> order;  // the points; those that can move freely come first
  std::uint32_t free_points = 0;     // how many can move freely
  Part free, held;                   // tetrahedra with a corner that can move freely, and the others
};

class OverlapMeter {
 public:
  // The model has contact arrays and must outlive the meter.
  explicit OverlapMeter(const Model& model);

  // For a body with vertices at these positions, 3 numbers each, in working units. Pairs that follow the
  // skeleton on both sides are left out.
  Overlap of(std::span<const float> positions) const;
  // The points of such a body that overlap, ascending.
  std::vector<PointOverlap> points(std::span<const float> positions) const;

 private:
  const Model& model_;
  OverlapTables tables_;
  std::vector<double> area_;     // one per point, square working units
  std::vector<double> at_rest_;  // each point's depth at rest, working units; negative: in no other flesh
};

}  // namespace fascicle::model
