// Live simulation: a body that plays its clip in a loop and can be changed and pulled meanwhile.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>

#include "host/pipeline/device_choice.h"
#include "host/studio/frame_measures.h"
#include "host/studio/hand.h"
#include "host/studio/motion.h"
#include "host/studio/running_body.h"

namespace fascicle::studio {

// The result of a recorded run.
struct Recording {
  std::vector<std::uint64_t> hashes;  // of frames 0, 1, ..., as in a bake's manifest
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
  // Exact if the frame, or one shortly before it, was computed with the current keys; otherwise the flesh is
  // placed there by the skeleton.
  ShownFrame seek(std::uint64_t frame) override;
  ShownFrame restart(const std::function<bool()>& stop) override;
  ShownFrame again() override;
  std::vector<float> joints() override { return body_->joint_places(frame_); }
  std::vector<scene::Solid> solids() override { return body_->solids(frame_); }

  RunningBody& body() { return *body_; }
  // Continues with another body, carrying the state over. If this body's device has failed, from the state
  // that was kept of this frame, or else on the skeleton. Lets go of the flesh if the device has no memory
  // for the hand's solver.
  ShownFrame take(std::shared_ptr<RunningBody> body);

  // Returns the number of vertices that the hand holds; 0 if all flesh there is kinematic. `vertex`: of the
  // model. `radius` (m, at rest): 0 for the default.
  std::size_t grab(std::uint32_t vertex, double radius, const Vector3d& place);
  Hand* hand() { return hand_ ? &*hand_ : nullptr; }
  void release();

  // Plays all frames from the start, exactly as a bake does, and shows each. Calls `stop` before each.
  Recording record(const std::function<bool()>& stop, const std::function<void(const ShownFrame&)>& show);

 private:
  // The body's solver with the hand's force added to the scene's. The solver refers to the model, so it must
  // not move.
  struct HeldSolver {
    model::Model model;
    std::unique_ptr<model::Solver> solver;
  };
  static std::unique_ptr<HeldSolver> hold(const RunningBody& body, const Held& held);

  model::Solver& solver() { return held_ ? *held_->solver : body_->solver(); }
  void load(const model::State& state, std::uint64_t frame);
  void begin_at(const model::State& state, std::uint64_t frame);
  model::State state_for(RunningBody& next, std::uint64_t frame);
  void load_led(model::State state);
  void step_to(std::uint64_t frame);
  void keep_state();
  ShownFrame shown(std::uint32_t flags);
  void show_state(const model::State& state);

  std::shared_ptr<RunningBody> body_;
  FrameMeasures measures_;
  std::uint64_t frame_ = 0;
  model::Frame now_;
  float seconds_ = 0.0f;  // the solver's time for it

  // States along the clip, by frame, computed with the current keys and without the hand.
  std::map<std::uint64_t, model::State> kept_;
  std::uint64_t kept_every_ = 1;

  std::unique_ptr<HeldSolver> held_;
  std::optional<Hand> hand_;
  bool has_failed_ = false;  // the device did, so the solver's state is undefined

  // Notes failures of the device.
  template <class Work>
  auto with_device(Work work) {
    try {
      return work();
    } catch (const gpu::DeviceError&) {
      has_failed_ = true;
      throw;
    }
  }
};

}  // namespace fascicle::studio
