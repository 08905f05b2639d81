#include "host/studio/session.h"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/text.h"
#include "host/base/version.h"
#include "host/scene/input_files.h"
#include "host/studio/baked_motion.h"
#include "host/studio/scene_keys.h"

namespace fascicle::studio {

namespace {

constexpr unsigned most_refused = 100;  // refused messages from a page before it is disconnected

// A file may be named in several ways. Built-in scenes are not files.
bool is_same_source(const std::string& a, const std::string& b) {
  std::error_code none;
  return a == b || std::filesystem::equivalent(a, b, none);
}

}  // namespace

Session::Session(scene::Scene scene, SessionOptions options, pipeline::Say say)
    : say_(std::move(say)),
      options_(std::move(options)),
      name_(scene.name),
      source_(scene.source),
      is_live_(true) {
  const std::filesystem::path source(source_);
  if (source.extension() == ".toml") source_folder_ = source.parent_path();
  converter_ = scene.converter;
  base_text_ = scene.text;
  base_paints_ = paints_after(scene::edited_tables(base_text_, source_));
  base_hash_ = hash_of_all(base_text_, base_paints_);
  bake::make_folder(options_.folder);
  lock_.emplace(options_.folder);
  std::optional<SessionRecord> record;
  try {
    record = read_session(options_.folder, name_ + ".toml");
  } catch (const base::InputError&) {
    // Kept below.
  }
  if (record) {
    if (is_same_source(record->source, source_) && record->base_hash == base_hash_) {
      history_.emplace(std::move(record->steps), record->at);
      saved_file_ = record->saved_file;
      saved_hash_ = record->saved_hash;
      saved_text_ = record->saved_text;
      saved_paints_ = record->saved_paints;
      const bool is_behind = history_->go_to_built();
      // A session from elsewhere may have a single step that is not the scene.
      if (history_->steps().size() > 1 || state_hash() != base_hash_)
        restored_ = "Session restored from " + options_.folder.string();
      // It may be what ended the program.
      if (is_behind)
        restored_ += ". A change was not yet shown when the program ended: " + *history_->redo_label() +
                     ". Redo makes it again.";
    } else {
      keep_old_session("contained a session of another scene, or of an older version of this one");
    }
  } else if (std::filesystem::exists(options_.folder / session_file_name)) {
    keep_old_session("contained a session that cannot be read: damaged, or from another version of fascicle");
  }
  if (!history_) history_.emplace(base_text_, base_paints_);

  options_.build.is_cancelled = [this, outer = options_.build.is_cancelled] {
    return stops_ || stops_build_ || (outer && outer());
  };
  devices_.push_back(pipeline::choose_device(options_.device, options_.threads, say_));
  workshop_ = std::make_unique<Workshop>(TextSource{name_, source_, source_folder_, converter_},
                                         options_.build, devices_.back());
  std::unique_ptr<LiveMotion> motion;
  const auto make_first = [&] {
    try {
      body_ = make(history_->text(), history_->paints(), revision_);
    } catch (const base::SceneError& error) {
      // Other errors are of the machine, such as a full disk or no memory, and the session may be sound.
      if (restored_.empty()) throw;
      body_ = make(base_text_, base_paints_, revision_);
      begin_anew(error.what());
    }
    motion = std::make_unique<LiveMotion>(body_);
  };
  try {
    make_first();
  } catch (const gpu::DeviceError& error) {
    if (!may_leave_gpu()) throw;
    motion.reset();
    leave_gpu(devices_.back().label() + ": " + error.what(), gpu_failed);
    make_first();
  }
  if (!options_.beside.empty())
    beside_ = std::make_unique<BesideBake>(beside_choices(options_.beside, {}).front());
  tables_ = scene::edited_tables(history_->text(), source_);
  history_->note_built(history_->text(), history_->paints());
  prepared_ = prepare(body_);
  prepared_.text = history_->text();
  prepared_.paints = history_->paints();
  publish(prepared_);
  writer_ = std::make_unique<SessionWriter>(options_.folder, [this](const std::string& error) {
    if (!error.empty()) pipeline::say_warning(say_, "the session could not be saved: " + error);
    const std::lock_guard lock(mutex_);
    if (!error.empty())
      return broadcast({{"type", "failed"},
                        {"what", "autosave"},
                        {"error", "Changes could not be saved to disk, and would be lost: " + error}});
    autosaved_ = std::time(nullptr);
    broadcast(history_json());
  });
  start_player(std::move(motion));
  builder_ = std::thread([this] { build_on(); });
}

// Instead of a session that cannot be built.
void Session::begin_anew(const std::string& why) {
  keep_old_session("contained a session that cannot be built: " + why);
  history_.emplace(base_text_, base_paints_);
  saved_file_.clear();
  saved_hash_.clear();
  saved_text_.clear();
  saved_paints_.clear();
  restored_.clear();
}

void Session::keep_old_session(const std::string& why) {
  // Earlier ones stay: session.before.json, session.before-2.json, ...
  std::filesystem::path kept = options_.folder / old_session_file_name;
  for (unsigned number = 2; std::filesystem::exists(std::filesystem::symlink_status(kept)); ++number)
    kept.replace_filename(std::filesystem::path(old_session_file_name).stem().string() + "-" +
                          base::number_text(number) + ".json");
  base::rename_over(options_.folder / session_file_name, kept);
  pipeline::say_warning(say_,
                        options_.folder.string() + ": " + why + "; kept as " + kept.filename().string());
}

Session::Session(const std::filesystem::path& bake, std::vector<std::filesystem::path> beside,
                 pipeline::Say say)
    : say_(std::move(say)) {
  options_.beside = std::move(beside);
  if (!options_.beside.empty())
    beside_ = std::make_unique<BesideBake>(beside_choices(options_.beside, {}).front());
  auto open = std::make_unique<pipeline::OpenBake>(bake);
  name_ = open->manifest().scene_name;
  source_ = bake.string();
  const std::string& source = open->manifest().scene_source;
  constexpr std::string_view builtin = "builtin:";
  scene_to_open_ = source.starts_with(builtin) ? source.substr(builtin.size()) : source;
  const scene::Scene* scene = nullptr;
  std::string without_scene;
  try {
    scene = &open->scene();
  } catch (const std::runtime_error& error) {
    without_scene = std::string(error.what()) + "; frames are shown without skinning, joints and lag";
    pipeline::say_warning(say_, without_scene);
  }
  const model::Model& model = open->model();
  const std::filesystem::path character = bake / "character.glb";
  std::error_code none;
  looks_ = read_body_looks(std::filesystem::exists(character, none) ? character : std::filesystem::path(),
                           model, say_);
  body_number_ = 1;
  const BodyParts parts{model, nullptr, scene};
  arrays_ = array_messages(parts, looks_, body_number_, {});
  body_message_ = body_json(parts, looks_, body_number_, arrays_);
  const std::uint64_t last = open->frame_count() - 1;
  if (scene != nullptr) {
    clip_message_ = clip_json(*scene, last, 0, 0);
  } else {
    clip_message_ = {
        {"type", "clip"},         {"name", ""},     {"clips", Json::array()}, {"fps", open->fps()},
        {"start", open->start()}, {"frames", last}, {"substeps", 0},          {"iterations", 0}};
  }
  std::vector<build::Warning> warnings;
  if (!without_scene.empty()) warnings.push_back({without_scene, {}});
  for (const std::string& text : open->manifest().warnings) warnings.push_back({text, {}});
  warnings_message_ = {{"type", "warnings"}, {"list", warnings_json(model, warnings)}};
  start_player(std::make_unique<BakedMotion>(std::move(open), bake));
}

void Session::start_player(std::unique_ptr<Motion> motion) {
  // Its first event may need the player.
  const std::lock_guard lock(mutex_);
  player_ = std::make_unique<Player>(std::move(motion), player_events());
  player_->watch(false);
}

// Whether the GPU failed that the studio chose by itself.
bool Session::is_left_to_cpu(const std::exception& error) const {
  return dynamic_cast<const gpu::DeviceError*>(&error) != nullptr &&
         options_.device.kind == pipeline::DeviceRequest::Kind::automatic;
}

PlayerEvents Session::player_events() {
  return {.on_frame = [this](Motion& motion, const ShownFrame& frame) { show(motion, frame); },
          .on_state =
              [this](const PlayerState&) {
                const std::lock_guard lock(mutex_);
                broadcast(player_json());
              },
          .on_trouble =
              [this](const std::exception& error) {
                std::string text = error.what();
                const bool leaves_gpu = is_left_to_cpu(error);
                if (!leaves_gpu) pipeline::say_warning(say_, text);
                const std::lock_guard lock(mutex_);
                const PlayerMode mode = player_->state().mode;
                const bool is_told = leaves_gpu && awaits_cpu_ && mode != PlayerMode::recording;
                if (leaves_gpu) {
                  gpu_error_ = text;
                  text += "; the CPU takes over";
                  awaits_cpu_ = true;
                  // A page may have asked for a pause while the frame that failed was computed.
                  resumes_ = is_to_play_ && (resumes_ || mode == PlayerMode::playing);
                  player_message_ = gpu_left;
                  broadcast(player_json());
                  builder_wakes_.notify_all();
                }
                if (hand_of_) release_hand();
                let_go();
                if (is_told) return;
                broadcast({{"type", "failed"}, {"what", "motion"}, {"error", text}});
              }};
}

Session::~Session() {
  leave();
  stops_ = stops_bake_ = true;
  {
    const std::lock_guard lock(mutex_);
    builder_wakes_.notify_all();
  }
  if (builder_.joinable()) builder_.join();
  if (player_) {
    player_->cancel();
    player_->stop();
  }
  player_.reset();
  {
    // It was built, and would have been shown as soon as the player was free.
    const std::lock_guard lock(mutex_);
    if (next_ && history_->note_built(next_->text, next_->paints)) autosave();
  }
  writer_.reset();
}

void Session::serve(Server& server) {
  const std::lock_guard lock(mutex_);
  server_ = &server;
}

void Session::leave() {
  const std::lock_guard lock(mutex_);
  server_ = nullptr;
  pages_.clear();
}

void Session::send(PageId page, const Json& json) {
  if (server_ != nullptr) server_->send_text(page, message_text(json));
}

void Session::broadcast(const Json& json) {
  if (server_ == nullptr || pages_.empty()) return;
  const SharedBytes text = message_text(json);
  for (const auto& [page, state] : pages_) server_->send_text(page, text);
}

Json Session::player_json() const {
  const PlayerState state = player_->state();
  return {{"type", "player"},     {"state", name_of(state.mode)}, {"frame", state.frame},
          {"speed", state.speed}, {"loop", state.loops},          {"message", player_message_}};
}

Json Session::history_json() const {
  const auto label = [](const std::string* text) { return text != nullptr ? Json(*text) : Json(nullptr); };
  return {{"type", "history"},
          {"revision", revision_},
          {"undo", label(history_->undo_label())},
          {"redo", label(history_->redo_label())},
          {"steps", history_->steps().size()},
          {"saved", !saved_hash_.empty() && saved_hash_ == state_hash()},
          {"autosaved", autosaved_}};
}

Json Session::keys_message() const {
  return {{"type", "keys"}, {"revision", revision_}, {"groups", keys_json(tables_)}};
}

Json Session::presets_message() const {
  return {{"type", "presets"}, {"list", presets_json(presets_of(*body_, tables_))}};
}

void Session::send_start(PageId page) {
  Json hello{{"type", "hello"},
             {"protocol", 1},
             {"program", base::fascicle_version},
             {"solver_version", base::solver_version},
             {"kind", is_live_ ? "live" : "bake"},
             {"name", name_},
             {"source", source_},
             {"folder", options_.folder.string()},
             {"device", devices_.empty() ? std::string() : devices_.back().text()},
             {"can_touch", is_live_},
             {"restored", !restored_.empty()}};
  if (!is_live_)
    hello["why_not"] =
        "This is a bake: it can be played but not changed. To edit its scene, run fascicle studio " +
        scene_to_open_;
  if (!restored_.empty()) hello["message"] = restored_;
  send(page, hello);
  send(page, body_message_);
  for (const ArrayMessage& array : arrays_) server_->send_binary(page, array.bytes);
  send(page, clip_message_);
  if (is_live_) {
    send(page, keys_message());
    send(page, presets_message());
  }
  send(page, warnings_message_);
  send_beside(page, beside_message());
  if (is_live_) send_paint(page);
  if (is_live_) send(page, history_json());
  send(page, player_json());
  send(page, {{"type", "ready"}});
}

void Session::page_opened(PageId page) {
  try {
    const std::lock_guard lock(mutex_);
    if (server_ == nullptr) return;
    const bool has_surface = body_message_["counts"]["surface_vertices"] > 0;
    pages_[page] = {
        .blocks = bit_of(has_surface ? Block::surface : Block::vertices), .beside_blocks = 0, .refused = 0};
    send_start(page);
    player_->watch(true);
  } catch (const std::exception& error) {
    // On the server's thread, an exception would end the program.
    pipeline::say_warning(say_, std::string("a page could not be opened: ") + error.what());
    const std::lock_guard lock(mutex_);
    if (server_ != nullptr) server_->close(page, error.what());
    return;
  }
  // A page that opens while nothing plays still needs a frame.
  player_->post([this](Motion& motion) { player_->show(motion.again()); });
}

void Session::page_closed(PageId page) {
  const std::lock_guard lock(mutex_);
  pages_.erase(page);
  player_->watch(!pages_.empty());
  if (stroke_ && stroke_->page == page) try {
      end_stroke();
    } catch (const std::exception& error) {
      pipeline::say_warning(say_, error.what());
    }
  if (hand_of_ != page) return;
  hand_of_.reset();
  release_hand();
}

void Session::page_said(PageId page, bool is_text, const std::string& bytes) {
  const std::lock_guard lock(mutex_);
  const auto known = pages_.find(page);
  if (known == pages_.end()) return;
  const auto refuse = [&](const std::string& error, std::optional<std::int64_t> id) {
    Json answer{{"type", "refused"}, {"error", error}};
    if (id) answer["id"] = *id;
    send(page, answer);
  };
  try {
    if (!is_text) throw BadMessage("messages must be text");
    const Command command = parse_command(bytes);
    try {
      obey(page, command);
    } catch (const BadMessage&) {
      throw;
    } catch (const std::exception& error) {
      // A valid command that cannot be carried out does not count towards most_refused.
      refuse(error.what(), command.id);
    }
  } catch (const BadMessage& error) {
    refuse(error.what(), error.id);
    if (++known->second.refused >= most_refused && server_ != nullptr)
      server_->close(page, std::to_string(most_refused) + " invalid messages");
  }
}

void Session::answer_done(PageId page, const Command& command, const std::string& message) {
  if (!command.id && message.empty()) return;
  Json answer{{"type", "done"}};
  if (command.id) answer["id"] = *command.id;
  if (!message.empty()) answer["message"] = message;
  send(page, answer);
}

// Marks the hand as empty.
void Session::let_go() {
  if (!hand_of_) return;
  hand_of_.reset();
  broadcast({{"type", "hand"}, {"is_held", false}, {"vertices", 0}});
}

void Session::must_be_live() const {
  if (!is_live_) throw std::runtime_error("this is a bake: it can be played but not changed");
}

}  // namespace fascicle::studio
