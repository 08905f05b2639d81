// The frame loop. A resumed bake takes the same path as a new one; only the position at which each file
// continues differs.
//
// What makes a bake survive being killed at any moment:
//   1. the manifest is the first file and lists the others, so that they can be told from foreign ones;
//   2. manifest and checkpoint are replaced atomically, after everything they refer to was synced, the
//      checkpoint last;
//   3. a resumed bake truncates every stream to the checkpoint's frame and simulates later frames again, with
//      the same bits.
#include "host/bake/bake.h"

#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

#include "host/bake/checkpoint_pace.h"
#include "host/bake/finite.h"
#include "host/bake/frame_writer.h"
#include "host/bake/look.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/run.h"
#include "host/base/parallel.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/drive/muscle_drive.h"
#include "host/formats/surface.h"
#include "host/model/validate.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

BakeResult Run::go() {
  open_folder();
  const std::optional<Checkpoint> resumed = checkpoint_to_resume();
  if (resumed) {
    if (std::optional<BakeResult> done = done_without_frames()) return std::move(*done);
    if (std::optional<BakeResult> done = done_before(*resumed)) return std::move(*done);
    if (!check_kept(resumed->state.frame)) {
      interrupted_ = true;
      progress_.position_hashes.clear();
      BakeResult result = summary();
      result.frames_done = resumed->state.frame;
      return result;
    }
  }
  if (!resumed) {
    refuse_foreign(options_.folder, file_names(model_, options_.formats));
    has_begun_ = true;
    save_manifest(Status::running, moment());
  } else if (files_change_) {
    begin_other_files(*resumed);
  } else {
    set_running_from(options_.folder, resumed->state.frame);
  }
  has_begun_ = true;
  model::State state;
  if (resumed) {
    state = resumed->state;
    skinned_ = resumed->skinned;
    initial_ = FrameCacheReader(path_of(cache_name)).read(0);
  } else {
    state = lead_to_start();
    initial_ = {.index = 0,
                .origin = state.origin,
                .positions = state.positions,
                .velocities = state.velocities,
                .surface = formats::embed(model_, state.positions),
                .skinned = state.skinned};
  }
  if (!interrupted_ && !begin_sinks(resumed ? &*resumed : nullptr)) {
    set_status(options_.folder, Status::interrupted, "");
    interrupted_ = true;
    progress_.position_hashes.clear();
    BakeResult result = summary();
    result.frames_done = state.frame;
    return result;
  }
  if (!interrupted_) {
    solver_.load(state);
    if (files_change_) checkpoint(state, moment());
    if (!resumed) {
      if (!is_in_reach(initial_, model_.unit)) refuse_not_finite(initial_);
      shapes_->add_to(0, initial_.surface);
      write(initial_);
      checkpoint(state, moment());
    }
    step_frames(state.frame + 1);
  }
  if (!interrupted_ && scene_.motion.seamless) {
    const model::State next = drives_.begun_again(solver_.save());
    progress_.loop_jump = drive::largest_distance(model_, initial_.positions, initial_.origin, next);
  }
  if (!interrupted_) {
    const Stopwatch time(seconds_writing_);
    base::for_each_in_parallel(sinks_.size(), sinks_.size(),
                               [this](std::size_t k, std::size_t) { sinks_[k]->finish(); });
    for (const auto& sink : sinks_) formats::append(report_, sink->report());
  }
  if (!interrupted_) take_look();
  progress_.frames_kept = interrupted_ || options_.keep_frames;
  save_manifest(interrupted_ ? Status::interrupted : Status::complete, moment());
  // The manifest no longer lists them.
  if (!progress_.frames_kept) remove_files(options_.folder, {cache_name});
  return summary();
}

BakeResult Run::summary() const {
  BakeResult result;
  result.frames_done = progress_.position_hashes.empty() ? 0 : progress_.position_hashes.size() - 1;
  result.lead_in = progress_.lead_in;
  result.loop_jump = progress_.loop_jump;
  result.look = progress_.look;
  result.clamped = progress_.clamped;
  result.report = report_;
  result.interrupted = interrupted_;
  result.missing_images = missing_images_;
  for (const std::string& name : file_names(model_, options_.formats))
    if (fs::exists(options_.folder / name)) result.files.push_back(options_.folder / name);
  if (!progress_.position_hashes.empty())
    result.last_position_hash = base::hash_text(progress_.position_hashes.back());
  result.seconds_solver = seconds_solver_;
  result.seconds_writing = seconds_writing_;
  result.seconds_total = seconds_since(start_);
  return result;
}

// Frames are simulated while earlier ones are written. If a checkpoint is due, no further frame may be in
// flight while the solver's state is saved. The checkpoint itself is written after its frame, while the
// solver continues.
void Run::step_frames(std::uint64_t first) {
  if (first > frames_) return;
  const auto submit = [&](std::uint64_t frame) {
    const model::Drive drive = [&] {
      const Stopwatch time(seconds_solver_);
      return drives_.drive(frame);
    }();
    note_clamped(drive, frame);
    const Stopwatch time(seconds_solver_);
    solver_.submit(drive, needs_);
  };
  if (was_stopped()) {
    interrupted_ = true;
    return;
  }
  CheckpointPace pace(frames_, options_.checkpoint_frames, options_.checkpoint_seconds,
                      seconds_since(start_));
  FrameWriter writer([this](model::Frame& frame) {
    if (!frame.surface.empty()) shapes_->add_to(frame.index, frame.surface);
    write(frame);
  });
  const auto step = [&](std::uint64_t k) {
    interrupted_ = k < frames_ && was_stopped();
    const bool due = interrupted_ || pace.is_due(k, seconds_since(start_), seconds_to_sync_);
    if (!due) submit(k + 1);
    model::Frame frame;
    {
      const Stopwatch time(seconds_solver_);
      frame = solver_.collect();
    }
    if (frame.index != k)
      throw std::logic_error("the solver returned frame " + base::number_text(frame.index) + " for frame " +
                             base::number_text(k));
    if (!is_in_reach(frame, model_.unit)) {
      writer.finish();
      refuse_not_finite(frame);
    }
    std::function<void()> then;
    if (due) {
      then = [this, state = solver_.save(), at = moment()] { checkpoint(state, at); };
      pace.is_taken(seconds_since(start_));
      if (!interrupted_ && k < frames_) submit(k + 1);
    }
    writer.put(std::move(frame), std::move(then));
    pace.frame_has_ended(seconds_since(start_));
    if (interrupted_ || k == frames_) writer.finish();
    if (options_.on_frame) options_.on_frame(k, frames_);
  };
  try {
    submit(first);
    for (std::uint64_t k = first; k <= frames_ && !interrupted_; ++k) step(k);
  } catch (...) {
    writer.finish();  // keeps earlier frames; if this throws, that failure is the one to report
    throw;
  }
}

void Run::note_clamped(const model::Drive& drive, std::uint64_t frame) {
  if (model_.muscle_count == 0) return;
  const std::uint64_t regions = drive::clamped_regions(model_, drive.muscles.last(model_.muscle_count));
  if (regions > clamped_.regions) clamped_ = {regions, frame};
}

// All earlier frames have been written. The manifest counts them, so they are synced first.
void Run::refuse_not_finite(const model::Frame& frame) {
  for (const auto& sink : sinks_) sink->sync();
  progress_.message = not_finite_text(scene_, model_, frame);
  save_manifest(Status::not_finite, moment());
  throw NotFinite(progress_.message);
}

void Run::write(const model::Frame& frame) {
  const Stopwatch time(seconds_writing_);
  for (const auto& sink : sinks_) sink->write(frame);
  if (has_look(model_)) {
    skinned_[0] = std::move(skinned_[1]);
    skinned_[1] = frame.skinned;
  }
  progress_.position_hashes.push_back(model::position_hash(frame));
}

void Run::checkpoint(const model::State& state, const Moment& moment) {
  const Stopwatch time(seconds_writing_);
  const Clock::time_point start = Clock::now();
  base::for_each_in_parallel(sinks_.size(), sinks_.size(),
                             [this](std::size_t k, std::size_t) { sinks_[k]->sync(); });
  // The manifest first: if it counts more frames than the checkpoint, they are simulated again.
  const bool is_worse = moment.clamped.regions > progress_.clamped.regions;
  if (is_worse || manifest_due()) save_manifest(Status::running, moment);
  write_checkpoint(path_of(checkpoint_name), {identity_, state, skinned_});
  seconds_to_sync_ = seconds_since(start);
}

// The manifest has a line per frame: written at every checkpoint, it would slow down long bakes more and
// more.
bool Run::manifest_due() const {
  constexpr std::size_t share = 64;
  const std::size_t frames = progress_.position_hashes.size();
  return frames - frames_in_manifest_ > frames / share;
}

void Run::take_look() {
  const Stopwatch time(seconds_writing_);
  const FrameCacheReader cache(path_of(cache_name));
  progress_.look = look_summary(
      options_.folder, model_, std::get_if<rig::Character>(&scene_.geometry), scene_.fps,
      [&](std::uint64_t k) {
        // Skinned on the host, where the last bits may differ from the solver's, but not the text.
        model::Frame frame = cache.read(k);
        frame.skinned = k == 0 ? drives_.initial_state().skinned : [&] {
          const model::Drive drive = drives_.drive(k);
          return model::initial_state(model_, drive.bones.last(model_.joint_count), drive.origin).skinned;
        }();
        return frame;
      });
}

void Run::save_manifest(Status status, const Moment& moment) {
  progress_.status = status;
  progress_.clamped = moment.clamped;
  progress_.timings = {.solver = before_.solver + moment.seconds_solver,
                       .writing = before_.writing + seconds_writing_,
                       .total = before_.total + seconds_since(start_),
                       .runs = before_.runs};
  base::write_whole(path_of(manifest_name), manifest_text(scene_, model_, options_, model_hash_, progress_));
  frames_in_manifest_ = progress_.position_hashes.size();
}

void Run::note_failure(const std::string& reason) const {
  if (!has_begun_) return;
  try {
    set_status(options_.folder, Status::failed, reason);
  } catch (const std::exception&) {
    // The first failure is the one to report.
  }
}

BakeResult bake(const scene::Scene& scene, const model::Model& model, model::Solver& solver,
                const BakeOptions& options) {
  Run run(scene, model, solver, options);
  try {
    return run.go();
  } catch (const NotFinite&) {
    throw;  // the manifest already says so
  } catch (const std::bad_alloc&) {
    run.note_failure("out of memory");
    throw;
  } catch (const std::exception& error) {
    run.note_failure(error.what());
    throw;
  }
}

}  // namespace fascicle::bake
