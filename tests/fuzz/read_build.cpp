#include "host/build/byte_archive.h"
#include "host/build/filled_body.h"
#include "host/build/report_fields.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {
namespace {

// Reads an entry of each array per end, as the manifest's writer does (pipeline::open_ends_of).
void use(const build::OpenEnds& ends) {
  volatile double sum = 0.0;
  for (std::size_t k = 0; k < ends.vertex.size(); ++k)
    sum = sum + ends.edges[k] + ends.joint[k] + ends.width[k] + ends.fate[k];
}

}  // namespace

bool body(std::string_view bytes) {
  rig::Character character;
  character.skeleton.resize(2);
  mesh::SurfaceMesh surface;
  surface.vertices.resize(3);
  surface.triangles = {{0, 1, 2}};
  build::FilledBody found;
  build::Report report;
  if (!build::read_filled_body(bytes, {{}, surface, {}, {}, &character}, found, report)) return false;
  use(report.fill.cage.ends);
  return true;
}

bool report(std::string_view bytes) {
  return is_taken<build::ByteReader::Damaged>([&] {
    build::Report found;
    build::ByteReader read(bytes);
    read(found);
  });
}

}  // namespace fascicle::fuzz
