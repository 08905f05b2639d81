#include "host/bake/export.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "host/bake/bake.h"
#include "host/bake/finished_bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/outputs.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/blender_script.h"
#include "host/formats/formats.h"
#include "host/formats/rest_mesh.h"
#include "host/formats/surface_objects.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

namespace {

// The requested formats, each once, in the order of all_formats().
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
  if (!left.empty()) throw BakeError("--to " + left.front() + ": no such format; use any of " + possible);
  if (formats.empty()) throw BakeError("no format given; use --to with any of " + possible);
  return formats;
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
        bake_(options.bake),
        first_(options.first_number ? first_written(*options.first_number, bake_.manifest().handles)
                                    : bake_.manifest().first_number) {}

  ExportResult go();

 private:
  std::vector<std::string> names() const;
  void open_folder();

  const ExportOptions& options_;
  const std::vector<const formats::Format*> formats_;
  const bool own_;
  const fs::path folder_;
  const FinishedBake bake_;
  const std::uint64_t first_;  // number of frame 0 in the exported files
  std::optional<FolderLock> bake_lock_, lock_;
};

std::vector<std::string> Export::names() const {
  std::vector<std::string> names;
  for (const formats::Format* format : formats_) names.push_back(format->file);
  if (!own_) {
    names.push_back(formats::rest_name);
    names.push_back(formats::blender_script_name);
    if (bake_.model().has_skeleton()) {
      names.push_back(formats::rest_materials_name);
      names.push_back(std::string(formats::textures_folder) + '/');
    }
  }
  return names;
}

void Export::open_folder() {
  if (own_ && first_ != bake_.manifest().first_number)
    throw BakeError(options_.bake.string() + ": its files number the first frame " +
                    base::number_text(bake_.manifest().first_number + bake_.manifest().handles) +
                    "; with another --first-frame, export to another folder with -o");
  bake_lock_.emplace(options_.bake);
  make_folder(folder_);
  if (!own_) lock_.emplace(folder_);
  if (!options_.overwrite) refuse_foreign(folder_, names());
}

ExportResult Export::go() {
  const auto start = std::chrono::steady_clock::now();
  open_folder();
  ExportStage stage(folder_);
  const model::Frame initial = bake_.frame(0);
  const CacheHeader& header = bake_.header();
  const auto surface = std::make_shared<const formats::SurfaceObjects>(
      formats::read_surface_objects(bake_.model(), bake_.character()));
  const formats::BakeInfo info{.model = &bake_.model(),
                               .folder = stage.path(),
                               .scene_name = {},
                               .fps = header.fps,
                               .start = header.start,
                               .frames = header.frames,
                               .first = 0,
                               .initial = &initial,
                               .character = bake_.character(),
                               .glb = options_.glb,
                               .objects = surface,
                               .first_number = first_,
                               .usd_skel = options_.usd_skel};
  ExportResult result{.frames = header.frames, .files = {}, .report = {}};
  std::vector<std::unique_ptr<formats::FrameSink>> sinks;
  for (const formats::Format* format : formats_) {
    sinks.push_back(format->make());
    sinks.back()->begin(info);
  }
  for (std::uint64_t k = 0; k <= header.frames && !result.interrupted; ++k) {
    const model::Frame current = bake_.frame(k);
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
      formats::write_rest_mesh(stage.path(), bake_.model(), *surface);
      base::write_whole(
          stage.path() / formats::blender_script_name,
          formats::blender_script({.fps = header.fps, .frames = header.frames, .first_number = first_}));
    }
    // The manifest names the files before they exist, so that an interruption leaves no unlisted files.
    if (own_) add_to_manifest(folder_, names());
    stage.move_up(names());
    // The bake's manifest already lists its textures.
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
  std::optional<ExportResult> result;
  read_kept(options.bake, [&] { result = Export(options).go(); });
  return std::move(*result);
}

}  // namespace fascicle::bake
