#include "host/build/byte_archive.h"
#include "host/build/filled_body.h"
#include "host/build/report_fields.h"
#include "tests/fuzz/seeds.h"

namespace fascicle::fuzz {

void add_build_seeds(std::vector<Seed>& seeds) {
  build::FilledBody body;
  body.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  body.mesh.tetrahedra = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  body.skin.offset = {0, 1, 2, 3, 4, 6};
  body.skin.joint = {0, 0, 1, 1, 0, 1};
  body.skin.weight = {1, 1, 1, 1, 0.5, 0.5};
  body.render.corners = {{0, 1, 2, 3}, {4, 4, 4, 4}, {1, 1, 1, 1}};
  body.render.weights = {{0.25, 0.25, 0.25, 0.25}, {1, 0, 0, 0}, {1, 0, 0, 0}};
  build::Report report;
  report.warnings = {{"a warning", {3, 4}}};
  report.fill.cage.ends = {
      .vertex = {0, 2}, .edges = {3, 4}, .joint = {1, -1}, .width = {0.5, 0.25}, .fate = {0, 1}};
  seeds.push_back({"body", "two", build::filled_body_bytes(body, report)});
  report.joints.resize(2);
  report.layers.resize(1);
  std::string bytes;
  build::ByteWriter write(bytes);
  write(report);
  seeds.push_back({"report", "two", bytes});
  const std::string header = "MeshVersionFormatted 2\nDimension 3\n";
  const std::string corners = "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  seeds.push_back({"filling", "one", header + "Vertices\n4\n" + corners + "Tetrahedra\n1\n1 2 3 4 0\nEnd\n"});
  seeds.push_back({"filling", "inner",
                   header + "Vertices\n5\n" + corners +
                       "0.2 0.2 0.2 0\nTetrahedra\n4\n5 2 3 4 0\n1 5 3 4 0\n1 2 5 4 0\n1 2 3 5 0\nEnd\n"});
  seeds.push_back({"findings", "open",
                   "parts 1 0\nloose_vertices 0\nflat_triangles 0\nopen_edges 2 0 1 1 2\n"
                   "non_manifold_edges 0\nnon_manifold_vertices 0\nturned_edges 0\ninverted_parts 0\n"
                   "intersections 0\ngenus 0\nend\n"});
  const std::string lengths("alpha 0.02 offset 0.001\0", 24);
  const std::string outer = "0 0 0\n9 0 0\n0 9 0\n0 0 9\n", inner = "1 1 1\n2 1 1\n1 2 1\n1 1 2\n";
  seeds.push_back({"wrap", "shells",
                   lengths + "OFF\n8 8 0\n" + outer + inner +
                       "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 4 6 5\n3 4 5 7\n3 5 6 7\n3 4 7 6\n"});
}

}  // namespace fascicle::fuzz
