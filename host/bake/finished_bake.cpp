#include "host/bake/finished_bake.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/model_file.h"
#include "host/base/errors.h"
#include "host/base/text.h"
#include "host/formats/character_file.h"
#include "host/formats/surface.h"
#include "host/model/reach.h"
#include "host/scene/scene_json.h"

namespace fascicle::bake {

namespace fs = std::filesystem;

namespace {

ManifestSummary checked_manifest(const fs::path& folder) {
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
                    " frames exist; continue with fascicle bake --resume, or bake again with --overwrite");
  }
  if (manifest.fps && *manifest.fps != cache.header().fps)
    throw BakeError((folder / manifest_name).string() + ": has a different frame rate than " + cache_name +
                    " beside it (" + base::number_text(cache.header().fps) +
                    "); bake again with --overwrite");
  return cache;
}

}  // namespace

FinishedBake::FinishedBake(const fs::path& folder)
    : folder_(folder),
      manifest_(checked_manifest(folder)),
      cache_(finished_cache(folder, manifest_)),
      model_(read_model_of_frames(folder, cache_.header())),
      character_(model_.has_skeleton() ? folder / formats::character_name : fs::path()),
      shapes_(character_, model_, cache_.header().fps) {}

model::Frame FinishedBake::frame(std::uint64_t k) const {
  model::Frame frame = cache_.read(k);
  frame.surface = formats::embed(model_, frame.positions);
  shapes_.add_to(k, frame.surface);
  // The model's embedding and the character's shapes are files', too.
  if (!model::is_in_reach(frame.surface, model_.unit))
    throw BakeError(folder_.string() + ": the surface of frame " + base::number_text(k) +
                    " is not finite, or absurdly large; bake again with --overwrite");
  return frame;
}

void read_kept(const fs::path& folder, const std::function<void()>& read) {
  const fs::path character = folder / formats::character_name;
  const auto damaged = [&](const std::string& what) {
    return BakeError(what + "; the bake's files are damaged: bake again with --overwrite");
  };
  try {
    read();
  } catch (const base::InputError& error) {
    // The file may be intact but not readable by this user or at this moment.
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
