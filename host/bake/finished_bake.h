// The folder of a complete bake, opened for reading its frames. Nothing in it is trusted: model and frames
// are checked against their hashes, and the character against the model.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "host/formats/shaped_surface.h"
#include "host/model/model.h"

namespace fascicle::bake {

class FinishedBake {
 public:
  // Throws BakeError if there is no bake, or an unfinished one, or one without frames. Also throws as
  // read_kept does: call the constructor and frame() inside read_kept.
  explicit FinishedBake(const std::filesystem::path& folder);

  const ManifestSummary& manifest() const { return manifest_; }
  const CacheHeader& header() const { return cache_.header(); }
  const model::Model& model() const { return model_; }
  // character.glb; empty for bodies that are not characters.
  const std::filesystem::path& character() const { return character_; }
  std::uint64_t frame_count() const { return cache_.header().frames + 1; }
  // With positions, and the surface with its blend shapes. Throws BakeError if it is damaged.
  model::Frame frame(std::uint64_t k) const;

 private:
  const std::filesystem::path folder_;
  const ManifestSummary manifest_;
  const FrameCacheReader cache_;
  const model::Model model_;
  const std::filesystem::path character_;
  const formats::ShapedSurface shapes_;
};

// Calls `read`, which must read no scene, glTF or JSON except what the bake kept in `folder`: exceptions of
// those readers become BakeErrors that say so.
void read_kept(const std::filesystem::path& folder, const std::function<void()>& read);

}  // namespace fascicle::bake
