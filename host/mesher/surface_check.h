// Preconditions of TetGen: on any other surface it aborts or corrupts its heap.
#pragma once

#include "host/mesher/files.h"

namespace fascicle::mesher {

// Checks that every edge has two triangles that traverse it in opposite directions, no two vertices coincide,
// every vertex has a triangle and every triangle has an area. Throws Failure (not_closed) that names the
// first violation, counted from 0.
void check_closed(const Surface& surface);

// Whether three points are not collinear, within double precision.
bool has_area(const Point& a, const Point& b, const Point& c);

}  // namespace fascicle::mesher
