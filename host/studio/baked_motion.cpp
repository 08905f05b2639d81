#include "host/studio/baked_motion.h"

#include <algorithm>
#include <utility>

#include "host/base/errors.h"
#include "host/model/validate.h"
#include "host/scene/scene.h"

namespace fascicle::studio {

BakedMotion::BakedMotion(std::unique_ptr<pipeline::OpenBake> bake)
    : bake_(std::move(bake)), measures_(bake_->model()) {
  try {
    (void)bake_->scene();
    has_scene_ = bake_->model().has_skeleton();
  } catch (const scene::SceneError&) {
    // Its inputs are gone or have changed: the frames are there all the same.
  } catch (const base::BakeError&) {
  }
  seek(0);
}

ShownFrame BakedMotion::seek(std::uint64_t frame) {
  now_ = bake_->frame(std::min(frame, frames()));
  if (has_scene_) {
    pipeline::OpenBake::Skinned skinned = bake_->skinned(now_.index);
    // Seen from the frame's own origin.
    for (std::size_t k = 0; k < skinned.positions.size(); ++k)
      skinned.positions[k] +=
          static_cast<float>((skinned.origin[k % 3] - now_.origin[k % 3]) / bake_->model().unit);
    now_.skinned = std::move(skinned.positions);
  }
  return again();
}

ShownFrame BakedMotion::again() {
  ShownFrame shown{.model = &bake_->model(), .frame = &now_, .numbers = {}};
  shown.numbers.frame = static_cast<std::uint32_t>(now_.index);
  shown.numbers.time = bake_->start() + static_cast<double>(now_.index) / bake_->fps();
  shown.numbers.position_hash = model::position_hash(now_);
  measures_.fill(now_, shown.numbers);
  return shown;
}

std::vector<float> BakedMotion::joints() {
  std::vector<float> places;
  if (!has_scene_) return places;
  const double scale = bake_->scene().scale;
  for (const Eigen::Matrix4d& map : bake_->joints(now_.index))
    for (int a = 0; a < 3; ++a) places.push_back(static_cast<float>(scale * map(a, 3)));
  return places;
}

}  // namespace fascicle::studio
