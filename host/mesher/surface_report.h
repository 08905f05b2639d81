// Everything that is wrong with a surface, by vertex number, for a person to mend or a program to choose by.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/mesher/files.h"

namespace fascicle::mesher {

// A finding: how often it occurs, and the vertices of the first places.
struct Finding {
  std::size_t count = 0;
  std::vector<int> vertices;
};

struct SurfaceReport {
  Finding parts;                  // connected by shared vertices; one vertex of each
  Finding loose_vertices;         // in no triangle
  Finding flat_triangles;         // without area
  Finding open_edges;             // of one triangle; vertices by twos
  Finding non_manifold_edges;     // of three or more; by twos
  Finding non_manifold_vertices;  // where parts of the surface meet in a point
  Finding turned_edges;           // whose two triangles face opposite ways; by twos
  Finding inverted_parts;         // closed ones that face inward; one vertex of each
  Finding intersections;          // pairs of triangles; one vertex of each triangle, by twos
  long long genus = 0;            // handles, summed over the closed manifold parts
};

SurfaceReport report_surface(const Surface& surface);

// One line a finding: its name, its count, its vertices. `genus` has its number only. Ends in "end".
std::string text_of(const SurfaceReport& report);

// Calls for the pairs of triangles that cross or touch where they share no corner, or lie on each other; at
// most `most` of them are returned, `count` is all. Exact.
std::vector<std::array<int, 2>> intersecting_triangles(const Surface& surface, std::size_t most,
                                                       std::size_t& count);

}  // namespace fascicle::mesher
