// The frame loop. A resumed bake takes the same path as a new one: only the place where each file goes on
// differs.
//
// What makes a bake survive being killed at any moment:
//   1. the manifest is the first file and lists the others, so that they can be told from foreign ones;
//   2. manifest and checkpoint are replaced whole, after everything they count on was synced, the checkpoint
//      last;
//   3. a resumed bake cuts every stream back to the checkpoint's frame, and steps the frames after it again,
//      with the same bits.
#include "host/bake/bake.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <new>
#include <optional>

#include "host/bake/checkpoint.h"
#include "host/bake/checkpoint_pace.h"
#include "host/bake/finite.h"
#include "host/bake/folder.h"
#include "host/bake/frame_writer.h"
#include "host/bake/identity.h"
#include "host/bake/kept_start.h"
#include "host/bake/look.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/stopwatch.h"
#include "host/base/parallel.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "host/drive/muscle_drive.h"
#include "host/formats/blender_script.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/surface.h"
#include "host/formats/surface_objects.h"
#include "host/model/validate.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

namespace {

// What the manifest says of the loop at one frame, while the loop is ahead of it.
struct Moment {
  ClampedMuscles clamped;
  double seconds_solver = 0.0;
};

class Run {
 public:
  Run(const scene::Scene& scene, const model::Model& model, model::Solver& solver, const BakeOptions& options)
      : scene_(scene),
        model_(model),
        solver_(solver),
        options_(checked(options, model)),
        frames_(scene::frame_count(scene)),
        model_hash_(model_hash(model)),
        identity_(identity_of(scene, model_hash_, options_)),
        drives_(scene, model, substeps_of(scene, options)) {}

  BakeResult go();
  // Leaves the reason in the manifest, if it is this run's.
  void note_failure(const std::string& reason) const;

 private:
  void open_folder();
  std::optional<Checkpoint> checkpoint_to_resume();
  std::optional<BakeResult> done_without_frames();
  BakeResult summary() const;
  model::State lead_to_start();
  void begin_sinks(std::uint64_t first);
  std::vector<model::Frame> frames_before(std::uint64_t first) const;
  void step_frames(std::uint64_t first);
  Moment moment() const { return {clamped_, seconds_solver_}; }
  void note_clamped(const model::Drive& drive, std::uint64_t frame);
  [[noreturn]] void refuse_not_finite(const model::Frame& frame);
  void write(const model::Frame& frame);
  void checkpoint(const model::State& state, const Moment& moment);
  bool manifest_due() const;
  void take_look();
  void save_manifest(Status status, const Moment& moment);
  fs::path path_of(const char* name) const { return options_.folder / name; }

  const scene::Scene& scene_;
  const model::Model& model_;
  model::Solver& solver_;
  const BakeOptions options_;
  const std::uint64_t frames_;
  const std::uint64_t model_hash_;
  const Identity identity_;
  drive::DriveSource drives_;

  std::optional<FolderLock> lock_;
  model::Frame initial_;
  std::optional<formats::ShapedSurface> shapes_;
  std::vector<std::unique_ptr<formats::FrameSink>> sinks_;
  model::Read needs_;
  std::array<std::vector<float>, 2> skinned_;  // of the last two frames written; empty where nobody looks
  Progress progress_;
  ClampedMuscles clamped_;
  Timings before_;  // of earlier runs
  double seconds_solver_ = 0.0, seconds_writing_ = 0.0;
  std::atomic<double> seconds_to_sync_ = 0.0;  // of the last checkpoint
  std::size_t frames_in_manifest_ = 0;
  bool interrupted_ = false;
  bool has_begun_ = false;  // from here on the manifest in the folder is this run's
  formats::SinkReport report_;
  std::vector<std::string> missing_images_;
  const Clock::time_point start_ = Clock::now();
};

void Run::open_folder() {
  make_folder(options_.folder);
  lock_.emplace(options_.folder);
  const bool used = holds_bake(options_.folder);
  if (used && options_.overwrite) clear_bake(options_.folder);
  if (used && !options_.overwrite && !options_.resume)
    throw FolderInUse(
        options_.folder.string() +
        ": holds a bake; --resume goes on with it, --overwrite starts again, or choose another -o");
}

// Nothing if the bake starts at frame 0.
std::optional<Checkpoint> Run::checkpoint_to_resume() {
  if (!options_.resume || !holds_bake(options_.folder)) return std::nullopt;
  std::optional<Checkpoint> found = read_checkpoint(path_of(checkpoint_name));
  if (!found) {
    // Stopped before its first checkpoint: nothing is lost by starting again.
    clear_bake(options_.folder);
    return std::nullopt;
  }
  if (const std::string text = differences(found->identity, identity_); !text.empty())
    throw BakeError(options_.folder.string() + ": cannot be resumed, because this bake would differ: " +
                    text + "; set it back, start again with --overwrite, or choose another -o");
  check_checkpoint(*found, model_, frames_, path_of(checkpoint_name));
  if (const auto manifest = read_manifest(options_.folder)) {
    before_ = manifest->timings;
    progress_.lead_in = manifest->lead_in;
    clamped_ = progress_.clamped = manifest->clamped;
    ++before_.runs;
  }
  return found;
}

// A bake that has come to its end and kept no frames cannot be gone on with, and need not.
std::optional<BakeResult> Run::done_without_frames() {
  const std::optional<ManifestSummary> manifest = read_manifest(options_.folder);
  if (!manifest || manifest->frames_kept) return std::nullopt;
  if (options_.keep_frames) throw BakeError(frames_not_kept_text(options_.folder));
  remove_files(options_.folder, {cache_name});
  BakeResult result = summary();
  result.frames_done = frames_;
  result.last_position_hash = manifest->last_position_hash;
  return result;
}

BakeResult Run::go() {
  open_folder();
  const std::optional<Checkpoint> resumed = checkpoint_to_resume();
  if (resumed)
    if (std::optional<BakeResult> done = done_without_frames()) return std::move(*done);
  if (!resumed) {
    refuse_foreign(options_.folder, file_names(model_, options_.formats));
    save_manifest(Status::running, moment());
  } else {
    set_status(options_.folder, Status::running, "");
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
  if (!interrupted_) {
    begin_sinks(resumed ? state.frame + 1 : 0);
    solver_.load(state);
    if (!resumed) {
      if (!all_finite(initial_)) refuse_not_finite(initial_);
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
  // The manifest no longer points at them.
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

// The state of frame 0.
model::State Run::lead_to_start() {
  const Stopwatch time(seconds_solver_);
  const bool is_long = drives_.preroll_frames() > 0 || scene_.motion.settle > 0.0 || scene_.motion.seamless;
  const std::string key = is_long ? start_key(identity_) : "";
  if (is_long && options_.find_start)
    if (const std::optional<std::string> bytes = options_.find_start(key))
      if (std::optional<drive::LeadIn> kept = read_start(*bytes, identity_)) {
        progress_.lead_in = kept->summary;
        progress_.lead_in.was_kept = true;
        return std::move(kept->state);
      }
  drive::LeadIn led = drive::lead_in(scene_, model_, drives_, solver_, [&] {
    if (options_.on_lead_in) options_.on_lead_in();
    return options_.interrupted != nullptr && options_.interrupted->load();
  });
  if (is_long && !led.stopped && options_.keep_start) options_.keep_start(key, start_bytes(led, identity_));
  interrupted_ = led.stopped;
  progress_.lead_in = led.summary;
  return std::move(led.state);
}

// Up to two frames before this one, with positions and skinned, where a look is taken.
std::vector<model::Frame> Run::frames_before(std::uint64_t first) const {
  std::vector<model::Frame> frames;
  if (first == 0 || !has_look(model_)) return frames;
  const FrameCacheReader cache(path_of(cache_name));
  for (std::uint64_t k = first - std::min<std::uint64_t>(first, 2); k < first; ++k) {
    frames.push_back(cache.read(k));
    frames.back().skinned = skinned_[2 - (first - k)];
  }
  return frames;
}

void Run::begin_sinks(std::uint64_t first) {
  const Stopwatch time(seconds_writing_);
  const std::vector<model::Frame> before = frames_before(first);
  const auto* character = std::get_if<rig::Character>(&scene_.geometry);
  const bool is_character = character != nullptr && model_.has_skeleton();
  if (is_character && (first == 0 || !fs::exists(path_of(formats::character_name))))
    base::write_whole(path_of(formats::character_name),
                      formats::character_glb(
                          scene_, model_, [this](std::uint64_t frame) { return drives_.joints(frame); },
                          [this](std::uint64_t frame) { return drives_.clip_time(frame); }, missing_images_));
  shapes_.emplace(is_character ? path_of(formats::character_name) : fs::path(), model_, scene_.fps);
  std::shared_ptr<const formats::SurfaceObjects> surface;
  if (model_.surface_count() > 0)
    surface = std::make_shared<const formats::SurfaceObjects>(
        formats::read_surface_objects(model_, is_character ? path_of(formats::character_name) : fs::path()));
  const formats::BakeInfo info{.model = &model_,
                               .folder = options_.folder,
                               .scene_name = scene_.name,
                               .fps = scene_.fps,
                               .start = scene_.start,
                               .frames = frames_,
                               .first = first,
                               .initial = &initial_,
                               .character = is_character ? path_of(formats::character_name) : fs::path(),
                               .rig = is_character ? character : nullptr,
                               .before = before,
                               .glb = options_.glb,
                               .objects = surface,
                               .first_number = number_of_first(scene_, options_),
                               .usd_skel = options_.usd_skel};
  needs_ = {.positions = true};  // for the hash, whatever the sinks want
  for (const formats::Format& format : all_formats()) {
    const bool wanted = format.name.empty() || std::find(options_.formats.begin(), options_.formats.end(),
                                                         format.name) != options_.formats.end();
    if (!wanted) continue;
    sinks_.push_back(format.file == metrics_name ? make_metrics_sink(options_.look_body) : format.make());
    needs_ = needs_ | sinks_.back()->needs();
    formats::BakeInfo of_sink = info;
    if (!sinks_.back()->resumes()) of_sink.first = 0;
    sinks_.back()->begin(of_sink);
  }
  base::write_whole(path_of(model_file_name), encode_model(model_));
  if (model_.surface_count() > 0) {
    formats::write_rest_mesh(options_.folder, model_, *surface);
    base::write_whole(
        path_of(formats::blender_script_name),
        formats::blender_script(
            {.fps = scene_.fps, .frames = frames_, .first_number = number_of_first(scene_, options_)}));
  }
  if (first == 0) return;
  // The cache is the witness of the frames that are kept: reading them also checks them.
  const FrameCacheReader cache(path_of(cache_name));
  for (std::uint64_t k = 0; k < first; ++k) {
    model::Frame frame = cache.read(k);
    progress_.position_hashes.push_back(model::position_hash(frame));
    frame.surface = formats::embed(model_, frame.positions);
    shapes_->add_to(k, frame.surface);
    for (const auto& sink : sinks_)
      if (!sink->resumes()) sink->write(frame);
  }
}

// Frames are stepped while those before are written. Where a checkpoint is due no further frame may be in
// flight while the solver's state is taken. What is due then is done after that frame's writing, beside the
// solver.
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
  const auto stopped = [&] { return options_.interrupted != nullptr && options_.interrupted->load(); };
  if (stopped()) {
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
    interrupted_ = k < frames_ && stopped();
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
    if (!all_finite(frame)) {
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
    writer.finish();  // what was simulated before is kept; its own failure is the one that counts
    throw;
  }
}

void Run::note_clamped(const model::Drive& drive, std::uint64_t frame) {
  if (model_.muscle_count == 0) return;
  const std::uint64_t regions = drive::clamped_regions(model_, drive.muscles.last(model_.muscle_count));
  if (regions > clamped_.regions) clamped_ = {regions, frame};
}

// All frames before are written.
void Run::refuse_not_finite(const model::Frame& frame) {
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
  // The manifest first: it may know more than the checkpoint, whose frames are then stepped again.
  const bool is_worse = moment.clamped.regions > progress_.clamped.regions;
  if (is_worse || manifest_due()) save_manifest(Status::running, moment);
  write_checkpoint(path_of(checkpoint_name), {identity_, state, skinned_});
  seconds_to_sync_ = seconds_since(start);
}

// It has a line for each frame: written whole at every checkpoint, a long bake's would take longer and
// longer.
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
        // Skinned on the host, where the last bits may differ from the solver's: the words are the same.
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
    // What went wrong first is what the caller has to hear.
  }
}

}  // namespace

BakeResult bake(const scene::Scene& scene, const model::Model& model, model::Solver& solver,
                const BakeOptions& options) {
  Run run(scene, model, solver, options);
  try {
    return run.go();
  } catch (const NotFinite&) {
    throw;  // the manifest says so already
  } catch (const std::bad_alloc&) {
    run.note_failure("out of memory");
    throw;
  } catch (const std::exception& error) {
    run.note_failure(error.what());
    throw;
  }
}

}  // namespace fascicle::bake
