// What the search for contacts (contact_search.h) does many at a time: written once (lane_contact.inc) and
// compiled for each instruction set.
#pragma once

#include <cstdint>

namespace fascicle::cpu_reference {

// Points that are taken together, and boxes: leaves of a branch, tetrahedra of a leaf.
inline constexpr std::uint32_t contact_points_together = 16;
inline constexpr std::uint32_t contact_boxes_together = 32;
// Floats of boxes that are taken together: of all the least x, then the least y, ..., the most z.
inline constexpr std::uint32_t contact_boxes_stride = 6 * contact_boxes_together;

// Some vertices, where they are and where they were; places are four floats.
struct ContactVertices {
  const float *now, *before;
  const std::uint32_t* vertex;
  std::uint32_t count;
};

// The box around the vertices, and the one around the ways that they have come, which is a little larger than
// they are: no rounding of it or of what `approach` takes from it is missing. The latter is infinite where a
// place is no number. Four floats each.
struct ContactBounds {
  float low[4], high[4];
  float least[4], most[4];
};

// Leaves of a branch, against points.
struct ContactApproach {
  const float *boxes, *motions;  // of the leaves, as boxes are taken together
  const ContactBounds* points;
  const float* nearest;  // how near any tetrahedron of a leaf was to the points when they were looked at last
  float* gone;           // by how much they may have come nearer since then, along any axis: is added to
};

// Points against tetrahedra of a leaf.
struct ContactLook {
  const float* points;            // x of all, then y, then z; what is past the last is infinite
  const float* places;            // of the vertices, four floats each
  const std::uint32_t* corners;   // of the leaf's tetrahedra
  const std::uint16_t* relevant;  // of each tetrahedron the points that it may hold; null: `all`
  std::uint16_t all;
  std::uint32_t tetrahedra;  // those that there are
  float gone;
  // Of each tetrahedron how far the points were, at least, from its box, along the axis along which they were
  // farthest: 0 in the box, contact_farthest where it may hold none. `gone` is taken off, and where nothing
  // is left, or less than is lost until the next look, the tetrahedron is looked at. Floats cut off after 16
  // bits, which makes them less.
  std::uint16_t* apart;
  // What is found: the least of these; tetrahedra that points may be in now, and what points.
  float nearest;
  std::uint32_t hits;
  std::uint16_t inside[contact_boxes_together];
};

// Farther than that is no farther: motions that lead there are no numbers, or are taken off at once.
inline constexpr float contact_farthest = 0x1p100f;

struct ContactLanes {
  void (*bound)(const ContactVertices&, ContactBounds&);
  // Which of the boxes that are taken together overlap the points'.
  std::uint32_t (*overlap)(const float* boxes, const ContactBounds& points);
  // Which of the leaves have to be looked at: their boxes overlap, and they may have come near.
  std::uint32_t (*approach)(const ContactApproach&);
  void (*look)(ContactLook&);
};

}  // namespace fascicle::cpu_reference
