// Applies a character's blend shapes to its baked surface. They move the render mesh after embedding; the
// flesh does not feel them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"

namespace fascicle::formats {

class ShapedSurface {
 public:
  // `character`: the bake's character.glb; empty: a body that is not a character. Throws BakeError if the
  // file does not match the model.
  ShapedSurface(const std::filesystem::path& character, const model::Model& model, double fps);

  bool empty() const { return rig_.parts.empty(); }

  // Moves a frame's surface (3 values per render vertex, working units) by the difference between the shapes
  // at that frame's weights and at the bind pose's, transformed by each vertex's skinning. Computed in
  // double, rounded once per vertex; unmoved vertices keep their bits.
  void add_to(std::uint64_t frame, std::span<float> surface) const;

 private:
  gltf::Rig rig_;
  double unit_ = 1.0, fps_ = 1.0;
  bool has_clip_ = false;
};

}  // namespace fascicle::formats
