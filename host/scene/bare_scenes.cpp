#include "host/scene/bare_scenes.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

std::string in_quotes(const std::filesystem::path& path) {
  std::ostringstream out;
  out << toml::toml_formatter{toml::value<std::string>(path.string())};
  return out.str();
}

double largest_extent(const std::vector<Vector3d>& points) {
  if (points.empty()) return 0.0;
  Vector3d low = points.front(), high = points.front();
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).maxCoeff();
}

}  // namespace

std::string scene_for_mesh(const std::filesystem::path& path) {
  // The stiffness that alpha means grows with the square of substeps x spacing. With 8, meshes of 3,000 to
  // 30,000 vertices stand under their own weight and still swing.
  return "[scene]\n"
         "fps = 60\n"
         "end = 2.0\n"
         "\n"
         "[mesh]\n"
         "file = " +
         in_quotes(path) +
         "\n"
         "\n"
         "[layers.body]\n"
         "alpha = 1.0\n"
         "beta = 0.0\n"
         "damping = 13.4\n"
         "\n"
         "[solver]\n"
         "substeps = 8\n"
         "\n"
         "[pin.base]\n"
         "where = { below = { axis = \"y\", fraction = 0.05 } }\n"
         "\n"
         "[probe.top]\n"
         "where = { above = { axis = \"y\", fraction = 0.95 } }\n";
}

std::string scene_for_character(const std::filesystem::path& path, const Character& character) {
  // Wrists and ankles of a body are about 0.02 of its height thick from the bone to the skin, its thighs and
  // belly 0.05 and more: so hands and feet follow the skeleton, and the flesh is free. Millimetres are fine
  // enough to read and to edit.
  constexpr double bone_share = 0.02;
  constexpr double muscle_share = 0.045;
  const double size = largest_extent(character.surface.vertices);
  const auto distance = [&](double share) {
    return shortest(std::max(std::round(size * share * 1e3) / 1e3, 1e-3));
  };
  return "[scene]\n"
         "fps = 60\n"
         "\n"
         "[character]\n"
         "file = " +
         in_quotes(path) +
         "\n"
         "\n"
         "[layers.fat]\n"
         "alpha = 0.3\n"
         "beta = 0.0\n"
         "damping = 6.0\n"
         "\n"
         "[layers.muscle]\n"
         "alpha = 1.0\n"
         "beta = 1.0\n"
         "damping = 6.0\n"
         "where = { bone_distance = { maximum = " +
         distance(muscle_share) +
         " } }\n"
         "\n"
         "[layers.bone]\n"
         "kinematic = true\n"
         "where = { bone_distance = { maximum = " +
         distance(bone_share) +
         " } }\n"
         "\n"
         "[solver]\n"
         "substeps = 8\n";
}

}  // namespace fascicle::scene
