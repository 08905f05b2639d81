// The frame loop. A resumed bake takes the same path as a new one: only the place where each file goes on
// differs.
//
// What makes a bake survive being killed at any moment:
//   1. the manifest is the first file and lists the others, so that they can be told from foreign ones;
//   2. a checkpoint is replaced whole, after everything it counts on was synced;
//   3. a resumed bake cuts every stream back to the checkpoint's frame, and steps the frames after it again,
//   with the same
//      bits.
#include "host/bake/bake.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <memory>
#include <new>
#include <optional>

#include "host/bake/checkpoint.h"
#include "host/bake/folder.h"
#include "host/bake/frame_writer.h"
#include "host/bake/identity.h"
#include "host/bake/kept_start.h"
#include "host/bake/look.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
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

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Adds the time between its construction and its destruction.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds), start_(Clock::now()) {}
  ~Stopwatch() { seconds_ += seconds_since(start_); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  Clock::time_point start_;
};

bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7f800000u) != 0x7f800000u;
}

bool all_finite(const model::Frame& frame) {
  return std::all_of(frame.positions.begin(), frame.positions.end(), is_finite);
}

// The options with each format once, in the order of format_names().
BakeOptions checked(BakeOptions options, const model::Model& model) {
  if (options.overwrite && options.resume)
    throw BakeError("--overwrite and --resume exclude each other; give one");
  if (options.checkpoint_frames == 0) throw BakeError("checkpoint_frames is 0; it must be at least 1");
  std::vector<std::string> formats, left = formats::with_companions(options.formats, model);
  std::string names;
  for (const std::string& name : format_names()) {
    names += (names.empty() ? "" : ", ") + name;
    if (std::erase(left, name) > 0) formats.push_back(name);
  }
  if (!left.empty())
    throw BakeError("--format " + left.front() + ": there is no such format; there are " + names);
  options.formats = std::move(formats);
  return options;
}

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
  model::State lead_to_start();
  void begin_sinks(std::uint64_t first);
  std::vector<model::Frame> frames_before(std::uint64_t first) const;
  void step_frames(std::uint64_t first);
  bool checkpoint_due(std::uint64_t frame) const;
  void note_clamped(const model::Drive& drive, std::uint64_t frame);
  [[noreturn]] void refuse_not_finite(const model::Frame& frame);
  void write(const model::Frame& frame);
  void checkpoint(const model::State& state);
  void take_look();
  void save_manifest(Status status);
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
  Timings before_;  // of earlier runs
  double seconds_solver_ = 0.0, seconds_writing_ = 0.0;
  bool interrupted_ = false;
  bool has_begun_ = false;  // from here on the manifest in the folder is this run's
  formats::SinkReport report_;
  std::vector<std::string> missing_images_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point last_checkpoint_ = Clock::now();
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
  if (const auto manifest = read_manifest(options_.folder)) {
    before_ = manifest->timings;
    progress_.lead_in = manifest->lead_in;
    progress_.clamped = manifest->clamped;
    ++before_.runs;
  }
  return found;
}

BakeResult Run::go() {
  open_folder();
  const std::optional<Checkpoint> resumed = checkpoint_to_resume();
  const std::vector<std::string> files = file_names(model_, options_.formats);
  if (!resumed) {
    refuse_foreign(options_.folder, files);
    save_manifest(Status::running);
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
      checkpoint(state);
    }
    step_frames(state.frame + 1);
  }
  if (!interrupted_ && scene_.motion.seamless) {
    const model::State next = drives_.begun_again(solver_.save());
    progress_.loop_jump = drive::largest_distance(model_, initial_.positions, initial_.origin, next);
  }
  if (!interrupted_)
    for (const auto& sink : sinks_) {
      const Stopwatch time(seconds_writing_);
      sink->finish();
      formats::append(report_, sink->report());
    }
  if (!interrupted_) take_look();
  save_manifest(interrupted_ ? Status::interrupted : Status::complete);

  BakeResult result;
  result.frames_done = progress_.position_hashes.empty() ? 0 : progress_.position_hashes.size() - 1;
  result.lead_in = progress_.lead_in;
  result.loop_jump = progress_.loop_jump;
  result.look = progress_.look;
  result.clamped = progress_.clamped;
  result.report = report_;
  result.interrupted = interrupted_;
  result.missing_images = missing_images_;
  for (const std::string& name : files)
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
// flight, because the solver's state is that after the last frame submitted, and all before must be written.
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
  FrameWriter writer([this](model::Frame& frame) {
    if (!frame.surface.empty()) shapes_->add_to(frame.index, frame.surface);
    write(frame);
  });
  submit(first);
  for (std::uint64_t k = first; k <= frames_; ++k) {
    interrupted_ = k < frames_ && stopped();
    const bool drain = interrupted_ || checkpoint_due(k);
    if (!drain) submit(k + 1);
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
    writer.put(std::move(frame));
    if (drain) writer.finish();
    if (options_.on_frame) options_.on_frame(k, frames_);
    if (!drain) continue;
    checkpoint(solver_.save());
    if (interrupted_) return;
    if (k < frames_) submit(k + 1);
  }
}

bool Run::checkpoint_due(std::uint64_t frame) const {
  return frame == frames_ || frame % options_.checkpoint_frames == 0 ||
         seconds_since(last_checkpoint_) >= options_.checkpoint_seconds;
}

void Run::note_clamped(const model::Drive& drive, std::uint64_t frame) {
  if (model_.muscle_count == 0) return;
  const std::uint64_t regions = drive::clamped_regions(model_, drive.muscles.last(model_.muscle_count));
  if (regions > progress_.clamped.regions) progress_.clamped = {regions, frame};
}

// All frames before are written.
void Run::refuse_not_finite(const model::Frame& frame) {
  std::uint32_t count = 0, first = 0;
  for (std::uint32_t i = 0; i < model_.vertex_count; ++i) {
    const float* p = &frame.positions[std::size_t{3} * i];
    if (is_finite(p[0]) && is_finite(p[1]) && is_finite(p[2])) continue;
    if (count == 0 || model_.source_vertex[i] < model_.source_vertex[first]) first = i;
    ++count;
  }
  const double time = scene_.start + static_cast<double>(frame.index) / scene_.fps;
  progress_.message = "frame " + base::number_text(frame.index) + " (" + base::number_text(time) +
                      " s): vertex " + base::number_text(model_.source_vertex[first]) + " of layer " +
                      model_.layers.at(model_.layer_of(first)).name +
                      " has a position that is not a finite number, as have " + base::number_text(count) +
                      " in all; try more substeps, a lower alpha or more damping";
  save_manifest(Status::not_finite);
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

void Run::checkpoint(const model::State& state) {
  const Stopwatch time(seconds_writing_);
  for (const auto& sink : sinks_) sink->sync();
  write_checkpoint(path_of(checkpoint_name), {identity_, state, skinned_});
  save_manifest(Status::running);
  last_checkpoint_ = Clock::now();
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

void Run::save_manifest(Status status) {
  progress_.status = status;
  progress_.timings = {.solver = before_.solver + seconds_solver_,
                       .writing = before_.writing + seconds_writing_,
                       .total = before_.total + seconds_since(start_),
                       .runs = before_.runs};
  base::write_whole(path_of(manifest_name), manifest_text(scene_, model_, options_, model_hash_, progress_));
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

std::uint64_t number_of_first(const scene::Scene& scene, const BakeOutput& output) {
  const std::uint64_t handles = scene.motion.handles;
  return first_written(output.first_number.value_or(handles), handles);
}

std::uint32_t substeps_of(const scene::Scene& scene, const BakeOptions& options) {
  return options.substeps ? *options.substeps : scene::stated_substeps(scene);
}

std::uint32_t iterations_of(const scene::Scene& scene, const BakeOptions& options) {
  return options.iterations.value_or(scene.solver.iterations.value_or(model::SolverOptions{}.iterations));
}

std::uint64_t first_written(std::uint64_t first_of_range, std::uint64_t handles) {
  if (first_of_range < handles)
    throw BakeError("--first-frame " + base::number_text(first_of_range) + ": " + base::number_text(handles) +
                    " handles before it would have numbers below 0; give at least " +
                    base::number_text(handles));
  return first_of_range - handles;
}

}  // namespace fascicle::bake
