#include "host/scene/bare_scenes.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// Whole, so that a bake goes on with --resume however its file is spelled.
std::string in_quotes(const std::filesystem::path& path) {
  std::ostringstream out;
  out << toml::toml_formatter{
      toml::value<std::string>(std::filesystem::absolute(path).lexically_normal().string())};
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

struct Firmness {
  double youngs_modulus;  // Pa
  double damping;         // 1/s
};

// So many times the pressure under a column as high as the body. Every body then sinks by the same share of
// its size under its own weight, whatever its size; measured on the bunny, whose top sinks by 4 % of its
// height, whose ears stand, and whose swing is seen and gone after half a second.
Firmness firm_enough_to_stand(const Geometry& geometry) {
  constexpr double pressures = 60.0, swings = 1.6, gravity = 9.81;
  double extent = 0.0;
  if (const auto* tets = std::get_if<TetMesh>(&geometry)) extent = largest_extent(tets->vertices);
  if (const auto* surface = std::get_if<SurfaceMesh>(&geometry)) extent = largest_extent(surface->vertices);
  if (!(extent > 0.0)) extent = 1.0;
  return {pressures * Layer{}.density * gravity * extent, swings * std::sqrt(gravity / extent)};
}

std::string rounded(double value) {
  std::ostringstream out;
  out << std::setprecision(3) << std::showpoint << value;
  return out.str();
}

bool is_painted(const Character& character, const std::string& name) {
  return std::any_of(
      character.painted.begin(), character.painted.end(),
      [&](const PaintedAttribute& attribute) { return attribute.name == name && attribute.width == 1; });
}

}  // namespace

std::string scene_for_mesh(const std::filesystem::path& path, const Geometry& mesh) {
  const Firmness firmness = firm_enough_to_stand(mesh);
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
         "youngs_modulus = " +
         rounded(firmness.youngs_modulus) +
         "\n"
         "damping = " +
         rounded(firmness.damping) +
         "\n"
         "beta = 0.0\n"
         "\n"
         "[solver]\n"
         "substeps = \"auto\"\n"
         "\n"
         "[pin.base]\n"
         "where = { below = { axis = \"y\", fraction = 0.05 } }\n"
         "\n"
         "[probe.top]\n"
         "where = { above = { axis = \"y\", fraction = 0.95 } }\n";
}

std::string layers_for_character(const Character& character, Stiffness by) {
  // The outer third of the way from the bone to the skin is fat, the inner third bone: it must hold the
  // flesh.
  const bool has_layers = is_painted(character, "_LAYER");
  const bool by_alpha = by == Stiffness::alpha;
  const std::string painted =
      by_alpha && is_painted(character, "_STIFFNESS") ? "alpha_attribute = \"_STIFFNESS\"\n" : "";
  const auto stiffness = [&](const char* alpha, const char* material) {
    return by_alpha ? "alpha = " + std::string(alpha) + "\n" + painted + "damping = 12.0\nvolume = 1.0\n"
                    : "material = \"" + std::string(material) + "\"\ndamping = 6.0\n";
  };
  // 1 is bone, 2 muscle, 3 fat; 0, which is what vertices have before they are painted, leaves it to the
  // depth.
  constexpr int bone = 0, muscle = 1, rest = 2;
  const auto where = [&](const std::string& shape, int number) {
    const std::string by_paint = "{ painted = { attribute = \"_LAYER\", minimum = " + std::to_string(number) +
                                 ".5, maximum = " + std::to_string(number + 1) + ".5 } }";
    if (has_layers) return "where = [" + shape + ", " + by_paint + "]\n";
    return number == rest ? std::string() : "where = " + shape + "\n";
  };
  return "[layers.fat]\n" + stiffness("0.3", "fat") + "beta = 0.0\n" + where("{ everywhere = true }", rest) +
         "\n"
         "[layers.muscle]\n" +
         stiffness("1.0", "relaxed-muscle") +
         "beta = 1.0\n"
         "fibre_field = true\n" +
         where("{ depth = { maximum = 0.65 } }", muscle) +
         "\n"
         "[layers.bone]\n"
         "kinematic = true\n" +
         where("{ depth = { maximum = 0.3 } }", bone) +
         "\n"
         "[solver]\n" +
         (by_alpha ? "" : "integrator = \"implicit\"\n") + "substeps = \"auto\"\n";
}

std::string scene_for_character(const std::filesystem::path& path, const Character& character,
                                Stiffness stiffness) {
  return "[scene]\n"
         "fps = 60\n"
         "\n"
         "[character]\n"
         "file = " +
         in_quotes(path) + "\n\n" + layers_for_character(character, stiffness);
}

}  // namespace fascicle::scene
