// Runs TetGen 1.5 as a library, in a process that may die from it.
//
// When TetGen gives up, it frees its mesh and throws an int; the mesh's destructor then frees it again, so
// catching that int corrupts the heap. Neither this code nor its callers may catch it. An uncaught exception
// leaves the stack alone and calls the terminate handler, and the one set by install_terminate_handler()
// turns the int into an exit status. Callers must not call these functions under a catch (...) or from a
// noexcept function.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host/mesher/files.h"

namespace fascicle::mesher {

// The handler removes the file `part` (none if empty), because the stack is not unwound.
void install_terminate_handler(const std::string& part);

// Fills a surface that passed check_closed(). Vertices of the result: the surface's, then `inside`, then
// those added by TetGen. `max_volume` 0: no limit. `quality`: the largest ratio of circumradius to shortest
// edge. The surface is preserved, so tetrahedra at it may miss both bounds.
Volume fill(const Surface& surface, const std::vector<Point>& inside, double max_volume, double quality);

// Where the surface intersects itself, in words; nothing if it does not. TetGen's list of intersections goes
// into `listed`, an empty file open for reading and writing.
std::optional<std::string> find_intersection(const Surface& surface, std::FILE* listed);

}  // namespace fascicle::mesher
