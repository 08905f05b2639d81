// Recorded runs, saved scenes and bakes.
#include <algorithm>
#include <set>
#include <utility>

#include "host/base/file.h"
#include "host/base/text.h"
#include "host/pipeline/bake_scene.h"
#include "host/scene/input_files.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene.h"
#include "host/studio/scene_keys.h"
#include "host/studio/session.h"

namespace fascicle::studio {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

// A recorded run waits for every page to receive every frame, up to this long; a page that has gone to sleep
// is then ignored.
constexpr auto patience = std::chrono::seconds(2);
constexpr auto look_again = std::chrono::milliseconds(1);
constexpr auto pace_of_progress = std::chrono::milliseconds(100);
constexpr std::uint64_t most_scene_bytes = std::uint64_t{16} << 20;

// A link of that name may lead anywhere, and a bake would write there.
void refuse_link(const fs::path& folder) {
  if (fs::is_symlink(fs::symlink_status(folder)))
    throw std::runtime_error(folder.string() +
                             ": is a symbolic link, and nothing is written through one; choose another name, "
                             "or move it away");
}

}  // namespace

void Session::record() {
  const bool is_taken = player_->post_long(PlayerMode::recording, [this](Motion& motion) {
    auto& live = static_cast<LiveMotion&>(motion);
    {
      const std::lock_guard lock(mutex_);
      let_go();
    }
    std::set<PageId> asleep;  // pages that did not respond in time
    const auto wait_for_pages = [&] {
      const Clock::time_point latest = Clock::now() + patience;
      for (;;) {
        {
          const std::lock_guard lock(mutex_);
          if (server_ == nullptr || player_->must_stop()) return;
          const bool is_late = Clock::now() > latest;
          bool waits = false;
          for (const auto& [page, state] : pages_) {
            if (server_->is_free(page))
              asleep.erase(page);
            else if (is_late)
              asleep.insert(page);
            else
              waits = waits || !asleep.contains(page);
          }
          if (!waits) return;
        }
        std::this_thread::sleep_for(look_again);
      }
    };
    const Recording recording = live.record([this] { return player_->must_stop(); },
                                            [&](const ShownFrame& frame) {
                                              wait_for_pages();
                                              player_->show(frame);
                                            });
    const std::lock_guard lock(mutex_);
    if (recording.stopped) return broadcast({{"type", "cancelled"}, {"what", "record"}});
    Json hashes = Json::array();
    for (const std::uint64_t hash : recording.hashes) hashes.push_back(base::hash_text(hash));
    broadcast({{"type", "recorded"},
               {"revision", recording.revision},
               {"frames", recording.hashes.size() - 1},
               {"position_hash", base::hash_text(recording.hashes.back())},
               {"hashes", std::move(hashes)},
               {"seconds", recording.seconds}});
  });
  if (!is_taken) throw std::runtime_error(too_many_wait);
}

// The current text, with file names relative to the session's folder. `paint_names`: names of the session's
// paint files there, by key.
std::string Session::text_in_folder(const std::map<std::string, std::string>& paint_names) const {
  std::vector<scene::KeyChange> changes;
  // "." because names in the working directory have no folder. Canonical because ".." leaves the folder that
  // a link leads to, not the one that has the link.
  const fs::path from = fs::weakly_canonical(source_folder_ / "."),
                 to = fs::weakly_canonical(options_.folder);
  for (const scene::EditedTable& table : tables_)
    for (const scene::EditedKey& key : table.keys) {
      const bool is_paint = key.key->name == "paint";
      if ((key.key->name != "file" && !is_paint) || !key.is_stated || !key.value.is_string()) continue;
      if (const auto name = paint_names.find(key.path); name != paint_names.end()) {
        changes.push_back({key.path, Json(name->second)});
        continue;
      }
      const fs::path file(key.value.get<std::string>());
      if (file.is_absolute() || file.empty()) continue;
      changes.push_back({key.path, Json((from / file).lexically_normal().lexically_proximate(to).string())});
    }
  return changes.empty() ? history_->text() : scene::change_text(history_->text(), source_, changes).text;
}

// Names of the paint files for a scene called `stem`, by key. A session from elsewhere may hold paint that
// the scene does not name: nothing has read it, and it is not written.
std::map<std::string, std::string> Session::paint_names(const std::string& stem) const {
  std::map<std::string, std::string> names;
  for (const auto& [key, file] : paint_files(tables_))
    if (history_->paints().contains(key)) names[key] = paint_name_of(stem, key);
  return names;
}

// Saves the paints next to the scene that names them. Writes nothing if one of them must not be written.
void Session::save_paints(const std::map<std::string, std::string>& names, bool is_own_name, bool overwrite) {
  for (const auto& [key, name] : names) {
    const fs::path file = options_.folder / name;
    const std::optional<std::string> there = base::read_input_if_there(file, scene::most_paint_bytes);
    const auto saved = saved_paints_.find(key);
    const bool is_saved =
        there && is_own_name && saved != saved_paints_.end() && scene::hash_of(*there) == saved->second;
    const bool is_own = is_saved || (there && *there == *history_->paints().at(key));
    if (there && !is_own && !overwrite)
      throw std::runtime_error(
          file.string() +
          " already exists, and this session did not write it; choose another name, or overwrite it");
  }
  // Entries of undone paint stay, because redo may bring it back.
  if (!is_own_name) saved_paints_.clear();
  for (const auto& [key, name] : names) {
    const std::string& text = *history_->paints().at(key);
    base::write_whole(options_.folder / name, text);
    saved_paints_[key] = scene::hash_of(text);
  }
}

fs::path Session::save(const Command& command, Json& answer) {
  const std::string name = !command.name.empty()  ? command.name
                           : !saved_file_.empty() ? saved_file_
                                                  : name_ + ".toml";
  const fs::path path = options_.folder / name;
  const std::map<std::string, std::string> names = paint_names(path.stem().string());
  const std::string text = text_in_folder(names);
  const std::optional<std::string> there = base::read_input_if_there(path, most_scene_bytes);
  const bool is_own =
      there && (*there == text || (name == saved_file_ && scene::hash_of(*there) == saved_text_));
  if (there && !is_own && !command.overwrite)
    throw std::runtime_error(
        path.string() +
        " already exists, and this session did not write it; choose another name, or overwrite it");
  save_paints(names, name == saved_file_, command.overwrite);
  base::write_whole(path, text);
  saved_file_ = name;
  saved_text_ = scene::hash_of(text);
  saved_hash_ = state_hash();
  autosave();
  const bool had_comments = base_text_.find('#') != std::string::npos;
  const bool keeps_comments = !had_comments || text.find('#') != std::string::npos;
  answer["file"] = path.string();
  for (const auto& [key, file] : names) answer["paints"].push_back((options_.folder / file).string());
  answer["kept_comments"] = keeps_comments;
  answer["message"] =
      keeps_comments
          ? "fascicle bake accepts this file"
          : "fascicle bake accepts this file; a change could not be made in place, so the file was rewritten";
  return path;
}

void Session::bake(const Command& command) {
  if (bakes_) throw std::runtime_error("a bake is under way; stop it, or wait until it ends");
  const std::string folder = command.name.empty() ? "bake" : command.name;
  refuse_link(options_.folder / folder);
  if (!command.overwrite && bake::holds_bake(options_.folder / folder))
    throw std::runtime_error((options_.folder / folder).string() +
                             " already holds a bake; choose another name, or overwrite it");
  Command of_save;
  of_save.verb = Verb::save;
  of_save.overwrite = command.overwrite;
  Json saved{{"type", "saved"}};
  const fs::path file = save(of_save, saved);
  broadcast(saved);
  broadcast(history_json());
  pipeline::BakeRequest request;
  request.output.folder = options_.folder / folder;
  request.output.formats = command.formats;
  request.output.overwrite = command.overwrite;
  request.devices = {options_.device};
  if (options_.device.kind == pipeline::DeviceRequest::Kind::automatic)
    request.devices.push_back({.kind = pipeline::DeviceRequest::Kind::cpu});
  request.threads = options_.threads;
  request.build = options_.build;
  request.build.is_cancelled = [this] { return stops_ || stops_bake_; };
  request.interrupted = &stops_bake_;
  stops_bake_ = false;
  const bool is_taken =
      player_->post_long(PlayerMode::baking, [this, request, file, folder](Motion&) mutable {
        std::vector<std::string> warnings;
        const pipeline::Say note = [&](pipeline::Severity severity, const std::string& text) {
          if (severity == pipeline::Severity::warning) warnings.push_back(text);
          if (say_) say_(severity, text);
        };
        Clock::time_point told;
        const auto tell = [&](const char* phase, std::uint64_t frame, std::uint64_t frames) {
          const bool is_last = frames > 0 && frame == frames;
          if (Clock::now() - told < pace_of_progress && !is_last) return;
          told = Clock::now();
          const std::lock_guard lock(mutex_);
          broadcast({{"type", "baking"}, {"phase", phase}, {"frame", frame}, {"frames", frames}});
        };
        request.on_frame = [&](std::uint64_t frame, std::uint64_t frames) { tell("frames", frame, frames); };
        request.on_lead_in = [&] { tell("lead-in", 0, 0); };
        // The comparison bake must be closed while it is rewritten.
        std::optional<BesideChoice> stood;
        std::error_code none;
        if (beside_ && fs::equivalent(beside_->choice().folder, request.output.folder, none))
          stood = beside_->choice();
        if (stood) put_beside(std::nullopt);
        // However the bake ends, reopen the comparison bake and offer what was written as a choice.
        const auto end = [&](Json message) {
          if (stood) put_beside(stood);
          const std::lock_guard lock(mutex_);
          if (!stood) broadcast_beside();
          bakes_ = false;
          broadcast(std::move(message));
        };
        try {
          // The bake may have waited for a long time.
          refuse_link(request.output.folder);
          tell("build", 0, 0);
          scene::SceneOverrides overrides;
          overrides.converter = converter_;
          const auto prepared =
              pipeline::prepare_bake(scene::load_scene(file.string(), overrides), request, note);
          const bake::BakeResult result = pipeline::run_bake(*prepared, request, note);
          pipeline::say_result(result, note);
          if (result.interrupted) return end({{"type", "cancelled"}, {"what", "bake"}});
          Json files = Json::array();
          for (const fs::path& written : result.files) files.push_back(written.filename().string());
          end({{"type", "baked"},
               {"folder", request.output.folder.string()},
               {"scene", file.string()},
               {"files", std::move(files)},
               {"frames", result.frames_done},
               {"position_hash", result.last_position_hash},
               {"seconds", result.seconds_total},
               {"warnings", warnings}});
        } catch (const build::Cancelled&) {
          end({{"type", "cancelled"}, {"what", "bake"}});
        } catch (const std::exception& error) {
          end({{"type", "failed"}, {"what", "bake"}, {"error", error.what()}});
        }
      });
  if (!is_taken) throw std::runtime_error(too_many_wait);
  bakes_ = true;
}

}  // namespace fascicle::studio
