// What is open in the studio: a live scene or a bake's frames, the pages that show it, and their commands.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host/bake/folder.h"
#include "host/build/build.h"
#include "host/model/overlap.h"
#include "host/pipeline/device_choice.h"
#include "host/pipeline/messages.h"
#include "host/scene/scene.h"
#include "host/studio/beside.h"
#include "host/studio/body_messages.h"
#include "host/studio/commands.h"
#include "host/studio/history.h"
#include "host/studio/live_motion.h"
#include "host/studio/player.h"
#include "host/studio/server.h"
#include "host/studio/session_file.h"
#include "host/studio/workshop.h"

namespace fascicle::studio {

// Why a studio that chose the GPU by itself uses the CPU.
inline constexpr const char* gpu_failed = "the GPU failed";
// What pages show until the body for the CPU is there.
inline constexpr const char* gpu_left = "Moving to the CPU";
// Why the player takes no more requests.
inline constexpr const char* too_many_wait = "too many requests are waiting; try again in a moment";

struct SessionOptions {
  std::filesystem::path folder;  // where scenes and bakes are saved
  pipeline::DeviceRequest device;
  unsigned threads = 0;  // for the CPU solver; 0: one per core
  build::BuildOptions build;
  std::vector<std::filesystem::path> beside;  // bakes to compare with; the first is shown at once
};

class Session {
 public:
  // Reads, builds and starts playing. `scene` is from load_scene; its text is what changes apply to. Restores
  // the session in the folder if it is of the same scene. Throws what building a scene throws, and
  // bake::FolderInUse if another process uses the folder.
  Session(scene::Scene scene, SessionOptions options, pipeline::Say say);
  // Plays the frames of a bake, which cannot be changed. `beside`: as in SessionOptions. Throws
  // base::BakeError.
  Session(const std::filesystem::path& bake, std::vector<std::filesystem::path> beside, pipeline::Say say);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // From now on, the pages are this server's. The server must outlive the session's last call of it, so
  // destroy the server first. Its events are page_opened and so on.
  void serve(Server& server);
  // Call before the server goes.
  void leave();

  void page_opened(PageId page);
  void page_said(PageId page, bool is_text, const std::string& bytes);
  void page_closed(PageId page);

  const std::string& name() const { return name_; }
  // Empty if a bake is played.
  const std::filesystem::path& folder() const { return options_.folder; }
  bool is_restored() const { return !restored_.empty(); }

 private:
  struct Page {
    std::uint16_t blocks = 0, beside_blocks = 0;
    unsigned refused = 0;
  };
  // A change that no shown frame has yet.
  struct Pending {
    std::uint32_t revision = 0;
    bool is_rebuild = false;
    std::chrono::steady_clock::time_point since;
  };

  // A body and the messages about it.
  struct Publication {
    std::shared_ptr<RunningBody> body;
    std::uint32_t number = 0;
    std::vector<ArrayMessage> arrays;
    Json body_message, clip_message, warnings_message;
    std::string text;
    Paints paints;
    std::vector<PaintPlace> places;
    bool is_edit = false;  // Order::is_edit
  };
  // A brush stroke in progress.
  struct Stroke {
    PageId page = 0;
    std::uint64_t number = 0;
    const rig::PaintKind* kind = nullptr;
    std::vector<Painting> paintings;  // per place
    std::vector<bool> is_stamped;     // per place: whether the brush touched it
    Vector3d last = Vector3d::Zero();
  };

  // session.cpp
  void keep_old_session(const std::string& why);
  void begin_anew(const std::string& why);
  PlayerEvents player_events();
  bool is_left_to_cpu(const std::exception& error) const;
  void start_player(std::unique_ptr<Motion> motion);
  void must_be_live() const;
  void let_go();
  void send(PageId page, const Json& json);
  void broadcast(const Json& json);
  void send_start(PageId page);
  void show(Motion& motion, const ShownFrame& frame);
  Json player_json() const;
  Json history_json() const;
  Json keys_message() const;
  Json presets_message() const;
  void answer_done(PageId page, const Command& command, const std::string& message = "");

  // session_commands.cpp
  void obey(PageId page, const Command& command);
  void obey_player(const Command& command);
  void obey_hand(PageId page, const Command& command);
  void release_hand();

  // session_changes.cpp
  void set_keys(const std::vector<scene::KeyChange>& changes, const std::string& label,
                std::optional<std::uint64_t> gesture);
  // `is_running`: the live body already has this text.
  void take_text(const std::vector<scene::EditedTable>& before, const Paints& painted_before,
                 bool is_running = false);
  void step_in_history(bool is_undo);
  void build_on();
  std::shared_ptr<RunningBody> make(const std::string& text, const Paints& paints, std::uint32_t revision);
  bool may_leave_gpu() const;
  void leave_gpu(const std::string& problem, const std::string& why);
  // A text to build.
  struct Order {
    std::uint32_t revision = 0;
    std::string text;
    Paints paints;
    bool is_edit = false;   // else the text on show, for another device
    std::string gpu_error;  // why the GPU is to be left; empty: it is not
  };
  void build(const Order& order);
  void give_up(std::uint32_t revision, bool is_edit, const std::string& error);
  bool is_left_on_gpu() const;
  bool end_of_takeover();
  Publication prepare(const std::shared_ptr<RunningBody>& body);
  void publish(const Publication& publication);
  void tell_applied(const FrameNumbers& numbers);
  void take_back(std::uint32_t revision, const std::string& error);
  void autosave();

  // session_beside.cpp
  Json beside_message() const;
  void send_beside(PageId page, const Json& message);
  void broadcast_beside();
  void choose_beside(const std::string& name);
  void put_beside(const std::optional<BesideChoice>& choice);
  std::optional<ShownFrame> frame_beside(const Motion& motion);

  // session_paint.cpp
  PaintText read_paint_file(const std::string& key, const std::string& name) const;
  std::string why_no_paint() const;
  double most_painted(const rig::PaintKind& kind) const;
  Paints paints_after(const std::vector<scene::EditedTable>& after) const;
  std::vector<Painting> paintings_in_force() const;
  void paint(PageId page, const StrokePiece& piece);
  void end_stroke();
  void keep_stroke(const Stroke& stroke);
  void send_paint(std::optional<PageId> page);
  void send_sheet(const std::vector<Painting>& paintings, const rig::PaintKind& kind,
                  std::optional<PageId> page);
  std::string state_hash() const;

  // session_bakes.cpp
  void record();
  void bake(const Command& command);
  std::filesystem::path save(const Command& command, Json& answer);
  std::string text_in_folder(const std::map<std::string, std::string>& paint_names) const;
  std::map<std::string, std::string> paint_names(const std::string& stem) const;
  void save_paints(const std::map<std::string, std::string>& names, bool is_own_name, bool overwrite);

  const pipeline::Say say_;
  SessionOptions options_;
  std::string name_, source_;
  std::filesystem::path source_folder_, converter_;
  std::string scene_to_open_;  // for a bake: its scene's name on the command line
  std::string restored_;       // message about the restored session
  std::string base_hash_, base_text_;
  Paints base_paints_;
  bool is_live_ = false;
  std::optional<bake::FolderLock> lock_;
  // The last one makes new bodies. Bodies refer to theirs, also after it has failed. Grows on the builder's
  // thread only, under the mutex.
  std::list<pipeline::ChosenDevice> devices_;
  std::unique_ptr<Workshop> workshop_;  // the builder's thread only, after the constructor
  BodyLooks looks_;
  std::filesystem::path looks_of_;  // the file they were read from
  Publication prepared_;            // the builder's latest
  // Player's thread: depth of overlap between flesh, for the body with this number.
  std::optional<model::OverlapMeter> meter_;
  std::uint32_t meter_body_ = 0;
  std::unique_ptr<BesideBake> beside_;  // the player's thread only; replaced under the mutex

  mutable std::mutex mutex_;  // guards the members below
  Server* server_ = nullptr;
  std::map<PageId, Page> pages_;
  std::optional<PageId> hand_of_;
  std::optional<Vector3d> hand_place_;  // new target, not yet seen by the player
  bool release_waits_ = false;          // for the player
  std::optional<History> history_;
  std::vector<scene::EditedTable> tables_;  // of the current text
  std::uint32_t revision_ = 1;              // of the current text
  std::uint32_t built_ = 1;                 // taken up by the builder
  std::optional<Publication> next_;         // waiting for the player
  std::string running_text_;                // of the body on show
  Paints running_paints_;                   // likewise
  std::vector<PaintPlace> places_;          // can be painted on
  std::optional<Stroke> stroke_;
  std::string gpu_error_;     // why the player's GPU failed; empty once the builder has seen it
  bool awaits_cpu_ = false;   // the GPU failed, and pages know it; the body for the CPU is still to come
  bool resumes_ = false;      // playback was interrupted by that
  bool is_to_play_ = true;    // what a page last asked for: to play, or to pause
  bool bakes_ = false;        // a bake is waiting or running
  bool builds_anew_ = false;  // the builder's current work needs a new body
  std::vector<Pending> pending_;
  std::string saved_file_;                           // file name in the folder; empty: none
  std::string saved_hash_;                           // of the current text when last saved
  std::string saved_text_;                           // hash of the written text
  std::map<std::string, std::string> saved_paints_;  // likewise for paints, by key
  std::shared_ptr<RunningBody> body_;                // the one on show
  std::uint32_t body_number_ = 0;
  std::vector<ArrayMessage> arrays_;
  Json body_message_, clip_message_, warnings_message_;
  std::string player_message_;
  std::int64_t autosaved_ = 0;  // s since the epoch; 0: never

  std::condition_variable builder_wakes_;
  std::atomic<bool> stops_ = false;
  std::atomic<bool> stops_build_ = false;
  std::atomic<bool> stops_bake_ = false;
  std::unique_ptr<SessionWriter> writer_;
  std::unique_ptr<Player> player_;
  std::thread builder_;
};

// The hash of a scene's text and its paints.
std::string hash_of_all(std::string_view text, const Paints& paints);
// The name of a character's paint file for a scene called `stem`. `key`: the key that names the file.
std::string paint_name_of(const std::string& stem, const std::string& key);

}  // namespace fascicle::studio
