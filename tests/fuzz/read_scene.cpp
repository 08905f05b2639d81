#include "host/base/errors.h"
#include "host/rig/paint.h"
#include "host/scene/input_files.h"
#include "host/scene/jobs.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene_file.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/painted_surface.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"
#include "tests/gltf/gltf_builder.h"

namespace fascicle::fuzz {

bool scene(std::string_view bytes) {
  // A mesh and a character that scene files can refer to.
  static const OneFile beside("tetrahedron.off");
  static const bool is_written = [] {
    beside.write("OFF 4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
    const std::vector<unsigned char> glb = tests::column().glb();
    beside.write_beside("column.glb", {reinterpret_cast<const char*>(glb.data()), glb.size()});
    return true;
  }();
  (void)is_written;
  return is_taken<base::SceneError>([&] {
    fascicle::scene::parse_scene({"a", "a.toml", std::string(bytes), beside.folder()}, {});
  });
}

bool set(std::string_view bytes) {
  const std::string of =
      "[bar]\nsize = [0.5, 0.25, 0.125]\nvertices = [5, 4, 3]\n[layers.fat]\nalpha = 0.5\n"
      "[pin.end]\nwhere = { below = { axis = \"x\", value = 0.01 } }\n";
  return is_taken<base::SceneError>([&] {
    fascicle::scene::parse_scene({"a", "a.toml", of, {}}, {.set = {std::string(bytes)}});
  });
}

bool jobs(std::string_view bytes) {
  static const OneFile file("a.toml");
  file.write(bytes);
  return is_taken<base::SceneError>([&] { fascicle::scene::read_jobs(file.path()); });
}

bool paint(std::string_view bytes) {
  static const mesh::SurfaceMesh surface = painted_surface();
  return is_taken<fascicle::scene::InputFileError>(
      [&] { fascicle::scene::parse_paint(bytes, "a.paint.json", surface); });
}

}  // namespace fascicle::fuzz
