// The folder of a bake that is whole, read for what is made of its frames. Nothing in it is trusted: the
// model and the frames are held against their hashes, the character against the model.
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
  // Throws BakeError where there is no bake, an unfinished one or one that keeps no frames, and as
  // read_kept does; call both within it.
  explicit FinishedBake(const std::filesystem::path& folder);

  const ManifestSummary& manifest() const { return manifest_; }
  const CacheHeader& header() const { return cache_.header(); }
  const model::Model& model() const { return model_; }
  // character.glb; empty for bodies that are no characters.
  const std::filesystem::path& character() const { return character_; }
  std::uint64_t frame_count() const { return cache_.header().frames + 1; }
  // With positions, and with the surface where blend shapes put it. Throws BakeError where it is damaged.
  model::Frame frame(std::uint64_t k) const;

 private:
  const ManifestSummary manifest_;
  const FrameCacheReader cache_;
  const model::Model model_;
  const std::filesystem::path character_;
  const formats::ShapedSurface shapes_;
};

// Calls `read`, which reads no other scene, glTF or JSON than what the bake in `folder` kept: what those
// readers throw becomes a BakeError that says so.
void read_kept(const std::filesystem::path& folder, const std::function<void()>& read);

}  // namespace fascicle::bake
