#include "host/bake/export.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string_view>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/model_file.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/blender_script.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/shaped_surface.h"
#include "host/formats/surface.h"
#include "host/formats/surface_objects.h"
#include "host/scene/scene_json.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

namespace {

// The formats asked for, each once, in the order of all_formats().
std::vector<const formats::Format*> chosen(const std::vector<std::string>& names) {
  std::vector<const formats::Format*> formats;
  std::vector<std::string> left = names;
  std::string possible;
  for (const formats::Format& format : all_formats()) {
    if (format.name.empty()) continue;
    const bool wanted = std::erase(left, format.name) > 0;
    if (!format.from_cache) {
      if (wanted)
        throw BakeError("--to " + format.name +
                        ": needs velocities, which a bake's folder does not keep; bake with --format " +
                        format.name);
      continue;
    }
    possible += (possible.empty() ? "" : ", ") + format.name;
    if (wanted) formats.push_back(&format);
  }
  if (!left.empty())
    throw BakeError("--to " + left.front() + ": there is no such format; there are " + possible);
  if (formats.empty()) throw BakeError("no format given; use --to with any of " + possible);
  return formats;
}

ManifestSummary manifest_to_export(const fs::path& folder) {
  if (!holds_bake(folder)) throw BakeError(folder.string() + ": holds no bake");
  std::optional<ManifestSummary> manifest = read_manifest(folder);
  constexpr std::uint64_t most = 1'000'000'000;
  if (!manifest || manifest->first_number > most || manifest->handles > most)
    throw BakeError((folder / manifest_name).string() +
                    ": is missing or damaged; bake again with --overwrite");
  return std::move(*manifest);
}

FrameCacheReader finished_cache(const fs::path& folder, const ManifestSummary& manifest) {
  if (!manifest.frames_kept) throw BakeError(frames_not_kept_text(folder));
  FrameCacheReader cache(folder / cache_name);
  const std::uint64_t wanted = cache.header().frames + 1;
  if (cache.frame_count() < wanted) {
    const bool failed = manifest.status == name_of(Status::failed);
    throw BakeError(folder.string() + ": the bake is not finished" +
                    (failed ? ", it failed (" + manifest.message + ")" : "") + ", " +
                    base::number_text(cache.frame_count()) + " of " + base::number_text(wanted) +
                    " frames are there; go on with fascicle bake --resume, or bake again with --overwrite");
  }
  if (manifest.fps && *manifest.fps != cache.header().fps)
    throw BakeError((folder / manifest_name).string() + ": has another frame rate than " + cache_name +
                    " beside it (" + base::number_text(cache.header().fps) +
                    "); bake again with --overwrite");
  return cache;
}

bool is_own(const ExportOptions& options) {
  std::error_code missing;
  return options.folder.empty() || fs::equivalent(options.folder, options.bake, missing);
}

class Export {
 public:
  explicit Export(const ExportOptions& options)
      : options_(options),
        formats_(chosen(options.formats)),
        own_(is_own(options)),
        folder_(own_ ? options.bake : options.folder),
        manifest_(manifest_to_export(options.bake)),
        cache_(finished_cache(options.bake, manifest_)),
        model_(read_model_of_frames(options.bake, cache_.header())),
        shapes_(model_.has_skeleton() ? options.bake / formats::character_name : fs::path(), model_,
                cache_.header().fps) {}

  ExportResult go();

 private:
  model::Frame frame(std::uint64_t k) const {
    model::Frame frame = cache_.read(k);
    frame.surface = formats::embed(model_, frame.positions);
    shapes_.add_to(k, frame.surface);
    return frame;
  }
  std::vector<std::string> names() const;
  void open_folder();

  const ExportOptions& options_;
  const std::vector<const formats::Format*> formats_;
  const bool own_;
  const fs::path folder_;
  const ManifestSummary manifest_;
  const FrameCacheReader cache_;
  const model::Model model_;
  const formats::ShapedSurface shapes_;
  std::optional<FolderLock> bake_lock_, lock_;
};

std::vector<std::string> Export::names() const {
  std::vector<std::string> names;
  for (const formats::Format* format : formats_) names.push_back(format->file);
  if (!own_) {
    names.push_back(formats::rest_name);
    names.push_back(formats::blender_script_name);
    if (model_.has_skeleton()) {
      names.push_back(formats::rest_materials_name);
      names.push_back(std::string(formats::textures_folder) + '/');
    }
  }
  return names;
}

void Export::open_folder() {
  bake_lock_.emplace(options_.bake);
  make_folder(folder_);
  if (!own_) lock_.emplace(folder_);
  if (!options_.overwrite) refuse_foreign(folder_, names());
}

ExportResult Export::go() {
  const auto start = std::chrono::steady_clock::now();
  open_folder();
  ExportStage stage(folder_);
  const model::Frame initial = frame(0);
  const CacheHeader& header = cache_.header();
  const std::uint64_t first = options_.first_number ? first_written(*options_.first_number, manifest_.handles)
                                                    : manifest_.first_number;
  const fs::path character = model_.has_skeleton() ? options_.bake / formats::character_name : fs::path();
  const auto surface =
      std::make_shared<const formats::SurfaceObjects>(formats::read_surface_objects(model_, character));
  const formats::BakeInfo info{.model = &model_,
                               .folder = stage.path(),
                               .scene_name = {},
                               .fps = header.fps,
                               .start = header.start,
                               .frames = header.frames,
                               .first = 0,
                               .initial = &initial,
                               .character = character,
                               .glb = options_.glb,
                               .objects = surface,
                               .first_number = first,
                               .usd_skel = options_.usd_skel};
  ExportResult result{.frames = header.frames, .files = {}, .report = {}};
  std::vector<std::unique_ptr<formats::FrameSink>> sinks;
  for (const formats::Format* format : formats_) {
    sinks.push_back(format->make());
    sinks.back()->begin(info);
  }
  for (std::uint64_t k = 0; k <= header.frames && !result.interrupted; ++k) {
    const model::Frame current = frame(k);
    for (const auto& sink : sinks) sink->write(current);
    if (options_.on_frame) options_.on_frame(k, header.frames);
    result.interrupted = k < header.frames && options_.interrupted != nullptr && options_.interrupted->load();
  }
  if (!result.interrupted) {
    for (const auto& sink : sinks) {
      sink->finish();
      formats::append(result.report, sink->report());
    }
    if (!own_) {
      formats::write_rest_mesh(stage.path(), model_, *surface);
      base::write_whole(
          stage.path() / formats::blender_script_name,
          formats::blender_script({.fps = header.fps, .frames = header.frames, .first_number = first}));
    }
    // The manifest names the files before they are there: a stop on the way leaves none that nobody owns.
    if (own_) add_to_manifest(folder_, names());
    stage.move_up(names());
    // A bake's list has its textures already.
    if (own_) stage.move_up({std::string(formats::textures_folder) + '/'});
    for (const std::string& name : names())
      if (fs::exists(folder_ / name)) result.files.push_back(folder_ / name);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

std::vector<std::string> export_format_names() {
  std::vector<std::string> names;
  for (const formats::Format& format : all_formats())
    if (!format.name.empty() && format.from_cache) names.push_back(format.name);
  return names;
}

ExportResult export_bake(const ExportOptions& options) {
  const fs::path character = options.bake / formats::character_name;
  const auto damaged = [&](const std::string& what) {
    return BakeError(what + "; what the bake kept is damaged: bake again with --overwrite");
  };
  // No other scene, glTF or JSON is read than what the bake kept.
  try {
    return Export(options).go();
  } catch (const base::InputError& error) {
    // What is there may be whole, and not to be read by this user or at this moment.
    if (!fs::exists(character) && std::string_view(error.what()).starts_with(character.string()))
      throw damaged(error.what());
    throw;
  } catch (const base::SceneError& error) {
    throw damaged(error.what());
  } catch (const scene::Json::exception& error) {
    throw damaged(character.string() + ": " + error.what());
  }
}

}  // namespace fascicle::bake
