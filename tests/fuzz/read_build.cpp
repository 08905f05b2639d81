#include "host/build/byte_archive.h"
#include "host/build/filled_body.h"
#include "host/build/report_fields.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool body(std::string_view bytes) {
  rig::Character character;
  character.skeleton.resize(2);
  mesh::SurfaceMesh surface;
  surface.vertices.resize(3);
  surface.triangles = {{0, 1, 2}};
  build::FilledBody found;
  build::Report report;
  return build::read_filled_body(bytes, {{}, surface, {}, {}, &character}, found, report);
}

bool report(std::string_view bytes) {
  return is_taken<build::ByteReader::Damaged>([&] {
    build::Report found;
    build::ByteReader read(bytes);
    read(found);
  });
}

}  // namespace fascicle::fuzz
