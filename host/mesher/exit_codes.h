// The exit statuses of fascicle-mesher; --help lists them. One line on stderr gives the reason in words.
#pragma once

namespace fascicle::mesher {

enum ExitCode : int {
  done = 0,
  bad_usage = 2,
  unreadable = 3,  // a file is missing or malformed
  not_closed = 4,  // the surface does not bound a volume: open, non-manifold, duplicate or loose vertices
  self_intersecting = 5,
  out_of_memory = 6,
  tetgen_failed = 7,
  empty_result = 8,
  cannot_write = 9,
  wrap_failed = 10,  // CGAL found no closed surface without self-intersections
};

}  // namespace fascicle::mesher
