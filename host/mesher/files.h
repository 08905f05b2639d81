// The files that fascicle-mesher reads and writes: strict, and independent of the locale.
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace fascicle::mesher {

// Ends the program with this exit status after printing the text to stderr.
struct Failure : std::runtime_error {
  Failure(int code, const std::string& what) : std::runtime_error(what), exit_code(code) {}
  int exit_code;
};

using Point = std::array<double, 3>;

struct Surface {
  std::vector<Point> vertices;
  std::vector<std::array<int, 3>> triangles;
};

// OFF of triangles without colours or comments, indices in range. Throws Failure (unreadable).
Surface read_surface(const std::string& path);
// A count, then x y z for each point. Throws Failure (unreadable).
std::vector<Point> read_points(const std::string& path);

struct Volume {
  std::vector<Point> vertices;
  std::vector<std::array<int, 4>> tetrahedra;
};

// With full precision.
std::string text_of(const Volume& volume);    // MEDIT .mesh
std::string text_of(const Surface& surface);  // OFF
std::string text_of(double number);

}  // namespace fascicle::mesher
