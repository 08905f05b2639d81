#include "host/scene/bare_scenes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>

#include "host/base/text.h"
#include "host/rig/floors.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// Absolute, so that --resume works whichever way the path is spelled.
std::string in_quotes(const std::filesystem::path& path) {
  const std::string whole = std::filesystem::absolute(path).lexically_normal().string();
  for (std::string_view rest = whole; !rest.empty();)
    if (!base::take_code_point(rest))
      throw SceneError(path.string() +
                       ": the name of the file or of a folder above it is not valid UTF-8; rename it");
  std::ostringstream out;
  out << toml::toml_formatter{toml::value<std::string>(whole)};
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

// The vertices of the triangles. Files also have vertices that belong to none, which may lie anywhere.
std::vector<Vector3d> corners_of(const mesh::SurfaceMesh& surface) {
  std::vector<char> is_used(surface.vertices.size(), surface.triangles.empty() ? 1 : 0);
  for (const auto& triangle : surface.triangles)
    for (const std::uint32_t corner : triangle)
      if (corner < is_used.size()) is_used[corner] = 1;
  std::vector<Vector3d> corners;
  for (std::size_t i = 0; i < is_used.size(); ++i)
    if (is_used[i] != 0) corners.push_back(surface.vertices[i]);
  return corners;
}

// The corners of a character without floors and walls.
std::vector<Vector3d> corners_of_body(const rig::Character& character) {
  const std::vector<char> is_on_floor = rig::on_floors(character);
  mesh::SurfaceMesh body = character.surface;
  const auto is_floor = [&](const auto& triangle) {
    return triangle[0] < is_on_floor.size() && is_on_floor[triangle[0]] != 0;
  };
  std::erase_if(body.triangles, is_floor);
  return corners_of(body);
}

// Longest side in metres; 1 if empty.
double size_of(const std::vector<Vector3d>& points) {
  const double extent = largest_extent(points);
  return extent > 0.0 ? extent : 1.0;
}

// Multiples of the pressure under a column as high as the body, and of the rate of a pendulum of that length,
// so that bodies of any size sag by the same fraction of their size under their own weight. Tuned on the
// bunny: its top sinks by 4 % of its height, its ears stand, and its swing is visible and dies out after half
// a second.
constexpr double pressures_of_mesh = 60.0, paces_of_mesh = 1.6, gravity = 9.81;

// For a character, whose flesh hangs on bones everywhere. Clips take the same time whatever the size, so
// accelerations grow with the size. A wave crosses the character's muscle in this many seconds; at that
// stiffness, flesh inverts no more tetrahedra than skinning does (docs/design, crushed-flesh.md). Fat has 0.3
// times the stiffness of muscle, as in the paper.
constexpr double seconds_across = 0.12, fat_of_muscle = 0.3;

// m. A scene file can state the layers of bodies within these sizes (scene_keys_layer.cpp), with some margin.
constexpr double shortest_body = 1e-6, longest_mesh = 1e6, longest_character = 3e3;

void check_size(const std::string& what, double size, double longest, const std::string& advice) {
  if (size < shortest_body || size > longest)
    throw SceneError(what + " is " + shortest(size) + " m long; stiffness can be chosen for " +
                     shortest(shortest_body) + " to " + shortest(longest) + " m; " + advice);
}

std::string rounded(double value) {
  // Whatever the locale of the program that calls this library. The digits alone may be no TOML, as in
  // "1e+03".
  std::array<char, 32> digits{};
  const auto [end, ignored] =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::general, 3);
  double number = value;
  std::from_chars(digits.data(), end, number);
  const std::string text = shortest(number);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

bool is_painted(const rig::Character& character, const std::string& name) {
  return std::any_of(
      character.painted.begin(), character.painted.end(),
      [&](const rig::PaintedAttribute& attribute) { return attribute.name == name && attribute.width == 1; });
}

}  // namespace

std::string scene_for_mesh(const std::filesystem::path& path, const Geometry& mesh, double scale) {
  std::vector<Vector3d> none;
  const auto* tets = std::get_if<mesh::TetMesh>(&mesh);
  const auto* surface = std::get_if<mesh::SurfaceMesh>(&mesh);
  const double size = scale * size_of(tets ? tets->vertices : surface ? corners_of(*surface) : none);
  check_size(path.string() + ": the mesh", size, longest_mesh,
             "give its unit in metres, as in --set mesh.scale=0.001");
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
         rounded(pressures_of_mesh * Layer{}.density * gravity * size) +
         "\n"
         "damping = " +
         rounded(paces_of_mesh * std::sqrt(gravity / size)) +
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

Stiffness stiffness_for(const std::optional<std::string>& integrator,
                        const std::optional<std::string>& weights) {
  if (integrator)
    return *integrator == name_of(Integrator::explicit_step) ? Stiffness::alpha : Stiffness::modulus;
  return weights == name_of(WeightForm::kaneda2017) ? Stiffness::alpha : Stiffness::modulus;
}

rig::Character what_layers_go_by(const std::vector<rig::Character>& characters) {
  rig::Character all;
  double largest = -1.0;
  for (const rig::Character& one : characters) {
    for (const rig::PaintedAttribute& painted : one.painted)
      all.painted.push_back({painted.name, painted.width, {}});
    std::vector<Vector3d> corners = corners_of_body(one);
    const double extent = largest_extent(corners);
    if (!(extent > largest)) continue;
    largest = extent;
    all.surface.vertices = std::move(corners);
  }
  return all;
}

std::string layers_for_character(const rig::Character& character, Stiffness by, const std::string& source) {
  // The outer third of the way from bone to skin is fat. The inner third is bone, which must hold the flesh.
  const bool has_layers = is_painted(character, "_LAYER");
  const bool by_alpha = by == Stiffness::alpha;
  const double size = size_of(corners_of_body(character));
  check_size(source + ": the character", size, longest_character,
             "scale it to metres in the program that made it");
  const double speed = size / seconds_across;
  const std::string painted = is_painted(character, "_STIFFNESS") ? "alpha_attribute = \"_STIFFNESS\"\n" : "";
  const auto stiffness = [&](const char* alpha, double of_muscle) {
    return (by_alpha ? "alpha = " + std::string(alpha) + "\nvolume = 1.0\n"
                     : "youngs_modulus = " + rounded(of_muscle * Layer{}.density * speed * speed) + "\n") +
           painted + "damping = 12.0\n";
  };
  // _LAYER: 1 is bone, 2 muscle, 3 fat. 0, the value of unpainted vertices, leaves the choice to the depth.
  constexpr int bone = 0, muscle = 1, rest = 2;
  const auto where = [&](const std::string& shape, int number) {
    const std::string by_paint = "{ painted = { attribute = \"_LAYER\", minimum = " + std::to_string(number) +
                                 ".5, maximum = " + std::to_string(number + 1) + ".5 } }";
    if (has_layers) return "where = [" + shape + ", " + by_paint + "]\n";
    return number == rest ? std::string() : "where = " + shape + "\n";
  };
  return "[layers.fat]\n" + stiffness("0.3", fat_of_muscle) + "beta = 0.0\n" +
         where("{ everywhere = true }", rest) +
         "\n"
         "[layers.muscle]\n" +
         stiffness("1.0", 1.0) +
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

std::string scene_for_character(const std::filesystem::path& path, const rig::Character& character,
                                Stiffness stiffness) {
  return "[scene]\n"
         "fps = 60\n"
         "\n"
         "[character]\n"
         "file = " +
         in_quotes(path) + "\n\n" + layers_for_character(character, stiffness, path.string()) +
         // Explicit flesh trembles when pressed into a fold (docs/design, contact.md).
         (stiffness == Stiffness::modulus ? "\n[contact]\nself = true\nunless_torn = true\n" : "");
}

}  // namespace fascicle::scene
