// Everything that is wrong with a surface, by vertex number, for a person to fix or a program to choose by.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/mesher/files.h"

namespace fascicle::mesher {

// A finding: how often it occurs, and the vertices of its first occurrences.
struct Finding {
  std::size_t count = 0;
  std::vector<int> vertices;
};

struct SurfaceReport {
  Finding parts;                  // connected by shared vertices; one vertex of each
  Finding loose_vertices;         // in no triangle
  Finding flat_triangles;         // without area
  Finding open_edges;             // edges of one triangle; vertices in pairs
  Finding non_manifold_edges;     // edges of three or more triangles; in pairs
  Finding non_manifold_vertices;  // where parts of the surface meet at a point
  Finding turned_edges;           // whose two triangles face opposite ways; in pairs
  Finding inverted_parts;         // closed ones that face inward; one vertex of each
  Finding intersections;          // pairs of triangles; one vertex of each triangle, in pairs
  long long genus = 0;            // handles, summed over the closed manifold parts
};

SurfaceReport report_surface(const Surface& surface);

// One line per finding: its name, count and vertices. `genus` has only its number. Ends with "end".
std::string text_of(const SurfaceReport& report);

// Finds the pairs of triangles that cross, touch away from a shared corner, or overlap. Returns at most
// `most` of them; `count` is their total. Exact.
std::vector<std::array<int, 2>> intersecting_triangles(const Surface& surface, std::size_t most,
                                                       std::size_t& count);

}  // namespace fascicle::mesher
