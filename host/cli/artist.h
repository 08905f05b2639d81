// One camera and one drawing style for all pictures of a bake.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/cli/drawn_frames.h"
#include "host/cli/log.h"
#include "host/cli/render_arguments.h"
#include "host/model/overlap.h"
#include "host/model/surroundings.h"
#include "host/render/annotate.h"
#include "host/render/body_shapes.h"
#include "host/render/image.h"
#include "host/render/model_surface.h"
#include "host/render/render.h"

namespace fascicle::cli {

// Pixels, or columns and rows.
struct Size {
  unsigned width = 0, height = 0;
};

// Parses "1280x720". Throws UsageError, also for a side above `most`.
Size size_of(const std::string& text, const std::string& option, unsigned most);

class Artist {
 public:
  // `shown`: the frames that must fit the view; empty: all. `height`: pixels, if --size is not given.
  // `arguments` and `frames` must outlive it. Throws UsageError.
  Artist(const RenderArguments& arguments, DrawnFrames& frames, std::span<const std::uint64_t> shown,
         unsigned height, Log& log);

  const render::BodyDrawing& drawing() const { return *drawing_; }
  const render::Legend& legend() const { return legend_; }
  // Whether the camera follows the body although nobody asked for it: the whole path would show it at less
  // than a fifth of the size.
  bool follows_by_itself() const { return follows_by_itself_; }
  // Empty if the scene's solids are drawn.
  const std::string& why_no_solids() const { return why_no_solids_; }

  render::Image picture(std::uint64_t k) const;
  // The same view of skinning alone.
  render::Image skinned_picture(std::uint64_t k) const;

 private:
  Eigen::Vector3d way_at(std::uint64_t k) const;
  render::Image draw(std::uint64_t k, std::span<const float> positions, std::span<const float> lag,
                     std::span<const float> surface) const;

  const RenderArguments& arguments_;
  DrawnFrames& frames_;
  std::vector<render::Shape> solids_at(std::uint64_t k, const Eigen::Vector3d& way,
                                       const Eigen::Vector3d& eye) const;

  // m, per vertex; negative outside other flesh.
  std::vector<float> contact_depths(std::span<const float> positions) const;

  std::optional<model::OverlapMeter> overlap_;  // Mode::contact
  std::optional<render::Looks> looks_;
  std::optional<render::BodyDrawing> drawing_;
  model::Surroundings surroundings_;
  render::Legend legend_;
  render::Camera camera_;
  bool follows_ = false, follows_by_itself_ = false;
  // Centre of the view's content before the camera follows the body, and its reach.
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double reach_ = 0.0;
  render::Backdrop backdrop_;
  std::string why_no_solids_;
};

}  // namespace fascicle::cli
