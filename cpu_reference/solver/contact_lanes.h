// The parts of the contact search (contact_search.h) that process many items at a time: written once
// (lane_contact.inc) and compiled for each instruction set.
#pragma once

#include <cstdint>

namespace fascicle::cpu_reference {

// Numbers of points, and of boxes (leaves of a branch, tetrahedra of a leaf), processed together.
inline constexpr std::uint32_t contact_points_together = 16;
inline constexpr std::uint32_t contact_boxes_together = 32;
// Floats of boxes processed together: the least x of all, then the least y, ..., the greatest z.
inline constexpr std::uint32_t contact_boxes_stride = 6 * contact_boxes_together;

// Some vertices with their current and previous positions, four floats each.
struct ContactVertices {
  const float *now, *before;
  const std::uint32_t* vertex;
  std::uint32_t count;
};

// The box around the vertices, and the box around their displacements, slightly enlarged to cover all
// rounding in it and in what `approach` computes from it. The latter is infinite if a position is NaN. Four
// floats each.
struct ContactBounds {
  float low[4], high[4];
  float least[4], most[4];
};

// The leaves of a branch, against points.
struct ContactApproach {
  const float *boxes, *motions;  // of the leaves, in the layout of boxes processed together
  const ContactBounds* points;
  const float* nearest;  // how near any tetrahedron of a leaf was to the points at the last look
  float* gone;           // updated: how much nearer they may have come since then, along any axis
};

// Points against the tetrahedra of a leaf.
struct ContactLook {
  const float* points;            // x of all, then y, then z; infinite past the last
  const float* places;            // of the vertices, four floats each
  const std::uint32_t* corners;   // of the leaf's tetrahedra
  const std::uint16_t* relevant;  // for each tetrahedron the points that it may hold; null: `all`
  std::uint16_t all;
  std::uint32_t tetrahedra;  // those that exist
  float gone;
  // For each tetrahedron a lower bound on the distance of the points from its box, along the axis of largest
  // distance: 0 in the box, contact_farthest if it may hold none. `gone` is subtracted; if what is left does
  // not exceed `gone`, the tetrahedron is tested again. Floats truncated to 16 bits, which rounds them down.
  std::uint16_t* apart;
  // Results: the least of these; tetrahedra that may contain points now, and which points.
  float nearest;
  std::uint32_t hits;
  std::uint16_t inside[contact_boxes_together];
};

// Distances are capped here: motions this large are not finite, or cause a test at once.
inline constexpr float contact_farthest = 0x1p100f;

struct ContactLanes {
  void (*bound)(const ContactVertices&, ContactBounds&);
  // Which of the boxes processed together overlap the points' box.
  std::uint32_t (*overlap)(const float* boxes, const ContactBounds& points);
  // Which of the leaves must be looked at: their boxes overlap, and they may have come near.
  std::uint32_t (*approach)(const ContactApproach&);
  void (*look)(ContactLook&);
};

}  // namespace fascicle::cpu_reference
