#include <algorithm>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/build/byte_archive.h"
#include "host/build/filled_body.h"
#include "host/build/mesher_replies.h"
#include "host/build/report_fields.h"
#include "host/build/wrap.h"
#include "host/mesh/mesh_readers.h"
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

mesh::SurfaceMesh tetrahedron() {
  mesh::SurfaceMesh surface;
  surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return surface;
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

bool filling(std::string_view bytes) {
  static const mesh::SurfaceMesh surface = tetrahedron();
  return is_taken<base::SceneError>([&] {
    mesh::TetMesh mesh = mesh::read_medit("volume.mesh", bytes);
    build::check_filling(mesh, surface);
  });
}

bool findings(std::string_view bytes) {
  static const std::size_t vertices = tetrahedron().vertices.size();
  return is_taken<base::SceneError>([&] { build::parse_findings(std::string(bytes), vertices); });
}

bool wrap(std::string_view bytes) {
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  return is_taken<base::SceneError>([&] {
    (void)build::parse_wrap_lengths(std::string(bytes.substr(0, end)));
    mesh::SurfaceMesh surface = mesh::read_off("wrap.off", bytes.substr(std::min(end + 1, bytes.size())));
    build::drop_inner_shells(surface);
    for (const auto& t : surface.triangles)
      for (const std::uint32_t v : t)
        if (v >= surface.vertices.size()) throw std::logic_error("a triangle of a vertex that was dropped");
  });
}

}  // namespace fascicle::fuzz
