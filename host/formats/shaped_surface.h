// What the blend shapes of a character do to its baked surface. They move the render mesh after it was
// embedded. The flesh does not feel them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "host/gltf/gltf_rig.h"
#include "host/model/model.h"

namespace fascicle::formats {

class ShapedSurface {
 public:
  // Of the bake whose character.glb this is; empty: a body that is no character. Throws BakeError where the
  // file does not fit the model.
  ShapedSurface(const std::filesystem::path& character, const model::Model& model, double fps);

  bool empty() const { return rig_.parts.empty(); }

  // Moves the surface of a frame (3 values a render vertex, working units) by what the shapes' weights at
  // that frame differ from those of the bind pose, turned and scaled by each vertex's skinning. In double,
  // rounded once a vertex; nothing where a vertex is not moved.
  void add_to(std::uint64_t frame, std::span<float> surface) const;

 private:
  gltf::Rig rig_;
  double unit_ = 1.0, fps_ = 1.0;
  bool has_clip_ = false;
};

}  // namespace fascicle::formats
