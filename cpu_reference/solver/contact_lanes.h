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
// they are: no rounding of it or of contact_motions is missing. Infinite where a place is no number.
// Four floats each.
struct ContactBounds {
  float low[4], high[4];
  float least[4], most[4];
};

// Points against tetrahedra of a leaf.
struct ContactLook {
  const float* points;            // x of all, then y, then z; what is past the last is infinite
  const float* places;            // of the vertices, four floats each
  const std::uint32_t* corners;   // of the leaf's tetrahedra
  const std::uint16_t* relevant;  // of each tetrahedron the points that it may hold; null: `all`
  std::uint16_t all;
  std::uint32_t tetrahedra;  // those that are looked at
  // What is found of them: how far the nearest of the points is from the tetrahedron's box, along the axis
  // along which it is farthest (at most 0: in the box; infinite: there is none), and what points may be in
  // the tetrahedron.
  float* apart;
  std::uint16_t* inside;
};

struct ContactLanes {
  void (*bound)(const ContactVertices&, ContactBounds&);
  // Which of the boxes that are taken together overlap another one.
  std::uint32_t (*overlap)(const float* boxes, const ContactBounds& with);
  // By how much things in each of the boxes of motion may have come nearer to what is in another one, along
  // any axis.
  void (*approach)(const float* motions, const ContactBounds& to, float* by);
  void (*look)(const ContactLook&);
};

}  // namespace fascicle::cpu_reference
