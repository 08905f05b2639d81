// The source of pictures: the frames of a bake, or a scene's rest pose.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/cli/log.h"
#include "host/cli/render_arguments.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/skinned_surface.h"
#include "host/model/model.h"
#include "host/pipeline/open_bake.h"
#include "host/render/looks.h"
#include "host/scene/scene.h"
#include "host/scene/solids.h"

namespace fascicle::cli {

class DrawnFrames {
 public:
  // Throws bake::BakeError, scene::SceneError.
  DrawnFrames(const RenderArguments& arguments, Log& log);

  const model::Model& model() const { return bake_ ? bake_->model() : built_; }
  bool is_bake() const { return bake_.has_value(); }
  std::uint64_t count() const { return bake_ ? bake_->frame_count() : 1; }
  // s of the clip, as in metrics.csv.
  double time(std::uint64_t k) const {
    return bake_ ? bake_->start() + static_cast<double>(k) / bake_->fps() : 0.0;
  }

  // The flesh: the model's vertices, metres, 3 floats per vertex.
  std::vector<float> positions(std::uint64_t k) const;
  // The render mesh that the flesh carries, with the file's blend shapes in that frame, metres, 3 floats per
  // vertex. Warns, once, if the shapes cannot be read.
  std::vector<float> surface(std::uint64_t k);
  // For a bake, in metres, 3 floats per vertex: the skinned vertices of the model and of the render mesh.
  // Without a skeleton, both are at rest.
  std::vector<float> skinned_vertices(std::uint64_t k);
  std::vector<float> skinned_surface(std::uint64_t k);
  // Distance in metres from the skinned vertices, one per vertex; 0 in the rest pose.
  std::vector<float> lag(std::uint64_t k);

  // The scene's solids, in metres.
  std::vector<scene::Solid> solids(std::uint64_t k);

  // The file's materials; nullopt if there is no file or it has none. Logs what could not be read.
  std::optional<render::Looks> looks(Log& log) const;

 private:
  void read_shapes();

  Log& log_;
  std::filesystem::path folder_, character_;  // a bake's folder; the glTF file, empty if none
  std::optional<OpenBake> bake_;
  std::optional<formats::SkinnedSurface> skin_;
  std::optional<formats::ShapedSurface> shapes_;
  bool has_read_shapes_ = false;
  model::Model built_;
  std::vector<scene::Solid> built_solids_;
};

}  // namespace fascicle::cli
