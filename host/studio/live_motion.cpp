#include "host/studio/live_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/bake/finite.h"
#include "host/drive/lead_in.h"
#include "host/formats/surface.h"
#include "host/model/validate.h"

namespace fascicle::studio {

namespace {

constexpr model::Read what_is_shown{.positions = true, .velocities = true, .skinned = true};
// Limit on the states kept along the clip, from which any frame can be recomputed.
constexpr double most_kept_bytes = 192.0 * 1024 * 1024;
// Default radius of the hand: a fraction of the body's extent, and at least this many edges.
constexpr double hand_share = 0.05, hand_edges = 2.5;

double bytes_of(const model::State& state) {
  return static_cast<double>(sizeof(float) *
                             (state.positions.size() + state.velocities.size() + state.rotations.size() +
                              state.skinned.size() + state.skinned_velocities.size() +
                              state.positions_before.size() + state.velocities_before.size()));
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

LiveMotion::LiveMotion(std::shared_ptr<RunningBody> body)
    : body_(std::move(body)), measures_(body_->model()) {
  load(body_->drives().initial_state(), 0);
}

void LiveMotion::show_state(const model::State& state) {
  now_ = {.index = frame_,
          .origin = state.origin,
          .positions = state.positions,
          .velocities = state.velocities,
          .surface = {},
          .skinned = state.skinned};
  seconds_ = 0.0f;
}

void LiveMotion::load(const model::State& state, std::uint64_t frame) {
  with_device([&] { solver().load(state); });
  has_failed_ = false;
  begin_at(state, frame);
}

void LiveMotion::begin_at(const model::State& state, std::uint64_t frame) {
  frame_ = frame;
  show_state(state);
  // Keep every frame's state, or fewer if that takes too much memory.
  const double all = bytes_of(state) * static_cast<double>(frames() + 1);
  kept_every_ = static_cast<std::uint64_t>(std::max(1.0, std::ceil(all / most_kept_bytes)));
}

void LiveMotion::keep_state() {
  if (hand_ || frame_ % kept_every_ != 0) return;
  kept_[frame_] = body_->solver().save();
}

void LiveMotion::step_to(std::uint64_t frame) {
  model::Drive drive = body_->drives().drive(frame);
  std::vector<shader::Force> forces;
  if (hand_) {
    forces = hand_->forces(drive, body_->model().force_count);
    drive.forces = forces;
  }
  const auto start = std::chrono::steady_clock::now();
  with_device([&] {
    solver().submit(drive, what_is_shown);
    now_ = solver().collect();
  });
  seconds_ = static_cast<float>(seconds_since(start));
  frame_ = frame;
  now_.index = frame;
  if (!bake::is_in_reach(now_, body_->model().unit)) {
    release();
    load(body_->state_on_skeleton(frame), frame);
    kept_.clear();
    throw Diverged("the simulation became unstable in frame " + std::to_string(frame) +
                   " and was reset; undo the last change, or use more substeps");
  }
  if (hand_) hand_->see(now_, 1.0 / fps());
}

ShownFrame LiveMotion::shown(std::uint32_t flags) {
  ShownFrame shown{.model = &body_->model(), .frame = &now_, .numbers = {}};
  FrameNumbers& numbers = shown.numbers;
  numbers.revision = body_->revision();
  numbers.frame = static_cast<std::uint32_t>(frame_);
  numbers.flags = flags | (hand_ ? frame_is_pulled : 0u);
  numbers.time = body_->frame_time(frame_);
  numbers.position_hash = model::position_hash(now_);
  numbers.seconds = seconds_;
  measures_.fill(now_, numbers);
  return shown;
}

ShownFrame LiveMotion::again() {
  return shown(0);
}

ShownFrame LiveMotion::advance() {
  if (frames() == 0) return shown(0);
  if (frame_ >= frames()) {
    with_device([&] { solver().load(body_->drives().begun_again(solver().save())); });
    frame_ = 0;
  }
  step_to(frame_ + 1);
  keep_state();
  return shown(0);
}

ShownFrame LiveMotion::seek(std::uint64_t frame) {
  const std::uint64_t wanted = std::min(frame, frames());
  const auto after = kept_.upper_bound(wanted);
  const bool is_near = after != kept_.begin() && wanted - std::prev(after)->first < kept_every_;
  if (is_near)
    load(std::prev(after)->second, std::prev(after)->first);
  else
    load(body_->state_on_skeleton(wanted), wanted);
  while (frame_ < wanted) step_to(frame_ + 1);
  return shown(frame_begins);
}

// The lead-in before frame 0 may diverge as well.
void LiveMotion::load_led(model::State state) {
  load(state, 0);
  kept_.clear();
  if (bake::is_in_reach(now_, body_->model().unit)) return;
  load(body_->drives().initial_state(), 0);
  throw Diverged(
      "the simulation became unstable before frame 0 and was reset; undo the last change, or use more "
      "substeps");
}

ShownFrame LiveMotion::restart(const std::function<bool()>& stop) {
  // Looped playback already runs the extra cycles that a seamless loop needs.
  scene::Scene lead = body_->scene();
  lead.motion.seamless = false;
  drive::LeadIn led = with_device(
      [&] { return drive::lead_in(lead, body_->model(), body_->drives(), body_->solver(), stop); });
  load_led(led.stopped ? body_->drives().initial_state() : std::move(led.state));
  keep_state();
  return shown(frame_begins);
}

model::State LiveMotion::state_for(RunningBody& next, std::uint64_t frame) {
  if (!has_failed_) try {
      return carried_over(solver().save(), *body_, next, frame);
    } catch (const gpu::DeviceError&) {
    }
  const auto kept = kept_.find(frame_);
  return kept == kept_.end() ? next.state_on_skeleton(frame)
                             : carried_over(kept->second, *body_, next, frame);
}

ShownFrame LiveMotion::take(std::shared_ptr<RunningBody> body) {
  const std::uint64_t frame = std::min(frame_, body->frames());
  const model::State next = state_for(*body, frame);
  // Do everything that may throw before changing any member.
  std::unique_ptr<HeldSolver> held;
  if (hand_ && has_same_shape(body_->model(), body->model())) try {
      held = hold(*body, hand_->held());
    } catch (const pipeline::NoSuchDevice&) {
    }
  (held ? *held->solver : body->solver()).load(next);
  FrameMeasures measures(body->model());
  held_ = std::move(held);
  if (!held_) hand_.reset();
  body_ = std::move(body);
  measures_ = std::move(measures);
  has_failed_ = false;
  kept_.clear();
  begin_at(next, frame);
  return shown(frame_begins);
}

std::unique_ptr<LiveMotion::HeldSolver> LiveMotion::hold(const RunningBody& body, const Held& held) {
  auto made = std::make_unique<HeldSolver>(HeldSolver{with_hand(body.model(), held), nullptr});
  made->solver = body.solver_of(made->model);
  return made;
}

std::size_t LiveMotion::grab(std::uint32_t vertex, double radius, const Vector3d& place) {
  const model::Model& model = body_->model();
  const double fits =
      std::max(hand_share * model::extent(model), hand_edges * body_->built().report.mean_edge);
  Held held = held_around(model, vertex, radius > 0.0 ? radius : fits);
  if (held.empty()) {
    release();
    return 0;
  }
  const model::State state = solver().save();
  std::unique_ptr<HeldSolver> made = hold(*body_, held);
  made->solver->load(state);
  held_ = std::move(made);
  hand_.emplace(model, std::move(held), now_, place);
  return hand_->held().size();
}

void LiveMotion::release() {
  // Lets go even if the device fails.
  const std::unique_ptr<HeldSolver> held = std::move(held_);
  hand_.reset();
  if (held) with_device([&] { body_->solver().load(held->solver->save()); });
}

Recording LiveMotion::record(const std::function<bool()>& stop,
                             const std::function<void(const ShownFrame&)>& show) {
  const auto start = std::chrono::steady_clock::now();
  release();
  Recording recording;
  recording.revision = body_->revision();
  drive::LeadIn led = with_device(
      [&] { return drive::lead_in(body_->scene(), body_->model(), body_->drives(), body_->solver(), stop); });
  recording.stopped = led.stopped;
  load_led(led.stopped ? body_->drives().initial_state() : std::move(led.state));
  const auto take_note = [&] {
    keep_state();
    const ShownFrame frame = shown(frame_is_recorded | (frame_ == 0 ? frame_begins : 0u));
    recording.hashes.push_back(frame.numbers.position_hash);
    show(frame);
  };
  if (!recording.stopped) take_note();
  while (!recording.stopped && frame_ < frames()) {
    recording.stopped = stop();
    if (recording.stopped) break;
    step_to(frame_ + 1);
    take_note();
  }
  recording.seconds = seconds_since(start);
  return recording;
}

}  // namespace fascicle::studio
