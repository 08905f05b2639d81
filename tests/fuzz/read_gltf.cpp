#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_file.h"
#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool gltf(std::string_view bytes) {
  static const OneFile file("a.glb");
  file.write(bytes);
  // What each of them reads first. Most fuzzed files are refused here.
  if (!is_taken<base::SceneError>([&] { fascicle::gltf::read_gltf_file(file.path()); })) return false;
  const bool is_character = is_taken<base::SceneError>(
      [&] { fascicle::gltf::read_gltf(file.path(), nullptr, {}, fascicle::gltf::Still::carried); });
  // Also of a file that is no character: a page reads the rig of a bake's character.glb on its own.
  const bool is_rig = is_taken<base::SceneError>([&] {
    const fascicle::gltf::Rig rig = fascicle::gltf::read_rig(file.path(), {}, fascicle::gltf::Still::carried);
    fascicle::gltf::read_looks(file.path(), rig);
  });
  const bool is_document = is_taken<base::SceneError>([&] {
    std::vector<std::string> missing;
    fascicle::gltf::pack_gltf(file.path(), missing);
  });
  return is_character && is_rig && is_document;
}

}  // namespace fascicle::fuzz
