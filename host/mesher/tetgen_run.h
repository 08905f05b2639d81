// TetGen 1.5, called as a library in a process that may die of it.
//
// Where TetGen gives up it frees its mesh and throws an int, and the mesh's destructor then frees it again:
// catching that int corrupts the heap. So nothing here or above may catch it. An exception that nobody
// catches leaves the stack as it is and calls the terminate handler, and install_terminate_handler()'s turns
// the int into an exit status. Callers must not put these functions under a catch (...) or a noexcept
// function.
#pragma once

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host/mesher/files.h"

namespace fascicle::mesher {

// The handler removes the file `part` (none, where that is empty): the stack, which would, is left as it is.
void install_terminate_handler(const std::string& part);

// Fills a surface that passed check_closed(). Vertices of the result: the surface's, then `inside`, then
// TetGen's own. `max_volume` 0: no limit. `quality`: the largest ratio of circumradius to shortest edge. The
// surface is kept, so tetrahedra at it may miss both bounds.
Volume fill(const Surface& surface, const std::vector<Point>& inside, double max_volume, double quality);

// Where the surface crosses itself, in words; nothing if it does not. TetGen's list of what crosses goes into
// `listed`, an empty file that can be read and written.
std::optional<std::string> find_intersection(const Surface& surface, std::FILE* listed);

}  // namespace fascicle::mesher
