#include "host/base/file.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {
namespace {

const std::string ply_header_end =
    " 1.0\ncomment four corners\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "property uchar red\nelement face 4\nproperty list uchar int vertex_indices\nproperty float quality\n"
    "end_header\n";

constexpr float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr std::int32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

std::string binary_ply() {
  std::string bytes = "ply\nformat binary_little_endian" + ply_header_end;
  for (const auto& corner : corners) {
    base::append_bytes(bytes, corner);
    bytes += '\7';
  }
  for (const auto& face : faces) {
    bytes += '\3';
    base::append_bytes(bytes, face);
    base::append_bytes(bytes, 1.0f);
  }
  return bytes;
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  base::append_bytes(bytes, std::uint32_t{4});
  for (const auto& face : faces) {
    base::append_bytes(bytes, corners[0]);
    for (const std::int32_t corner : face) base::append_bytes(bytes, corners[corner]);
    base::append_bytes(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ascii_stl() {
  std::string text = "solid four corners\n";
  const std::string places[4] = {"0 0 0", "1 0 0", "0 1e0 0", "0 0 1."};
  for (const auto& face : faces) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const std::int32_t corner : face) text += "vertex " + places[corner] + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

}  // namespace

void add_mesh_seeds(std::vector<Seed>& seeds) {
  seeds.push_back(
      {"medit", "two",
       "MeshVersionFormatted 2\n# a comment\nDimension 3\nVertices 5\n0 0 0 1\n+1 0 0 1\n0 1e0 0 1\n"
       "0 0 1.0 1\n1 1 1.5 1\nTriangles 1\n1 2 3 7\nTetrahedra 2\n1 2 3 4 0\n2 3 4 5 0\nEnd\n"});
  seeds.push_back(
      {"tetgen", "two",
       std::string("# nodes\n5 3 1 1\n1 0 0 0 9.5 0\n2 1 0 0 9 0\n3 0 1 0 9 0\n4 0 0 1 9 0\n5 1 1 1.5 9 "
                   "0\n") +
           '\0' + "2 4 1\n1 1 2 3 4 1\n2 2 3 4 5 1 # the end\n"});
  seeds.push_back(
      {"gmsh", "two",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a body\"\n$EndPhysicalNames\n"
       "$Nodes\n5\n10 0 0 0\n2 1 0 0\n30 0 1 0\n4 0 0 1\n1000000000000 1 1 1.5\n$EndNodes\n$Elements\n3\n"
       "1 2 2 0 1 10 2 30\n2 4 2 0 1 10 2 30 4\n3 4 0 2 30 4 1000000000000\n$EndElements\n"});
  seeds.push_back(
      {"vtu", "two",
       "<?xml version=\"1.0\"?>\n<!-- a comment -->\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\">\n"
       "<UnstructuredGrid>\n<Piece NumberOfPoints='5' NumberOfCells='2'>\n<Points>"
       "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n"
       "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1.5</DataArray></Points>\n<Cells>\n"
       "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 10</DataArray>\n"
       "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3\n1 2 3 4\n</DataArray>\n"
       "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 8</DataArray>\n</Cells>\n</Piece>\n"
       "</UnstructuredGrid>\n</VTKFile>\n"});
  seeds.push_back({"off", "pyramid",
                   "OFF 5 5 0\n0 0 0\n1 0 0 # a corner\n1 1 0 0.5 0.5 0.5\n0 1 0\n.5 5e-1 0.75\n4 3 2 1 0\n"
                   "3 0 1 4 255 0 0\n3 1 2 4\n3 2 3 4\n3 3 0 4\n"});
  seeds.push_back(
      {"obj", "pyramid",
       "# a pyramid\nmtllib a.mtl\no pyramid\nv 0 0 0\nv 1 0 0 1\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.75\n"
       "vn 0 0 1\ns off\nf 4/1/1 3/2/1 2/3/1 \\\n 1/4/1\nf 1//1 2//1 -1//1\nf 2/1 3/2 5/3\nf -3 -2 -1\n"
       "f 4 1 5\n"});
  seeds.push_back({"ply", "ascii",
                   "ply\nformat ascii" + ply_header_end +
                       "0 0 0 1\n1 0 0 2\n0 1 0 3\n0 0 1 4\n3 0 2 1 nan\n3 0 1 3 1\n3 1 2 3 1\n3 2 0 3 1\n"});
  seeds.push_back({"ply", "binary", binary_ply()});
  seeds.push_back({"stl", "ascii", ascii_stl()});
  seeds.push_back({"stl", "binary", binary_stl()});
}

}  // namespace fascicle::fuzz
