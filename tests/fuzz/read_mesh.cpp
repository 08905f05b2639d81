#include "host/base/errors.h"
#include "host/mesh/mesh_readers.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

using base::SceneError;

bool medit(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_medit("a.mesh", bytes); });
}
bool tetgen(std::string_view bytes) {
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  const std::string_view elements = bytes.substr(std::min(end + 1, bytes.size()));
  return is_taken<SceneError>([&] { mesh::read_tetgen("a.node", bytes.substr(0, end), "a.ele", elements); });
}
bool gmsh(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_gmsh("a.msh", bytes); });
}
bool vtu(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_vtu("a.vtu", bytes); });
}
bool off(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_off("a.off", bytes); });
}
bool obj(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_obj("a.obj", bytes); });
}
bool ply(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_ply("a.ply", bytes); });
}
bool stl(std::string_view bytes) {
  return is_taken<SceneError>([&] { mesh::read_stl("a.stl", bytes); });
}

}  // namespace fascicle::fuzz
