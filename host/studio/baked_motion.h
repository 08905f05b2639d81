// The frames of a bake's folder, as they were written.
#pragma once

#include <filesystem>
#include <memory>

#include "host/pipeline/open_bake.h"
#include "host/studio/frame_measures.h"
#include "host/studio/motion.h"

namespace fascicle::studio {

class BakedMotion final : public Motion {
 public:
  // `bake` is the player's from now on. Skinning alone is shown where the bake's scene can still be read.
  explicit BakedMotion(std::unique_ptr<pipeline::OpenBake> bake);

  std::uint64_t frames() const override { return bake_->frame_count() - 1; }
  double fps() const override { return bake_->fps(); }
  std::uint64_t frame() const override { return now_.index; }
  ShownFrame advance() override { return seek(now_.index < frames() ? now_.index + 1 : 0); }
  ShownFrame seek(std::uint64_t frame) override;
  ShownFrame restart(const std::function<bool()>&) override { return seek(0); }
  ShownFrame again() override;
  std::vector<float> joints() override;

 private:
  std::unique_ptr<pipeline::OpenBake> bake_;
  FrameMeasures measures_;
  bool has_scene_ = false;
  model::Frame now_;
};

}  // namespace fascicle::studio
