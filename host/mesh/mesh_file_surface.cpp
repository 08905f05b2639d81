// Surfaces: OFF, OBJ, STL. PLY has its own file.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "host/base/errors.h"
#include "host/mesh/mesh_readers.h"
#include "host/mesh/surface_builder.h"
#include "host/mesh/text_scanner.h"

namespace fascicle::mesh {
namespace {

constexpr const char* no_face_is_left = "no face has three different corners; export the mesh again";

// --- STL: triangles without vertex numbers
// -------------------------------------------------------------------

class Welder {
 public:
  std::uint32_t vertex(SurfaceMesh& mesh, Vector3d point) {
    std::array<std::uint64_t, 3> key;
    for (int axis = 0; axis < 3; ++axis) {
      if (point[axis] == 0.0) point[axis] = 0.0;  // -0 and +0 are the same place
      key[static_cast<std::size_t>(axis)] = std::bit_cast<std::uint64_t>(point[axis]);
    }
    const auto [entry, is_new] = known_.try_emplace(key, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(point);
    return entry->second;
  }

  void triangle(SurfaceMesh& mesh, const std::array<Vector3d, 3>& corners) {
    const std::array<std::uint32_t, 3> t = {vertex(mesh, corners[0]), vertex(mesh, corners[1]),
                                            vertex(mesh, corners[2])};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
  }

 private:
  struct Hash {
    std::size_t operator()(const std::array<std::uint64_t, 3>& key) const {
      std::uint64_t hash = 0;
      for (const std::uint64_t part : key) {
        hash = (hash ^ part) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
      }
      return static_cast<std::size_t>(hash);
    }
  };
  std::unordered_map<std::array<std::uint64_t, 3>, std::uint32_t, Hash> known_;
};

constexpr std::size_t stl_header = 84;
constexpr std::size_t stl_triangle = 50;

float little_endian_float(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    word |= std::uint32_t{static_cast<unsigned char>(bytes[at + k])} << (8 * k);
  }
  return std::bit_cast<float>(word);
}

SurfaceMesh read_binary_stl(const std::string& file, std::string_view bytes) {
  SurfaceMesh mesh;
  Welder welder;
  for (std::size_t at = stl_header; at < bytes.size(); at += stl_triangle) {
    std::array<Vector3d, 3> corners;
    for (std::size_t k = 0; k < 9; ++k) {
      const std::size_t place = at + 12 + 4 * k;  // after the normal
      const float value = little_endian_float(bytes, place);
      if (!std::isfinite(value)) {
        throw base::SceneError(file + ": byte " + std::to_string(place) +
                               ": a coordinate is not finite; repair the mesh and export it again");
      }
      corners[k / 3][static_cast<int>(k % 3)] = static_cast<double>(value);
    }
    welder.triangle(mesh, corners);
  }
  return mesh;
}

SurfaceMesh read_ascii_stl(const std::string& file, std::string_view text) {
  TextScanner scanner(file, text, '\0');
  SurfaceMesh mesh;
  Welder welder;
  const auto expect = [&](std::string_view keyword) {
    const std::string_view found = scanner.word(keyword);
    if (found != keyword) {
      scanner.fail("expected " + std::string(keyword) + " and found " + shown(found) + "; export it again");
    }
  };
  while (!scanner.at_end()) {
    expect("solid");
    scanner.skip_line();  // the solid's name
    while (scanner.peek() == "facet") {
      expect("facet");
      expect("normal");
      for (int k = 0; k < 3; ++k) scanner.word("a normal");  // unused; exporters may write nan here
      expect("outer");
      expect("loop");
      std::array<Vector3d, 3> corners;
      for (Vector3d& corner : corners) {
        expect("vertex");
        corner = scanner.point("a coordinate");
      }
      expect("endloop");
      expect("endfacet");
      welder.triangle(mesh, corners);
    }
    expect("endsolid");
    scanner.skip_line();
  }
  return mesh;
}

}  // namespace

SurfaceMesh read_off(const std::string& file, std::string_view text) {
  TextScanner scanner(file, text, '#');
  const std::string_view magic = scanner.word("OFF");
  if (magic != "OFF" && magic != "COFF" && magic != "NOFF" && magic != "CNOFF") {
    scanner.fail("not an OFF file: it begins with " + shown(magic) + "; export it as ASCII OFF");
  }
  if (scanner.peek() == "BINARY") scanner.fail("binary OFF is not supported; export it as ASCII OFF");
  const std::size_t vertex_count = scanner.count("the number of vertices", 6);
  const std::size_t face_count = scanner.count("the number of faces", 8);
  scanner.whole("the number of edges");
  SurfaceMesh mesh;
  mesh.vertices.reserve(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    mesh.vertices.push_back(scanner.point("a coordinate"));
    scanner.skip_line();  // colours and normals
  }
  mesh.triangles.reserve(face_count);
  std::vector<std::uint32_t> polygon;
  for (std::size_t i = 0; i < face_count; ++i) {
    polygon.resize(scanner.count("the number of corners", 2));
    for (std::uint32_t& v : polygon) v = scanner.index(mesh.vertices.size(), 0);
    append_polygon(mesh, polygon, 0, [&](const std::string& what) { scanner.fail(what); });
    scanner.skip_line();  // a colour
  }
  if (!scanner.at_end()) {
    scanner.word("the end");
    scanner.fail("extra data after the last face; correct the counts");
  }
  if (mesh.triangles.empty())
    scanner.fail(mesh.repeated_corners > 0 ? no_face_is_left : "no faces in this file; export a surface");
  return mesh;
}

SurfaceMesh read_obj(const std::string& file, std::string_view text) {
  TextScanner scanner(file, text, '#');
  SurfaceMesh mesh;
  std::vector<std::uint32_t> polygon;
  // A corner is V, V/T, V//N or V/T/N: V from 1, or from -1 backwards over the vertices so far.
  const auto corner = [&] {
    const std::string_view whole_word = scanner.word("a corner");
    std::string_view number = whole_word.substr(0, whole_word.find('/'));
    const bool is_backwards = !number.empty() && number.front() == '-';
    if (is_backwards) number.remove_prefix(1);
    TextScanner digits(file, number, '\0');
    std::uint64_t value = 0;
    try {
      value = digits.whole("a vertex number");
    } catch (const base::SceneError&) {
      scanner.fail("corner " + shown(whole_word) + " does not begin with a vertex number; correct it");
    }
    if (value == 0 || value > mesh.vertices.size()) {
      scanner.fail("corner " + shown(whole_word) + " is beyond the " + std::to_string(mesh.vertices.size()) +
                   " vertices before it; correct it");
    }
    return static_cast<std::uint32_t>(is_backwards ? mesh.vertices.size() - value : value - 1);
  };
  // A backslash at the end of a line joins it with the next.
  const auto line_goes_on = [&] {
    while (!scanner.at_line_end()) {
      if (scanner.peek() != "\\") return true;
      scanner.word("\\");
      if (!scanner.at_line_end()) scanner.fail("a backslash inside a line; remove it");
      scanner.skip_line();
    }
    return false;
  };
  while (!scanner.at_end()) {
    const std::string_view keyword = scanner.word("a keyword");
    if (keyword == "v") {
      mesh.vertices.push_back(scanner.point("a coordinate"));
      while (line_goes_on()) scanner.word("a weight or colour");
    } else if (keyword == "f") {
      polygon.clear();
      while (line_goes_on()) polygon.push_back(corner());
      append_polygon(mesh, polygon, 1, [&](const std::string& what) { scanner.fail(what); });
    } else {
      const char first = keyword.front();
      if (!((first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z'))) {
        scanner.fail("expected a keyword and found " + shown(keyword) + "; this is not an OBJ file");
      }
      while (line_goes_on()) scanner.word("a value");
    }
  }
  if (mesh.triangles.empty())
    scanner.fail(mesh.repeated_corners > 0 ? no_face_is_left
                                           : "no faces (f) in this file; export the mesh as polygons");
  return mesh;
}

SurfaceMesh read_stl(const std::string& file, std::string_view bytes) {
  // Binary files may begin with "solid" too: the size decides.
  std::uint64_t count = 0;
  if (bytes.size() >= stl_header) {
    for (std::size_t k = 0; k < 4; ++k) {
      count |= std::uint64_t{static_cast<unsigned char>(bytes[80 + k])} << (8 * k);
    }
  }
  const bool is_binary = bytes.size() >= stl_header && bytes.size() == stl_header + stl_triangle * count;
  if (!is_binary && bytes.substr(0, 5) != "solid") {
    throw base::SceneError(file +
                           ": byte 80: not an STL file: it neither begins with \"solid\" nor has the " +
                           std::to_string(stl_header + stl_triangle * count) +
                           " bytes of a binary one with " + std::to_string(count) + " triangles, but " +
                           std::to_string(bytes.size()) + "; it may be cut short, export it again");
  }
  SurfaceMesh mesh = is_binary ? read_binary_stl(file, bytes) : read_ascii_stl(file, bytes);
  if (mesh.triangles.empty())
    throw base::SceneError(file + ":1: no triangles in this file; export a surface");
  return mesh;
}

}  // namespace fascicle::mesh
