// VTK's XML format for unstructured grids, ASCII. The XML reader here knows tags, attributes, comments and
// declarations, which is all that writers of such files use.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/errors.h"
#include "host/mesh/mesh_readers.h"
#include "host/mesh/text_scanner.h"

namespace fascicle::mesh {
namespace {

struct Tag {
  std::string_view name;
  std::string_view attributes;
  bool closes = false;  // </name>
  bool empty = false;   // <name/>
};

// The value of an attribute; empty if it is missing.
std::string_view attribute(const Tag& tag, std::string_view name) {
  std::string_view rest = tag.attributes;
  const auto skip_blanks = [&] {
    const std::size_t start = rest.find_first_not_of(" \t\r\n");
    rest.remove_prefix(std::min(start, rest.size()));
  };
  for (skip_blanks(); !rest.empty(); skip_blanks()) {
    const std::size_t equals = rest.find('=');
    if (equals == std::string_view::npos) return {};
    std::string_view found = rest.substr(0, equals);
    found = found.substr(0, found.find_last_not_of(" \t\r\n") + 1);
    rest.remove_prefix(equals + 1);
    skip_blanks();
    if (rest.empty() || (rest.front() != '"' && rest.front() != '\'')) return {};
    const std::size_t end = rest.find(rest.front(), 1);
    if (end == std::string_view::npos) return {};
    if (found == name) return rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
  }
  return {};
}

// Skips text, comments and declarations to the next tag.
Tag next_tag(TextScanner& scanner) {
  for (;;) {
    scanner.until("<");
    if (scanner.skip_if("!--")) {
      scanner.until("-->");
      continue;
    }
    if (scanner.skip_if("?")) {
      scanner.until("?>");
      continue;
    }
    std::string_view inside = scanner.until(">");
    Tag tag;
    if (!inside.empty() && inside.front() == '!') {
      scanner.fail("a document type or CDATA is not supported; export the file from ParaView as ASCII .vtu");
    }
    tag.closes = !inside.empty() && inside.front() == '/';
    if (tag.closes) inside.remove_prefix(1);
    tag.empty = !inside.empty() && inside.back() == '/';
    if (tag.empty) inside.remove_suffix(1);
    const std::size_t end = std::min(inside.find_first_of(" \t\r\n"), inside.size());
    tag.name = inside.substr(0, end);
    tag.attributes = inside.substr(end);
    return tag;
  }
}

struct Grid {
  std::uint64_t point_count = 0;
  std::uint64_t cell_count = 0;
  bool has_piece = false, has_points = false;
  std::vector<Vector3d> points;
  std::vector<std::uint64_t> connectivity, offsets, types;
};

// A count from an attribute, checked against the file's size: a number and its separator take at least two
// characters.
std::uint64_t piece_count(const TextScanner& scanner, const std::string& file, const Tag& tag,
                          std::string_view name) {
  TextScanner value(file, attribute(tag, name), '\0');
  std::uint64_t count = 0;
  try {
    count = value.whole(name);
  } catch (const base::SceneError&) {
    scanner.fail(std::string(name) + " is missing or not a whole number; correct it");
  }
  if (count > scanner.remaining() / 2) {
    scanner.fail(std::string(name) + " is " + std::to_string(count) + ", more than the rest of the file (" +
                 std::to_string(scanner.remaining()) +
                 " bytes) can hold; the count is wrong or the file is cut short");
  }
  return count;
}

std::vector<std::uint64_t> read_whole_numbers(TextScanner& scanner, std::string_view what) {
  std::vector<std::uint64_t> values;
  while (!scanner.at_end()) values.push_back(scanner.whole(what));
  return values;
}

void read_array(TextScanner& scanner, const Tag& array, const std::string& parent, Grid& grid) {
  const std::string_view name = attribute(array, "Name");
  const bool is_point_array = parent == "Points";
  const bool is_needed = is_point_array || (parent == "Cells" &&
                                            (name == "connectivity" || name == "offsets" || name == "types"));
  if (!is_needed) return;  // next_tag() skips its numbers
  if (attribute(array, "format") != "ascii") {
    scanner.fail("array " + shown(name) + " has format " + shown(attribute(array, "format")) +
                 "; only ascii is supported, save the file with data mode ASCII");
  }
  if (array.empty) return;
  if (is_point_array) {
    if (attribute(array, "NumberOfComponents") != "3") {
      scanner.fail("points must have NumberOfComponents=\"3\"; correct it");
    }
    if (grid.has_points) scanner.fail("a second array of points; remove it");
    grid.has_points = true;
    while (!scanner.at_end()) {
      grid.points.push_back(scanner.point("a coordinate"));
    }
    return;
  }
  std::vector<std::uint64_t>& target = name == "connectivity" ? grid.connectivity
                                       : name == "offsets"    ? grid.offsets
                                                              : grid.types;
  if (!target.empty()) scanner.fail("a second array " + shown(name) + "; remove it");
  target = read_whole_numbers(scanner, name);
}

Grid read_grid(const std::string& file, TextScanner& scanner) {
  constexpr std::size_t deepest = 32;  // VTK nests five deep
  Grid grid;
  std::vector<std::string> open;
  do {
    const Tag tag = next_tag(scanner);
    if (tag.closes) {
      if (open.empty() || open.back() != tag.name) {
        scanner.fail("</" + std::string(tag.name.substr(0, 32)) +
                     "> has no opening tag; the file is damaged");
      }
      open.pop_back();
      continue;
    }
    if (open.empty() && (tag.name != "VTKFile" || attribute(tag, "type") != "UnstructuredGrid")) {
      scanner.fail("not a VTKFile of type UnstructuredGrid; save the mesh as an unstructured grid (.vtu)");
    }
    if (tag.name == "Piece") {
      if (grid.has_piece) scanner.fail("more than one Piece; merge the pieces (ParaView: Merge Blocks)");
      grid.has_piece = true;
      grid.point_count = piece_count(scanner, file, tag, "NumberOfPoints");
      grid.cell_count = piece_count(scanner, file, tag, "NumberOfCells");
    } else if (tag.name == "DataArray" && !open.empty()) {
      if (!grid.has_piece) scanner.fail("a DataArray outside a Piece; the file is damaged");
      read_array(scanner, tag, open.back(), grid);
    }
    if (!tag.empty) open.emplace_back(tag.name);
    if (open.size() > deepest) scanner.fail("tags nested too deep; the file is damaged");
  } while (!open.empty());
  return grid;
}

// VTK's types of cells that fill space, except the tetrahedron of four vertices: voxels to hexagonal prisms,
// those of second order, polyhedra, and those of any order.
bool is_other_volume(std::uint64_t type) {
  return (type >= 11 && type <= 16) || (type >= 24 && type <= 27) || type == 29 ||
         (type >= 31 && type <= 33) || type == 37 || type == 41 || type == 42 || (type >= 64 && type <= 67) ||
         (type >= 71 && type <= 74) || (type >= 78 && type <= 81);
}

}  // namespace

TetMesh read_vtu(const std::string& file, std::string_view text) {
  constexpr std::uint64_t vtk_tetra = 10;
  TextScanner scanner(file, text, '\0', '<');
  Grid grid = read_grid(file, scanner);
  if (grid.points.size() != grid.point_count) {
    scanner.fail("NumberOfPoints is " + std::to_string(grid.point_count) + " and there are " +
                 std::to_string(grid.points.size()) + " points; the file is damaged, save it again");
  }
  if (grid.offsets.size() != grid.cell_count || grid.types.size() != grid.cell_count) {
    scanner.fail("NumberOfCells is " + std::to_string(grid.cell_count) + " and there are " +
                 std::to_string(grid.offsets.size()) + " offsets and " + std::to_string(grid.types.size()) +
                 " types; the file is damaged, save it again");
  }
  TetMesh mesh;
  std::size_t others = 0;
  std::uint64_t start = 0;
  for (std::size_t cell = 0; cell < grid.types.size(); ++cell) {
    const std::uint64_t end = grid.offsets[cell];
    const std::string name = "cell " + std::to_string(cell) + " (counted from 0)";
    if (end < start || end > grid.connectivity.size()) {
      scanner.fail(name + " ends at offset " + std::to_string(end) +
                   ", outside the connectivity; save the file again");
    }
    others += is_other_volume(grid.types[cell]) ? 1U : 0U;
    if (grid.types[cell] == vtk_tetra) {
      if (end - start != 4)
        scanner.fail(name + " is a tetrahedron without four vertices; save the file again");
      std::array<std::uint32_t, 4> t{};
      for (std::size_t k = 0; k < 4; ++k) {
        const std::uint64_t vertex = grid.connectivity[start + k];
        if (vertex >= grid.points.size()) {
          scanner.fail(name + " names point " + std::to_string(vertex) + " of " +
                       std::to_string(grid.points.size()) + ", counted from 0; correct it");
        }
        t[k] = static_cast<std::uint32_t>(vertex);
        if (std::count(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(k), t[k]) > 0) {
          scanner.fail(name + " names a point twice; remove it");
        }
      }
      mesh.tetrahedra.push_back(t);
    }
    start = end;
  }
  if (others > 0) scanner.fail(other_cells(others) + "; split them (ParaView: Tetrahedralize)");
  if (mesh.tetrahedra.empty())
    scanner.fail("no tetrahedra (cell type 10) in this file; mesh the volume first");
  mesh.vertices = std::move(grid.points);
  return mesh;
}

}  // namespace fascicle::mesh
