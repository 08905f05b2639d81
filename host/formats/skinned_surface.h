// The render mesh of a baked character as its own skinning has it, without flesh: what the flesh is held
// against.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"

namespace fascicle::formats {

class SkinnedSurface {
 public:
  // `character`: the character.glb of a bake. Throws scene::SceneError where it cannot be read and BakeError
  // where it has not the model's render vertices.
  SkinnedSurface(const std::filesystem::path& character, const model::Model& model, double fps);

  // Metres in the world, 3 values a render vertex, of frame 0, 1, ... of the bake.
  std::vector<float> positions(std::uint64_t frame) const;
  const gltf::Rig& rig() const { return rig_; }

 private:
  gltf::Rig rig_;
  bool is_moving_ = false;
  double fps_ = 0.0;
};

}  // namespace fascicle::formats
