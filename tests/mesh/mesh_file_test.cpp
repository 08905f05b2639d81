// Every reader, on small hand-written files: what they contain, and how broken ones are refused.
#include "host/mesh/mesh_file.h"

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/base/errors.h"
#include "tests/support/seed.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using base::SceneError;
using Eigen::Vector3d;
using mesh::SurfaceMesh;
using mesh::TetMesh;

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "fascicle-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  SurfaceMesh surface(const std::string& name, const std::string& content) const {
    return mesh::read_surface_mesh(write(name, content));
  }
  TetMesh tets(const std::string& name, const std::string& content) const {
    return mesh::read_tet_mesh(write(name, content));
  }

  // The error message, without the folder.
  std::string refusal(const std::string& name, const std::string& content) const {
    return refusal(write(name, content));
  }
  std::string refusal(const fs::path& path) const {
    try {
      if (mesh::is_tet_mesh_file(path)) {
        mesh::read_tet_mesh(path);
      } else {
        mesh::read_surface_mesh(path);
      }
    } catch (const SceneError& error) {
      const std::string what = error.what();
      const std::string prefix = folder_.string() + "/";
      return what.rfind(prefix, 0) == 0 ? what.substr(prefix.size()) : what;
    }
    return "accepted";
  }

  fs::path folder_;
};

// Two tetrahedra that share the face 1 2 3.
void expect_two_tets(const TetMesh& mesh) {
  const std::vector<Vector3d> vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1.5}};
  EXPECT_EQ(mesh.vertices, vertices);
  const std::vector<std::array<std::uint32_t, 4>> tetrahedra = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  EXPECT_EQ(mesh.tetrahedra, tetrahedra);
}

// A pyramid over a unit square; the square is split into two triangles.
void expect_pyramid(const SurfaceMesh& mesh) {
  const std::vector<Vector3d> vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.75}};
  EXPECT_EQ(mesh.vertices, vertices);
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{3, 2, 1}, {3, 1, 0}, {0, 1, 4},
                                                               {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  EXPECT_EQ(mesh.triangles, triangles);
}

#define EXPECT_REFUSED(message, part) \
  EXPECT_NE((message).find(part), std::string::npos) << "the message is: " << (message)

const std::string medit_text =
    "MeshVersionFormatted 2\n# a comment\nDimension\n3\nVertices\n5\n0 0 0 1\n+1 0 0 1\n0 1e0 0 1\n0 0 1.0 "
    "1\n"
    "1 1 1.5 1\nTriangles\n1\n1 2 3 7\nTetrahedra\n2\n1 2 3 4 0\n2 3 4 5 0\nEnd\n";
const std::string gmsh_text =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a body\"\n$EndPhysicalNames\n$Nodes\n5\n"
    "10 0 0 0\n2 1 0 0\n30 0 1 0\n4 0 0 1\n1000000000000 1 1 1.5\n$EndNodes\n$Elements\n3\n1 2 2 0 1 10 2 "
    "30\n"
    "2 4 2 0 1 10 2 30 4\n3 4 0 2 30 4 1000000000000\n$EndElements\n";
const std::string vtu_text =
    "<?xml version=\"1.0\"?>\n<!-- <Piece> in a comment -->\n<VTKFile type=\"UnstructuredGrid\" "
    "version=\"0.1\">\n"
    "<UnstructuredGrid>\n<Piece NumberOfPoints='5' NumberOfCells='3'>\n"
    "<PointData><DataArray type=\"Float32\" Name=\"types\" format=\"ascii\">nan 1 2 3 "
    "4</DataArray></PointData>\n"
    "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n"
    "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1.5</DataArray></Points>\n<Cells>\n"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 5 10</DataArray>\n"
    "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3\n0 1 2\n1 2 3 4\n</DataArray>\n"
    "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 7 11</DataArray>\n</Cells>\n</Piece>\n"
    "</UnstructuredGrid>\n</VTKFile>\n";
const std::string node_text =
    "# nodes\n5 3 1 1\n1 0 0 0 9.5 0\n2 1 0 0 9 0\n3 0 1 0 9 0\n4 0 0 1 9 0\n5 1 1 1.5 9 0\n";
const std::string ele_text = "2 4 1\n1 1 2 3 4 1\n2 2 3 4 5 1 # the end\n";

const std::string off_text =
    "OFF 5 5 0\n0 0 0\n1 0 0 # a corner\n1 1 0 0.5 0.5 0.5\n0 1 0\n.5 5e-1 0.75\n4 3 2 1 0\n3 0 1 4 255 0 0\n"
    "3 1 2 4\n3 2 3 4\n3 3 0 4\n";
const std::string obj_text =
    "# a pyramid\nmtllib a.mtl\no pyramid\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.75\nvn 0 0 1\n"
    "s off\nf 4/1/1 3/2/1 2/3/1 \\\n 1/4/1\nf 1//1 2//1 -1//1\nf 2/1 3/2 5/3\nf -3 -2 -1\nf 4 1 5\n";
const std::string ply_header_end =
    " 1.0\ncomment element vertex 7\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nelement face 5\nproperty list uchar int vertex_indices\nproperty float quality\n"
    "end_header\n";
const std::string ply_text = "ply\nformat ascii" + ply_header_end +
                             "0 0 0 1\n1 0 0 2\n1 1 0 3\n0 1 0 4\n0.5 0.5 0.75 5\n4 3 2 1 0 nan\n3 0 1 4 1\n"
                             "3 1 2 4 1\n3 2 3 4 1\n3 3 0 4 1\n";

template <typename Number>
void append_bytes(std::string& bytes, Number number, bool is_big_endian = false) {
  const auto* first = reinterpret_cast<const char*>(&number);
  std::string word(first, sizeof number);
  if (is_big_endian != (std::endian::native == std::endian::big)) word.assign(word.rbegin(), word.rend());
  bytes += word;
}

const std::vector<std::array<float, 3>> pyramid_points = {
    {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 0.5F, 0.75F}};

std::string binary_ply(bool is_big_endian) {
  std::string bytes =
      "ply\nformat binary_" + std::string(is_big_endian ? "big" : "little") + "_endian" + ply_header_end;
  for (const auto& point : pyramid_points) {
    for (const float c : point) append_bytes(bytes, c, is_big_endian);
    append_bytes(bytes, std::uint8_t{7});
  }
  for (const auto& face :
       std::vector<std::vector<std::int32_t>>{{3, 2, 1, 0}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}) {
    append_bytes(bytes, static_cast<std::uint8_t>(face.size()));
    for (const std::int32_t v : face) append_bytes(bytes, v, is_big_endian);
    append_bytes(bytes, 1.0F, is_big_endian);
  }
  return bytes;
}

std::string binary_stl() {
  std::string bytes = "solid by its name, binary by its size";
  bytes.resize(80, ' ');
  append_bytes(bytes, std::uint32_t{4});
  for (const auto& t : std::vector<std::array<std::size_t, 3>>{{0, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 0, 4}}) {
    for (int k = 0; k < 3; ++k) append_bytes(bytes, std::numeric_limits<float>::quiet_NaN());
    for (const std::size_t v : t) {
      // -0 and +0 are the same position and must be welded.
      for (const float c : pyramid_points[v]) append_bytes(bytes, c == 0.0F && t[1] == 2 ? -0.0F : c);
    }
    append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ascii_stl() {
  std::string text = "solid a name of words\n";
  for (const std::string t : {"0 0 0,1 1 0,1 0 0", "0 0 0,1 0 0,0.5 0.5 0.75", "1 0 0,1 1 0,0.5 0.5 0.75",
                              "1 1 0,0 0 0,0.5 0.5 0.75"}) {
    text += "facet normal 0 0 nan\nouter loop\nvertex " + t + "\nendloop\nendfacet\n";
    for (std::size_t at; (at = text.find(',')) != std::string::npos;) text.replace(at, 1, "\nvertex ");
  }
  return text + "endsolid a name of words\n";
}

TEST_F(MeshFile, ReadsTetrahedralFormats) {
  expect_two_tets(tets("a.mesh", medit_text));
  expect_two_tets(tets("a.MSH", gmsh_text));
  expect_two_tets(tets("a.vtu", vtu_text));
  write("t.1.ele", ele_text);
  expect_two_tets(tets("t.1.node", node_text));
  expect_two_tets(mesh::read_tet_mesh(folder_ / "t.1.ele"));
  write("z.node", "5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1 1 1.5\n");
  expect_two_tets(tets("z.ele", "2 4 0\n0 0 1 2 3\n1 1 2 3 4"));
}

TEST_F(MeshFile, ReadsSurfaceFormats) {
  expect_pyramid(surface("a.off", off_text));
  expect_pyramid(surface("a.obj", obj_text));
  expect_pyramid(surface("a.ply", ply_text));
  expect_pyramid(surface("b.ply", binary_ply(false)));
  expect_pyramid(surface("c.PLY", binary_ply(true)));
}

TEST_F(MeshFile, ReadsWindowsLineEnds) {
  const auto with_returns = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
    return text;
  };
  expect_pyramid(surface("a.off", with_returns(off_text)));
  expect_pyramid(surface("a.obj", with_returns(obj_text)));
  expect_pyramid(surface("a.ply", with_returns(ply_text)));
  expect_two_tets(tets("a.mesh", with_returns(medit_text)));
  expect_two_tets(tets("a.msh", with_returns(gmsh_text)));
}

TEST_F(MeshFile, WeldsStl) {
  for (const std::string& content : {binary_stl(), ascii_stl()}) {
    const SurfaceMesh mesh = surface("a.stl", content);
    const std::vector<Vector3d> vertices = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0.5, 0.5, 0.75}};
    EXPECT_EQ(mesh.vertices, vertices);
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {1, 0, 3}};
    EXPECT_EQ(mesh.triangles, triangles);
  }
}

TEST_F(MeshFile, OffKeepsEveryBit) {
  std::mt19937_64 random(1);
  SurfaceMesh mesh;
  while (mesh.vertices.size() < 1000) {
    Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      // Random bits of any finite number, including denormals and -0.
      double value = std::bit_cast<double>(random());
      while (!(value - value == 0.0)) value = std::bit_cast<double>(random());
      point[axis] = value;
    }
    mesh.vertices.push_back(point);
  }
  mesh.vertices[0] = {-0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max()};
  for (std::uint32_t i = 0; i + 2 < mesh.vertices.size(); ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  mesh::write_off(folder_ / "bits.off", mesh);
  const SurfaceMesh back = mesh::read_surface_mesh(folder_ / "bits.off");
  ASSERT_EQ(back.vertices.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(back.vertices[i][axis]),
                std::bit_cast<std::uint64_t>(mesh.vertices[i][axis]));
    }
  }
  EXPECT_EQ(back.triangles, mesh.triangles);
}

TEST_F(MeshFile, OffIsWrittenWholeOrNotAtAll) {
  const SurfaceMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  EXPECT_THROW(mesh::write_off(folder_ / "missing" / "a.off", mesh), std::system_error);
  fs::create_directory(folder_ / "taken.off");
  write("taken.off/inside", "");
  EXPECT_THROW(mesh::write_off(folder_ / "taken.off", mesh), std::system_error);
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_)) ++entries;
  EXPECT_EQ(entries, 1U) << "a temporary file was left behind";
}

TEST_F(MeshFile, RefusalsNameFileAndLine) {
  EXPECT_REFUSED(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n"), "a.off:4: ");
  EXPECT_REFUSED(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "a.off:6: vertex number 3");
  EXPECT_REFUSED(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1\n"), "a.off:6: ");
  EXPECT_REFUSED(refusal("a.off", "OFF\n4000000000 1 0\n0 0 0\n"),
                 "a.off:2: the number of vertices is 4000000000");
  EXPECT_REFUSED(refusal("a.off", "OFF\n3 4000000000 0\n0 0 0\n"),
                 "a.off:2: the number of faces is 4000000000");
  EXPECT_REFUSED(refusal("a.off", "OFF\n18446744073709551616 1 0\n"), "not a whole number");
  EXPECT_REFUSED(refusal("a.off", "OFF\n1 1 0\n0 0 0\n4000000000 0 0 0 0\n"), "the number of corners");
  EXPECT_REFUSED(refusal("a.off", "STL\n"), "not an OFF file");
  EXPECT_REFUSED(refusal("a.off", "OFF\n1 0 0\n0 0 0\n"), "no faces");
  EXPECT_REFUSED(refusal("a.off", "OFF\n0 1 0\n3 0 0 0\n"), "no vertices");
  for (const std::string bad : {"nan", "inf", "-inf", "0x10", "1e999", "1,5", "+-1", "--1", "1d3", "1.0f"}) {
    EXPECT_REFUSED(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 " + bad + "\n3 0 1 2\n"), "a.off:5: ");
  }
  EXPECT_REFUSED(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), "a.obj:4: ");
  EXPECT_REFUSED(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n"), "a.obj:4: ");
  EXPECT_REFUSED(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"), "a.obj:4: ");
  EXPECT_REFUSED(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 /3\n"), "a.obj:4: ");
  EXPECT_REFUSED(refusal("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n"), "a.obj:3: a face with 2 corners");
  EXPECT_REFUSED(refusal("a.obj", "v 0 0\nv 1 0 0\n"), "a.obj:2: ");
  EXPECT_REFUSED(refusal("a.obj", "# nothing\n"), "no faces");
  EXPECT_REFUSED(refusal("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n"), "a.stl:5: ");
  EXPECT_REFUSED(refusal("a.stl", "solid x\nendsolid x\n"), "no triangles");
  EXPECT_REFUSED(refusal("a.stl", "hello"), "not an STL file");
  EXPECT_REFUSED(refusal("a.stl", binary_stl().substr(0, 200)), "a.stl:");
}

TEST_F(MeshFile, PlyRefusals) {
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, from.size(), to);
  };
  const std::string binary = binary_ply(false);
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "ply", "plx")), "not a PLY file");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "end_header", "end")), "not a PLY file");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "vertex 5", "vertex 4000000000")), "can hold");
  EXPECT_REFUSED(refusal("a.ply", replaced(binary, "vertex 5", "vertex 4000000000")), "can hold");
  EXPECT_REFUSED(refusal("a.ply", replaced(binary, "face 5", "face 6")), "cut short");
  EXPECT_REFUSED(refusal("a.ply", replaced(binary, "face 5", "face 4")), "extra data");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "3 0 1 4 1", "3 0 1 5 1")), "a.ply:19: ");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "3 0 1 4 1", "3 0 1 -1 1")), "a.ply:19: ");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "0 1 0 4\n", "0 nan 0 4\n")), "a.ply:16: ");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "property float z", "property float w")),
                 "lacks x, y or z");
  EXPECT_REFUSED(refusal("a.ply", replaced(ply_text, "property float x", "property real x")),
                 "not a PLY type");
  EXPECT_REFUSED(refusal("a.ply", "ply\nformat ascii 1.0\nelement junk 4000000000\nend_header\n"),
                 "no properties");
  std::string with_nan = binary;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t first = binary.find("end_header\n") + 11;
  with_nan.replace(first, 4, std::string(reinterpret_cast<const char*>(&nan), 4));
  EXPECT_REFUSED(refusal("a.ply", with_nan), "byte " + std::to_string(first));
}

TEST_F(MeshFile, TetrahedralRefusals) {
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos);
    return text.replace(at, from.size(), to);
  };
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "MeshVersion", "Mesh")),
                 "a.mesh:1: not a MEDIT mesh");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "\n3\n", "\n2\n")), "a.mesh:4: Dimension");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "2 3 4 5 0", "2 3 4 6 0")),
                 "a.mesh:18: vertex number 6");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "2 3 4 5 0", "2 3 4 0 0")),
                 "a.mesh:18: vertex number 0");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "2 3 4 5 0", "2 3 4 4 0")), "twice");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "Vertices\n5", "Vertices\n4000000000")), "can hold");
  EXPECT_REFUSED(refusal("a.mesh", replaced(medit_text, "Vertices\n5", "Vertices\n4")), "expected a keyword");
  EXPECT_REFUSED(refusal("a.mesh", "MeshVersionFormatted 2\nDimension 3\nEnd\n"), "no tetrahedra");
  EXPECT_REFUSED(refusal("a.msh", replaced(gmsh_text, "2.2 0 8", "4.1 0 8")), "a.msh:2: version \"4.1\"");
  EXPECT_REFUSED(refusal("a.msh", replaced(gmsh_text, "2.2 0 8", "2.2 1 8")), "binary");
  EXPECT_REFUSED(refusal("a.msh", replaced(gmsh_text, "4 0 0 1\n", "2 0 0 1\n")), "given twice");
  EXPECT_REFUSED(refusal("a.msh", replaced(gmsh_text, "10 2 30 4\n", "10 2 30 5\n")), "names node 5");
  EXPECT_REFUSED(refusal("a.msh", replaced(gmsh_text, "$EndElements", "")), "a.msh:");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "UnstructuredGrid", "PolyData")), "a.vtu:3: ");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "connectivity\" format=\"ascii\"",
                                           "connectivity\" format=\"appended\"")),
                 "only ascii");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "4 7 11", "4 7 12")), "offset 12");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "4 7 11", "4 3 11")), "offset 3");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "1 2 3 4\n<", "1 2 3 5\n<")), "names point 5");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "'5'", "'4000000000'")), "can hold");
  EXPECT_REFUSED(refusal("a.vtu", replaced(vtu_text, "</Cells>", "</Cell>")), "has no opening tag");
  EXPECT_REFUSED(refusal("a.vtu", std::string(100000, '<')), "a.vtu:");
  write("a.ele", ele_text);
  EXPECT_REFUSED(refusal("a.node", replaced(node_text, "3 0 1 0", "4 0 1 0")), "expected node 3");
  EXPECT_REFUSED(refusal("a.node", replaced(node_text, "1 0 0 0 9.5", "2 0 0 0 9.5")), "from 0 or 1");
  EXPECT_REFUSED(refusal("a.node", replaced(node_text, "5 3 1 1", "4000000000 3 1 1")), "can hold");
  EXPECT_REFUSED(refusal("b.node", node_text), "b.ele: no such file");
  write("c.ele", replaced(ele_text, "2 4 1", "2 10 1"));
  EXPECT_REFUSED(refusal("c.node", node_text), "c.ele:1: ");
}

TEST_F(MeshFile, RefusesWhatIsNoFileOfAMesh) {
  EXPECT_REFUSED(refusal(folder_ / "missing.off"), "does not exist");
  EXPECT_REFUSED(refusal(folder_ / "a.txt"), "not a surface file by its extension");
  fs::create_directory(folder_ / "folder.off");
  EXPECT_REFUSED(refusal(folder_ / "folder.off"), "is not a regular file");
  // A 3 GiB sparse file takes no disk space and must not take any memory.
  fs::resize_file(write("huge.stl", ""), std::uintmax_t{3} << 30);
  EXPECT_REFUSED(refusal(folder_ / "huge.stl"), "more than the");
  for (const char* extension : {"off", "obj", "ply", "stl", "mesh", "msh", "vtu"}) {
    const std::string name = std::string("empty.") + extension;
    EXPECT_REFUSED(refusal(name, ""), name + ":");
  }
}

// Without them the body would have holes. Faces, edges and points are left out, as before.
TEST_F(MeshFile, RefusesVolumeCellsOfOtherKinds) {
  const auto gmsh = [](const std::string& elements) {
    const std::size_t at = gmsh_text.find("3\n1 2 2"), end = gmsh_text.find("$EndElements");
    return gmsh_text.substr(0, at) + elements + gmsh_text.substr(end);
  };
  const std::string tetrahedron = "1 4 0 10 2 30 4\n";
  expect_two_tets(tets("a.msh", gmsh("6\n" + tetrahedron +
                                     "2 15 0 10\n3 1 0 10 2\n4 2 0 10 2 30\n"
                                     "5 3 0 10 2 30 4\n6 4 0 2 30 4 1000000000000\n")));
  const std::string eight = " 0 10 2 30 4 10 2 30 4\n";
  EXPECT_REFUSED(refusal("a.msh", gmsh("2\n" + tetrahedron + "2 5" + eight)),
                 "1 volume cell is not a tetrahedron of four vertices; split");
  EXPECT_REFUSED(refusal("a.msh", gmsh("4\n" + tetrahedron + "2 5" + eight + "3 6" + eight + "4 7" + eight)),
                 "3 volume cells are not tetrahedra");
  EXPECT_REFUSED(refusal("a.msh", gmsh("1\n1 11 0 10 2 30 4 10 2 30 4 10 2\n")), "gmsh -3 -order 1");

  const auto medit = [](const std::string& section) {
    std::string text = medit_text;
    return text.insert(text.find("Tetrahedra"), section);
  };
  expect_two_tets(tets("a.mesh", medit("Quadrilaterals\n1\n1 2 3 4 0\nHexahedra\n0\n")));
  EXPECT_REFUSED(refusal("a.mesh", medit("Hexahedra\n1\n1 2 3 4 1 2 3 4 0\n")), "1 volume cell is not");
  for (const char* section : {"HexahedraQ2", "PrismsP2", "TetrahedraP3", "PyramidsP2"})
    EXPECT_REFUSED(refusal("a.mesh", medit(std::string(section) + "\n1\n1 2 3 4 0\n")), section);
  expect_two_tets(tets("a.mesh", medit("HexahedraQ2Ordering\n1\n1 2 3\n")));
  EXPECT_REFUSED(refusal("a.mesh", medit("Prisms 2\n1 2 3 4 1 2 0\n1 2 3 4 1 2 0\n")), "(Prisms)");

  const auto vtu = [](const std::string& type) {
    std::string text = vtu_text;
    return text.replace(text.find("10 5 10"), 7, "10 " + type + " 10");
  };
  for (const char* face_or_less : {"1", "3", "5", "7", "9", "22", "28", "69"})
    expect_two_tets(tets("a.vtu", vtu(face_or_less)));
  for (const char* cell : {"11", "12", "13", "14", "24", "42", "71"})
    EXPECT_REFUSED(refusal("a.vtu", vtu(cell)), "1 volume cell is not");
}

// Truncations at every third byte and thousands of random changes of every valid file give a SceneError or a
// mesh that keeps its promises. With sanitizers this also shows that nothing is read out of bounds.
TEST_F(MeshFile, SurvivesDamage) {
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.mesh", medit_text},      {"a.msh", gmsh_text},   {"a.vtu", vtu_text},
      {"n.node", node_text},       {"e.ele", ele_text},    {"a.off", off_text},
      {"a.obj", obj_text},         {"a.ply", ply_text},    {"b.ply", binary_ply(false)},
      {"c.ply", binary_ply(true)}, {"a.stl", ascii_stl()}, {"b.stl", binary_stl()}};
  write("n.ele", ele_text);
  write("e.node", node_text);
  std::mt19937_64 random(seed_of_run(7));
  const std::vector<std::string> splices = {"4294967295",           "-1", "nan", "1e308", "\n", "<",
                                            "18446744073709551615", " "};
  std::size_t read = 0;
  std::size_t refused = 0;
  const auto attempt = [&](const std::string& name, const std::string& content) {
    const fs::path path = write(name, content);
    try {
      std::size_t vertex_count = 0;
      std::uint32_t largest = 0;
      const auto check = [&](const auto& mesh, const auto& elements) {
        ASSERT_FALSE(elements.empty());
        vertex_count = mesh.vertices.size();
        for (const Vector3d& vertex : mesh.vertices) ASSERT_TRUE(vertex.allFinite());
        for (const auto& element : elements) {
          for (const std::uint32_t v : element) largest = std::max(largest, v);
        }
        ASSERT_LT(largest, vertex_count);
      };
      if (mesh::is_tet_mesh_file(path)) {
        const TetMesh mesh = mesh::read_tet_mesh(path);
        check(mesh, mesh.tetrahedra);
      } else {
        const SurfaceMesh mesh = mesh::read_surface_mesh(path);
        check(mesh, mesh.triangles);
      }
      ++read;
    } catch (const SceneError&) {
      ++refused;
    }
  };
  for (const auto& [name, content] : files) {
    for (std::size_t size = 0; size < content.size(); size += 3) attempt(name, content.substr(0, size));
    for (int round = 0; round < 300; ++round) {
      std::string damaged = content;
      for (auto changes = 1 + random() % 3; changes > 0; --changes) {
        const std::size_t at = random() % damaged.size();
        switch (random() % 4) {
          case 0:
            damaged[at] = static_cast<char>(random() % 256);
            break;
          case 1:
            damaged.erase(at, 1 + random() % 8);
            break;
          case 2:
            damaged.insert(at, splices[random() % splices.size()]);
            break;
          default:
            damaged[at] = static_cast<char>('0' + random() % 10);
            break;
        }
        if (damaged.empty()) break;
      }
      attempt(name, damaged);
    }
  }
  // Both outcomes must be common, or the damage is of the wrong kind.
  EXPECT_GT(read, 100U);
  EXPECT_GT(refused, 1000U);
}

}  // namespace
}  // namespace fascicle::tests
