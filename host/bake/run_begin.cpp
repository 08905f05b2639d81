// How a bake begins: ownership of the folder, what to resume from an earlier bake, the state of frame 0, and
// the files.
#include <algorithm>
#include <utility>

#include "host/bake/kept_start.h"
#include "host/bake/look.h"
#include "host/bake/model_file.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/run.h"
#include "host/bake/verify.h"
#include "host/base/part_file.h"
#include "host/drive/lead_in.h"
#include "host/formats/blender_script.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface.h"
#include "host/formats/surface_objects.h"
#include "host/model/validate.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

namespace {

bool is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Run::Run(const scene::Scene& scene, const model::Model& model, model::Solver& solver,
         const BakeOptions& options)
    : scene_(scene),
      model_(model),
      solver_(solver),
      options_(checked(options, model)),
      frames_(scene::frame_count(scene)),
      model_hash_(model_hash(model)),
      identity_(identity_of(scene, model_hash_, options_)),
      drives_(scene, model, substeps_of(scene, options)) {}

void Run::open_folder() {
  make_folder(options_.folder);
  lock_.emplace(options_.folder);
  const bool used = holds_bake(options_.folder);
  if (used && options_.overwrite) {
    refuse_to_replace(options_.folder, file_names(model_, options_.formats));
    clear_bake(options_.folder);
  }
  if (used && !options_.overwrite && !options_.resume)
    throw FolderInUse(
        options_.folder.string() +
        ": already holds a bake; --resume continues it, --overwrite starts again, or choose another -o");
}

// Empty if the bake starts at frame 0.
std::optional<Checkpoint> Run::checkpoint_to_resume() {
  if (!options_.resume || !holds_bake(options_.folder)) return std::nullopt;
  std::optional<Checkpoint> found = read_checkpoint(path_of(checkpoint_name));
  if (!found) {
    const std::optional<ManifestSummary> manifest = read_manifest(options_.folder);
    if (!manifest || manifest->frames_done > 0 || manifest->status == name_of(Status::complete))
      throw BakeError(
          path_of(checkpoint_name).string() +
          ": the bake to resume has lost this file; start again with --overwrite, or choose another -o");
    // Stopped before its first checkpoint, or while it was overwritten: nothing is lost by starting again.
    refuse_to_replace(options_.folder, file_names(model_, options_.formats));
    clear_bake(options_.folder);
    return std::nullopt;
  }
  std::vector<Difference> changed = differences(found->identity, identity_);
  files_change_ = !changed.empty();
  if (files_change_) anew_ = formats_begun_anew(found->identity, identity_);
  std::erase_if(changed,
                [&](const Difference& one) { return leaves_frames(one, scene_, found->state.frame); });
  if (!changed.empty())
    throw BakeError(options_.folder.string() + ": cannot be resumed, because this bake would differ: " +
                    text_of(changed) + "; set it back, start again with --overwrite, or choose another -o");
  check_checkpoint(*found, model_, frames_, path_of(checkpoint_name));
  if (const auto manifest = read_manifest(options_.folder)) {
    before_ = manifest->timings;
    progress_.lead_in = manifest->lead_in;
    clamped_ = progress_.clamped = manifest->clamped;
    ++before_.runs;
    const std::vector<std::string> known = all_file_names(), own = file_names(model_, options_.formats);
    for (const std::string& name : manifest->files)
      if (is_among(known, name) && !is_among(own, name) && fs::exists(options_.folder / name))
        progress_.exported.push_back(name);
  }
  return found;
}

// Before the first write of a resumed bake: throws if a frame is damaged, or if a file that cannot be made
// from the frames is gone or too short. False if interrupted.
bool Run::check_kept(std::uint64_t last) {
  const FrameCacheReader cache = frames_to_resume(
      path_of(cache_name), cache_header(model_, scene_.fps, scene_.start, frames_), last + 1);
  // Only a bake resumed with another end may have another number of frames.
  if (!files_change_ && cache.header().frames != frames_)
    throw BakeError(path_of(cache_name).string() + ": belongs to another bake; start again with --overwrite");
  for (const formats::Format& format : all_formats())
    if (!format.from_cache && (format.name.empty() || is_among(options_.formats, format.name)))
      refuse_lost(options_.folder, format.file, last, number_of_first(scene_, options_));
  base::PartFile::check_lines(path_of(metrics_name), last + 2);  // with its head
  // The cache is the authority on kept frames; reading them also checks them.
  for (std::uint64_t k = 0; k <= last; ++k) {
    if (was_stopped()) return false;
    progress_.position_hashes.push_back(model::position_hash(cache.read(k)));
  }
  return true;
}

// Resumes the frames and rewrites the files of formats from them. If that is interrupted, the manifest lists
// the new files, and the checkpoint says which ones to rewrite.
void Run::begin_other_files(const Checkpoint& from) {
  const std::optional<ManifestSummary> manifest = read_manifest(options_.folder);
  std::vector<std::string> names = file_names(model_, options_.formats);
  std::erase_if(names, [&](const std::string& name) {
    return name == checkpoint_name || (manifest && is_among(manifest->files, name));
  });
  // All checks that may refuse come before the first write.
  refuse_foreign(options_.folder, names);
  if (manifest && manifest->frames != frames_ && !progress_.exported.empty()) {
    std::string list;
    for (const std::string& name : progress_.exported) list += (list.empty() ? "" : ", ") + name;
    progress_.warnings.push_back("removed what was exported from the earlier frames (" + list +
                                 "); export it again");
    report_.warnings.push_back(progress_.warnings.back());
    remove_files(options_.folder, progress_.exported);
    progress_.exported.clear();
  }
  has_begun_ = true;
  write_checkpoint(path_of(checkpoint_name), {while_begun_anew(identity_, anew_), from.state, from.skinned});
  save_manifest(Status::running, moment());
}

// A bake that is complete and kept no frames cannot be resumed, and need not be.
std::optional<BakeResult> Run::done_without_frames() {
  const std::optional<ManifestSummary> manifest = read_manifest(options_.folder);
  if (!manifest || manifest->frames_kept) return std::nullopt;
  if (options_.keep_frames || files_change_) throw BakeError(frames_not_kept_text(options_.folder));
  // A bake that stopped just before it removed its frames still has them.
  const bool has_frames = is_frame_cache(path_of(cache_name));
  if (!has_frames) remove_files(options_.folder, {cache_name});
  if (!verify_bake({.bake = options_.folder, .interrupted = options_.interrupted}).is_good()) {
    if (has_frames) return std::nullopt;
    throw BakeError(frames_not_kept_text(options_.folder));
  }
  remove_files(options_.folder, {cache_name});
  BakeResult result = summary();
  result.frames_done = frames_;
  result.last_position_hash = manifest->last_position_hash;
  return result;
}

// A complete bake whose files are all there is left as it is: other programs may be reading them. A signal
// ends the checks early; nothing is left to resume then either.
std::optional<BakeResult> Run::done_before(const Checkpoint& last) {
  const std::optional<ManifestSummary> manifest = read_manifest(options_.folder);
  const bool is_complete = manifest && manifest->status == name_of(Status::complete);
  if (!is_complete || files_change_ || !options_.keep_frames || last.state.frame != frames_)
    return std::nullopt;
  const FrameCacheReader cache(path_of(cache_name));
  if (cache.header() != cache_header(model_, scene_.fps, scene_.start, frames_)) return std::nullopt;
  const VerifyResult verified = verify_bake({.bake = options_.folder, .interrupted = options_.interrupted});
  if (!verified.is_good()) return std::nullopt;
  take_look();
  if (scene_.motion.seamless) {
    const model::Frame first = cache.read(0);
    progress_.loop_jump =
        drive::largest_distance(model_, first.positions, first.origin, drives_.begun_again(last.state));
  }
  report_.notes.emplace_back("the bake was complete, and its files are as they were");
  BakeResult result = summary();
  result.frames_done = frames_;
  result.last_position_hash = manifest->last_position_hash;
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

// Up to two frames before `first`, with positions and skinned, if a look is measured.
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

bool Run::starts_anew(const formats::Format& format, const formats::FrameSink& sink) const {
  return !sink.resumes() || is_among(anew_, format.name);
}

bool Run::begin_sinks(const Checkpoint* resumed) {
  const Stopwatch time(seconds_writing_);
  const std::uint64_t first = resumed != nullptr ? resumed->state.frame + 1 : 0;
  const std::vector<model::Frame> before = frames_before(first);
  const auto* character = std::get_if<rig::Character>(&scene_.geometry);
  const bool is_character = character != nullptr && model_.has_skeleton();
  if (is_character && (first == 0 || files_change_ || !fs::exists(path_of(formats::character_name))))
    base::write_whole(path_of(formats::character_name),
                      formats::character_glb(
                          scene_, model_, [this](std::uint64_t frame) { return drives_.clip_time(frame); },
                          missing_images_));
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
  needs_ = {.positions = true};  // for the hash, whatever the sinks need
  std::vector<formats::FrameSink*> from_the_start;
  for (const formats::Format& format : all_formats()) {
    if (!format.name.empty() && !is_among(options_.formats, format.name)) continue;
    sinks_.push_back(format.file == metrics_name ? make_metrics_sink(options_.look_body) : format.make());
    needs_ = needs_ | sinks_.back()->needs();
    formats::BakeInfo of_sink = info;
    if (resumed != nullptr && !starts_anew(format, *sinks_.back())) {
      try {
        sinks_.back()->begin(of_sink);
        continue;
      } catch (const base::LostFile& lost) {
        if (!format.from_cache) throw;
        report_.notes.push_back(format.name + ": written again from the frames (" + lost.reason + ")");
        // If this is interrupted, the checkpoint says what to write again.
        anew_.push_back(format.name);
        files_change_ = true;
        write_checkpoint(path_of(checkpoint_name),
                         {while_begun_anew(identity_, anew_), resumed->state, resumed->skinned});
        sinks_.back() = format.make();
      }
    }
    of_sink.first = 0;
    if (resumed != nullptr) from_the_start.push_back(sinks_.back().get());
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
  if (from_the_start.empty()) return true;
  const FrameCacheReader cache(path_of(cache_name));
  for (std::uint64_t k = 0; k < first; ++k) {
    // There may be many frames, and rewriting files takes time.
    if (was_stopped()) return false;
    model::Frame frame = cache.read(k);
    frame.surface = formats::embed(model_, frame.positions);
    shapes_->add_to(k, frame.surface);
    for (formats::FrameSink* sink : from_the_start) sink->write(frame);
  }
  return true;
}

}  // namespace fascicle::bake
