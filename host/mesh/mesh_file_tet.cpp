// Tetrahedral meshes in text formats: MEDIT, TetGen, Gmsh 2.2.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/mesh/mesh_readers.h"
#include "host/mesh/text_scanner.h"

namespace fascicle::mesh {
namespace {

using Tetrahedron = std::array<std::uint32_t, 4>;

// Shortest entries: "0 0 0 " and "1 2 3 4 ".
constexpr std::size_t point_bytes = 6;
constexpr std::size_t tetrahedron_bytes = 8;

void append_tetrahedron(TetMesh& mesh, const Tetrahedron& t, const TextScanner& scanner) {
  if (t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] || t[2] == t[3]) {
    scanner.fail("a tetrahedron names a vertex twice; remove it");
  }
  mesh.tetrahedra.push_back(t);
}

// Gmsh's types of elements that fill space: of five to eight sides or corners, and of higher order.
bool is_volume(std::uint64_t type) {
  return (type >= 4 && type <= 7) || (type >= 11 && type <= 14) || (type >= 17 && type <= 19) ||
         (type >= 29 && type <= 33) || type == 35 || (type >= 71 && type <= 75) ||
         (type >= 79 && type <= 83) || (type >= 87 && type <= 132);
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// Node numbers of a Gmsh file need not be consecutive.
class NodeNumbers {
 public:
  void add(std::uint64_t number, std::uint32_t index) { entries_.emplace_back(number, index); }

  // Call after adding all numbers. Returns a duplicate number, or null.
  const std::uint64_t* sort() {
    std::sort(entries_.begin(), entries_.end());
    const auto twice = std::adjacent_find(entries_.begin(), entries_.end(),
                                          [](const Entry& a, const Entry& b) { return a.first == b.first; });
    return twice == entries_.end() ? nullptr : &twice->first;
  }

  const std::uint32_t* find(std::uint64_t number) const {
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), Entry{number, 0});
    return found == entries_.end() || found->first != number ? nullptr : &found->second;
  }

 private:
  using Entry = std::pair<std::uint64_t, std::uint32_t>;
  std::vector<Entry> entries_;
};

// Hexahedra, PrismsP2, TetrahedraP3 and the like, but not HexahedraQ2Ordering.
bool is_other_volume_section(std::string_view keyword) {
  if (keyword.ends_with("Ordering")) return false;
  for (const std::string_view kind : {"Tetrahedra", "Hexahedra", "Prisms", "Pyramids"})
    if (keyword.starts_with(kind)) return true;
  return false;
}

}  // namespace

TetMesh read_medit(const std::string& file, std::string_view text) {
  TextScanner scanner(file, text, '#');
  if (scanner.word("MeshVersionFormatted") != "MeshVersionFormatted") {
    scanner.fail("not a MEDIT mesh: it does not begin with MeshVersionFormatted; export it as ASCII .mesh");
  }
  scanner.whole("the format's version", 1, 4);
  TetMesh mesh;
  bool has_vertices = false;
  bool has_tetrahedra = false;
  while (!scanner.at_end()) {
    const std::string_view keyword = scanner.word("a keyword");
    if (!is_letter(keyword.front())) {
      scanner.fail("expected a keyword and found " + shown(keyword) +
                   "; the section before it has more entries than its count says");
    }
    if (keyword == "End") break;
    if (keyword == "Dimension") {
      scanner.whole("Dimension", 3, 3);
    } else if (keyword == "Vertices") {
      if (has_vertices) scanner.fail("a second Vertices section; join the two");
      has_vertices = true;
      const std::size_t count = scanner.count("the number of vertices", point_bytes + 2);
      mesh.vertices.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        mesh.vertices.push_back(scanner.point("a coordinate"));
        scanner.word("a vertex's reference");
      }
    } else if (keyword == "Tetrahedra") {
      if (!has_vertices) scanner.fail("Tetrahedra before Vertices; put Vertices first");
      if (has_tetrahedra) scanner.fail("a second Tetrahedra section; join the two");
      has_tetrahedra = true;
      const std::size_t count = scanner.count("the number of tetrahedra", tetrahedron_bytes + 2);
      mesh.tetrahedra.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        Tetrahedron t;
        for (std::uint32_t& v : t) v = scanner.index(mesh.vertices.size(), 1);
        append_tetrahedron(mesh, t, scanner);
        scanner.word("a tetrahedron's reference");
      }
    } else if (is_other_volume_section(keyword)) {
      const std::size_t count = scanner.count("the number of cells", tetrahedron_bytes + 2);
      if (count > 0)
        scanner.fail(other_cells(count) + " (" + std::string(keyword) + "); split them into tetrahedra");
    } else {
      // Triangles, Edges, Corners, Normals and other sections: skips numbers up to the next keyword.
      while (!scanner.at_end() && !is_letter(scanner.peek().front())) scanner.word("a number");
    }
  }
  if (mesh.tetrahedra.empty()) {
    scanner.fail("no tetrahedra in this mesh; a surface belongs in an .off, .obj, .ply or .stl file");
  }
  return mesh;
}

TetMesh read_tetgen(const std::string& node_file, std::string_view nodes, const std::string& ele_file,
                    std::string_view elements) {
  TetMesh mesh;
  std::uint64_t base = 0;
  TextScanner node(node_file, nodes, '#');
  const std::size_t vertex_count = node.count("the number of nodes", point_bytes + 2);
  if (vertex_count == 0) node.fail("no nodes; give the .node file that belongs to the .ele file");
  node.whole("the dimension", 3, 3);
  const std::uint64_t attributes = node.whole("the number of attributes of a node", 0, 1000);
  const std::uint64_t markers = node.whole("the number of boundary markers of a node", 0, 1);
  mesh.vertices.reserve(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const std::uint64_t number = node.whole("a node's number");
    if (i == 0) {
      if (number > 1) node.fail("nodes must be numbered from 0 or 1, not from " + std::to_string(number));
      base = number;
    } else if (number != base + i) {
      node.fail("expected node " + std::to_string(base + i) + " and found " + std::to_string(number) +
                "; nodes must be in order, with as many values as the first line says");
    }
    mesh.vertices.push_back(node.point("a coordinate"));
    for (std::uint64_t k = 0; k < attributes + markers; ++k) node.number("an attribute or marker");
  }
  if (!node.at_end()) {
    node.word("the end");
    node.fail("extra data after the last node; correct the count in the first line");
  }

  TextScanner ele(ele_file, elements, '#');
  const std::size_t count = ele.count("the number of tetrahedra", tetrahedron_bytes + 2);
  if (count == 0) ele.fail("no tetrahedra in this file; run TetGen again");
  if (ele.whole("the number of nodes of a tetrahedron", 4, 10) != 4) {
    ele.fail("tetrahedra with more than four nodes are not supported; run TetGen without -o2");
  }
  const std::uint64_t regions = ele.whole("the number of attributes of a tetrahedron", 0, 1000);
  mesh.tetrahedra.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    ele.whole("a tetrahedron's number", base + i, base + i);
    Tetrahedron t;
    for (std::uint32_t& v : t) v = ele.index(mesh.vertices.size(), base);
    append_tetrahedron(mesh, t, ele);
    for (std::uint64_t k = 0; k < regions; ++k) ele.number("an attribute");
  }
  if (!ele.at_end()) {
    ele.word("the end");
    ele.fail("extra data after the last tetrahedron; correct the count in the first line");
  }
  return mesh;
}

TetMesh read_gmsh(const std::string& file, std::string_view text) {
  constexpr std::uint64_t four_node_tetrahedron = 4;
  const std::string advice = "; save it as version 2.2 ASCII (gmsh -format msh22 -save)";
  TextScanner scanner(file, text, '\0');
  if (scanner.word("$MeshFormat") != "$MeshFormat") {
    scanner.fail("not a Gmsh file: it does not begin with $MeshFormat" + advice);
  }
  const std::string_view version = scanner.word("the format's version");
  if (version != "2.2" && version != "2.1" && version != "2" && version != "2.0") {
    scanner.fail("version " + shown(version) + " is not supported" + advice);
  }
  if (scanner.word("the file type") != "0") scanner.fail("binary files are not supported" + advice);
  scanner.until("$EndMeshFormat");

  TetMesh mesh;
  NodeNumbers numbers;
  bool has_elements = false;
  const auto expect = [&](std::string_view end) {
    if (scanner.word(end) != end) {
      scanner.fail("expected " + std::string(end) + "; the section's count does not match its lines");
    }
  };
  while (!scanner.at_end()) {
    const std::string_view section = scanner.word("a section");
    if (section.size() < 2 || section.front() != '$') {
      scanner.fail("expected a section ($Name) and found " + shown(section) + advice);
    }
    if (section == "$Nodes") {
      if (!mesh.vertices.empty()) scanner.fail("a second $Nodes section; join the two");
      const std::size_t count = scanner.count("the number of nodes", point_bytes + 2);
      mesh.vertices.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        numbers.add(scanner.whole("a node's number"), static_cast<std::uint32_t>(i));
        mesh.vertices.push_back(scanner.point("a coordinate"));
      }
      expect("$EndNodes");
      if (const std::uint64_t* twice = numbers.sort()) {
        scanner.fail("node number " + std::to_string(*twice) + " is given twice; number the nodes uniquely");
      }
    } else if (section == "$Elements") {
      if (has_elements) scanner.fail("a second $Elements section; join the two");
      if (mesh.vertices.empty()) scanner.fail("$Elements before $Nodes; put $Nodes first");
      has_elements = true;
      const std::size_t count = scanner.count("the number of elements", 6);  // a point element is "1 15 0 1"
                                                                             // or longer
      std::size_t others = 0;
      for (std::size_t i = 0; i < count; ++i) {
        scanner.whole("an element's number");
        if (const std::uint64_t type = scanner.whole("an element's type"); type != four_node_tetrahedron) {
          others += is_volume(type) ? 1U : 0U;
          scanner.skip_line();
          continue;
        }
        const std::uint64_t tags = scanner.whole("an element's number of tags", 0, 1000);
        for (std::uint64_t k = 0; k < tags; ++k) scanner.word("a tag");
        Tetrahedron t;
        for (std::uint32_t& v : t) {
          const std::uint64_t number = scanner.whole("a node's number");
          const std::uint32_t* found = numbers.find(number);
          if (found == nullptr) {
            scanner.fail("an element names node " + std::to_string(number) +
                         ", which $Nodes does not have; correct it");
          }
          v = *found;
        }
        append_tetrahedron(mesh, t, scanner);
      }
      expect("$EndElements");
      if (others > 0)
        scanner.fail(other_cells(others) + "; split them, or mesh the volume again (gmsh -3 -order 1)");
    } else {
      scanner.until("$End" + std::string(section.substr(1)));
    }
  }
  if (mesh.tetrahedra.empty()) {
    scanner.fail("no 4-node tetrahedra (type 4) in this file; mesh the volume first (gmsh -3 -order 1)");
  }
  return mesh;
}

}  // namespace fascicle::mesh
