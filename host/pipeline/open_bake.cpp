#include "host/pipeline/open_bake.h"

#include <cmath>
#include <map>
#include <span>
#include <stdexcept>
#include <utility>

#include "host/bake/bake.h"
#include "host/bake/model_file.h"
#include "host/build/steps.h"
#include "host/model/solver.h"
#include "host/scene/scene_file.h"

namespace fascicle::pipeline {
namespace {

namespace fs = std::filesystem;

bake::FrameCacheReader cache_of(const fs::path& folder, const bake::ManifestSummary& manifest) {
  if (!manifest.frames_kept) throw bake::BakeError(bake::frames_not_kept_text(folder));
  const fs::path path = folder / bake::cache_name;
  bake::FrameCacheReader cache(path);
  if (cache.frame_count() == 0) throw bake::BakeError(path.string() + ": has no complete frame yet");
  return cache;
}

}  // namespace

OpenBake::OpenBake(const fs::path& folder)
    : folder_(folder),
      manifest_(bake::manifest_of(folder)),
      cache_(cache_of(folder, manifest_)),
      model_(bake::read_model_of_frames(folder, cache_.header())) {}

const scene::Scene& OpenBake::scene() {
  if (scene_) return *scene_;
  const fs::path source(manifest_.scene_source);
  // File names in a scene file are relative to it; a bare mesh or character is relative to the folder in
  // which the bake was started.
  const fs::path near = source.extension() == ".toml" ? source.parent_path() : fs::path();
  std::unique_ptr<const scene::Scene> read;
  try {
    read = std::make_unique<const scene::Scene>(
        scene::parse_scene({manifest_.scene_name, manifest_.scene_source, manifest_.scene_text, near}, {}));
  } catch (const scene::SceneError& error) {
    throw scene::SceneError(folder_.string() + ": cannot read the bake's scene again: " + error.what() +
                            "; start fascicle from the folder where the bake was started");
  }
  build::Report report;
  substeps_ = build::choose_steps(*read, model_, report).substeps;
  // The scene's own text is in the manifest, but files that it refers to may have changed.
  const std::map<std::string, std::string> before(manifest_.input_hashes.begin(),
                                                  manifest_.input_hashes.end());
  for (const auto& [file, hash] : read->input_hashes)
    if (const auto was = before.find(file); was == before.end() || was->second != hash)
      throw bake::BakeError(file + ": has changed since the bake in " + folder_.string() +
                            "; bake again, or put the old file back");
  scene_ = std::move(read);
  return *scene_;
}

drive::DriveSource& OpenBake::drives() {
  if (!drives_) {
    const scene::Scene& of_bake = scene();
    try {
      drives_.emplace(of_bake, model_, substeps_);
    } catch (const std::invalid_argument& error) {
      throw DifferentBakes(folder_.string() + ": its model and its scene are of different bakes (" +
                           error.what() + "); bake again");
    }
  }
  return *drives_;
}

std::vector<scene::Solid> OpenBake::solids(std::uint64_t k) {
  if (!model_.has_colliders()) return {};
  return drives().solids(k);
}

OpenBake::Skinned OpenBake::skinned(std::uint64_t k) {
  if (!model_.has_skeleton()) return {model_.rest, model_.rest_origin};
  model::State state;
  if (k == 0) {
    state = drives().initial_state();
  } else {
    const model::Drive drive = drives().drive(k);
    state = model::initial_state(model_, drive.bones.last(model_.joint_count), drive.origin);
  }
  return {std::move(state.positions), state.origin};
}

std::vector<float> OpenBake::lag(const model::Frame& frame) {
  const auto [skinned, origin] = this->skinned(frame.index);
  std::vector<float> lag(model_.vertex_count);
  for (std::size_t i = 0; i < lag.size(); ++i) {
    double square = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double d = (frame.origin[c] - origin[c]) +
                       model_.unit * (double{frame.positions[3 * i + c]} - double{skinned[3 * i + c]});
      square += d * d;
    }
    lag[i] = static_cast<float>(std::sqrt(square));
  }
  return lag;
}

}  // namespace fascicle::pipeline
