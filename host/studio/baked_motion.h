// The frames of a finished bake, as stored in its folder.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host/pipeline/open_bake.h"
#include "host/studio/frame_measures.h"
#include "host/studio/motion.h"

namespace fascicle::studio {

class BakedMotion final : public Motion {
 public:
  // Takes over `bake`; `folder` is its folder. Shows plain skinning and solids, and measures lag, if the
  // bake's scene can still be read.
  BakedMotion(std::unique_ptr<pipeline::OpenBake> bake, const std::filesystem::path& folder);

  std::uint64_t frames() const override { return bake_->frame_count() - 1; }
  double fps() const override { return bake_->fps(); }
  double start() const override { return bake_->start(); }
  std::uint64_t frame() const override { return now_.index; }
  ShownFrame advance() override { return seek(now_.index < frames() ? now_.index + 1 : 0); }
  ShownFrame seek(std::uint64_t frame) override;
  ShownFrame restart(const std::function<bool()>&) override { return seek(0); }
  ShownFrame again() override;
  std::vector<float> joints() override;
  std::vector<scene::Solid> solids() override;
  // Why frames have no lag although the body has a skeleton; empty if they have.
  const std::string& why_no_lag() const { return why_no_lag_; }

 private:
  std::unique_ptr<pipeline::OpenBake> bake_;
  FrameMeasures measures_;
  std::vector<float> energies_;  // J, per frame, from metrics.csv, because a bake stores no velocities
  bool has_scene_ = false, has_skinning_ = false;
  std::string why_no_lag_;
  model::Frame now_;
};

}  // namespace fascicle::studio
