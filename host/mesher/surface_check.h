// What must hold before TetGen may see a surface: on anything else it aborts, or corrupts its heap.
#pragma once

#include "host/mesher/files.h"

namespace fascicle::mesher {

// Every edge has two triangles that pass it in opposite directions, no two vertices lie at one place, every
// vertex has a triangle, every triangle an area. Throws Failure (not_closed) with the first place where that
// fails, counted from 0.
void check_closed(const Surface& surface);

// Whether three points are not in a line, as far as double precision tells.
bool has_area(const Point& a, const Point& b, const Point& c);

}  // namespace fascicle::mesher
