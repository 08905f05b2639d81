// A bake's folder, finished or still running, opened for viewing.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/errors.h"
#include "host/drive/drive_source.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::pipeline {

// The manifest's scene is not the one that the folder's model was built from.
struct DifferentBakes : base::BakeError {
  using BakeError::BakeError;
};

// The model and the frames are in the folder; the scene is read again only if its clip is needed.
class OpenBake {
 public:
  // Throws bake::BakeError with what is missing and what to do.
  explicit OpenBake(const std::filesystem::path& folder);

  const model::Model& model() const { return model_; }
  const bake::ManifestSummary& manifest() const { return manifest_; }
  double fps() const { return cache_.header().fps; }
  double start() const { return cache_.header().start; }
  // Number of whole frames, from frame 0; for a running bake, when it was opened.
  std::uint64_t frame_count() const { return cache_.frame_count(); }
  model::Frame frame(std::uint64_t k) const { return cache_.read(k); }

  // The scene as it was baked. Throws bake::BakeError if an input has changed since, scene::SceneError if one
  // is gone.
  const scene::Scene& scene();
  // Positions by skinning alone (without a skeleton: the rest pose) in a frame.
  struct Skinned {
    std::vector<float> positions;  // working units from the origin, 3 per vertex
    std::array<double, 3> origin;  // m
  };
  Skinned skinned(std::uint64_t k);
  // Each joint's map from its own space to the world, metres of the file; empty without a skeleton.
  std::vector<Eigen::Matrix4d> joints(std::uint64_t k) { return drives().joints(k); }
  // The scene's solids in a frame, metres.
  std::vector<scene::Solid> solids(std::uint64_t k);
  // Distance between each vertex and its skinned position, m.
  std::vector<float> lag(const model::Frame& frame);

 private:
  drive::DriveSource& drives();

  std::filesystem::path folder_;
  bake::ManifestSummary manifest_;
  bake::FrameCacheReader cache_;
  model::Model model_;
  std::unique_ptr<const scene::Scene> scene_;
  std::uint32_t substeps_ = 0;  // per frame; set when the scene is read
  std::optional<drive::DriveSource> drives_;
};

}  // namespace fascicle::pipeline
