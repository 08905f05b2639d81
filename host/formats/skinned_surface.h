// A baked character's render mesh by plain skinning, without flesh: the reference that the flesh is compared
// with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"

namespace fascicle::formats {

class SkinnedSurface {
 public:
  // `character`: a bake's character.glb. Throws scene::SceneError if it cannot be read, and BakeError if its
  // vertex count is not the model's.
  SkinnedSurface(const std::filesystem::path& character, const model::Model& model, double fps);

  // World positions in metres, 3 values per render vertex, of a frame 0, 1, ... of the bake.
  std::vector<float> positions(std::uint64_t frame) const;
  const gltf::Rig& rig() const { return rig_; }

 private:
  gltf::Rig rig_;
  bool is_moving_ = false;
  double fps_ = 0.0;
};

}  // namespace fascicle::formats
