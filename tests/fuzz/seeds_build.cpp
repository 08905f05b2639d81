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
}

}  // namespace fascicle::fuzz
