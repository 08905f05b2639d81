#include "host/base/errors.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_looks.h"
#include "host/gltf/gltf_rig.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool gltf(std::string_view bytes) {
  static const OneFile file("a.glb");
  file.write(bytes);
  return is_taken<base::SceneError>([&] {
    fascicle::gltf::read_gltf(file.path(), nullptr, {}, fascicle::gltf::Still::carried);
    const fascicle::gltf::Rig rig = fascicle::gltf::read_rig(file.path(), {}, fascicle::gltf::Still::carried);
    fascicle::gltf::read_looks(file.path(), rig);
    std::vector<std::string> missing;
    fascicle::gltf::pack_gltf(file.path(), missing);
  });
}

}  // namespace fascicle::fuzz
