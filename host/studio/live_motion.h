// Flesh in motion: a body that runs through its clip again and again, can be changed while it does, and
// pulled.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>

#include "host/studio/frame_measures.h"
#include "host/studio/hand.h"
#include "host/studio/motion.h"
#include "host/studio/running_body.h"

namespace fascicle::studio {

// What a recorded run found.
struct Recording {
  std::vector<std::uint64_t> hashes;  // of frames 0, 1, ..., as a bake's manifest has them
  std::uint32_t revision = 0;
  bool stopped = false;
  double seconds = 0.0;
};

class LiveMotion final : public Motion {
 public:
  explicit LiveMotion(std::shared_ptr<RunningBody> body);

  std::uint64_t frames() const override { return body_->frames(); }
  double fps() const override { return body_->scene().fps; }
  double start() const override { return body_->scene().start; }
  std::uint64_t frame() const override { return frame_; }
  ShownFrame advance() override;
  // Exact where the frame, or one shortly before it, was computed with the keys in force; else the flesh is
  // carried along by the skeleton to there.
  ShownFrame seek(std::uint64_t frame) override;
  ShownFrame restart(const std::function<bool()>& stop) override;
  ShownFrame again() override;
  std::vector<float> joints() override { return body_->joint_places(frame_); }
  std::vector<scene::Solid> solids() override { return body_->solids(frame_); }

  RunningBody& body() { return *body_; }
  // The same flesh goes on as another body.
  ShownFrame take(std::shared_ptr<RunningBody> body);

  // How many vertices the hand holds; 0 where all flesh there follows the skeleton. `vertex`: of the model.
  // `radius` (m, at rest) 0: one that fits.
  std::size_t grab(std::uint32_t vertex, double radius, const Vector3d& place);
  Hand* hand() { return hand_ ? &*hand_ : nullptr; }
  void release();

  // Plays from the start as a bake does, all of its frames, and shows each. `stop` is asked before each.
  Recording record(const std::function<bool()>& stop, const std::function<void(const ShownFrame&)>& show);

 private:
  // The body's solver with the hand's force beside the scene's. The model stands still while the solver
  // lives.
  struct HeldSolver {
    model::Model model;
    std::unique_ptr<model::Solver> solver;
  };
  static std::unique_ptr<HeldSolver> hold(const RunningBody& body, const Held& held);

  model::Solver& solver() { return held_ ? *held_->solver : body_->solver(); }
  void load(const model::State& state, std::uint64_t frame);
  void load_led(model::State state);
  void step_to(std::uint64_t frame);
  void keep_state();
  ShownFrame shown(std::uint32_t flags);
  void show_state(const model::State& state);

  std::shared_ptr<RunningBody> body_;
  FrameMeasures measures_;
  std::uint64_t frame_ = 0;
  model::Frame now_;
  float seconds_ = 0.0f;  // that the solver took for it

  // States along the clip, by frame, computed with the keys in force while no hand pulled.
  std::map<std::uint64_t, model::State> kept_;
  std::uint64_t kept_every_ = 1;

  std::unique_ptr<HeldSolver> held_;
  std::optional<Hand> hand_;
};

}  // namespace fascicle::studio
