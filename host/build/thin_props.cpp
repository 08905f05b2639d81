#include "host/build/thin_props.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "host/base/text.h"
#include "host/build/boundary.h"
#include "host/build/message.h"

namespace fascicle::build {

namespace {

// A prop is thin from this share of volume without a way out. Cubes, rods and plates have 0.15 or less if the
// cage's edges are half their thickness, and 0.9 or more if they are as long as the thickness.
constexpr double thin_share = 0.5;

// Rounded down to two digits.
float rounded_down(double length) {
  const double step = std::pow(10.0, std::floor(std::log10(length)) - 1.0);
  return static_cast<float>(step * std::floor(length / step));
}

double volume_of(const mesh::TetMesh& mesh, const std::array<std::uint32_t, 4>& t) {
  const Vector3d& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).dot(mesh.vertices[t[3]] - a) / 6.0;
}

}  // namespace

void warn_of_thin_prop(const Body& body, const std::string& source, Report& found) {
  const mesh::TetMesh& mesh = body.mesh;
  std::vector<char> is_outside(mesh.vertices.size(), 0);
  double area = 0.0;
  for (const auto& t : boundary_triangles(mesh, source)) {
    for (const std::uint32_t i : t) is_outside[i] = 1;
    area +=
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm() /
        2.0;
  }
  double volume = 0.0, thin = 0.0;
  for (const auto& t : mesh.tetrahedra) {
    const double own = volume_of(mesh, t);
    volume += own;
    if (std::all_of(t.begin(), t.end(), [&](std::uint32_t i) { return is_outside[i] != 0; })) thin += own;
  }
  if (!(thin > thin_share * volume)) return;
  // Half the thickness of a plate, a quarter of a rod's.
  warn(found,
       std::to_string(std::lround(100.0 * thin / volume)) +
           " % of this prop's volume has no vertex inside: flesh that enters there is not pushed out and may "
           "pass through; give it a `resolution` of " +
           base::number_text(rounded_down(volume / area)) + " m or less, or use a [collider.NAME]");
}

}  // namespace fascicle::build
