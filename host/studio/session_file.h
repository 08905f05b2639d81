// The session on disk: the scene's whole history, so that nothing is lost if the page or the program dies.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/studio/history.h"

namespace fascicle::studio {

inline constexpr const char* session_file_name = "session.json";
// An earlier session of another scene is renamed to this.
inline constexpr const char* old_session_file_name = "session.before.json";

struct SessionRecord {
  std::string source;     // Scene::source
  std::string base_hash;  // of the initial text
  std::vector<HistoryStep> steps;
  std::size_t at = 0;
  // The scene file saved last, the hash of the text at that time, and that of what was written; hashes of
  // written paints, by the keys that name their files.
  std::string saved_file = {}, saved_hash = {}, saved_text = {};
  std::map<std::string, std::string> saved_paints = {};
};

std::string session_text(const SessionRecord& record);
// Nullopt if the text is not a session. `own_file`: the name under which the scene is saved by default, which
// may begin with a dot.
std::optional<SessionRecord> parse_session(const std::string& text, const std::string& own_file = "");
// Nullopt if the folder has no usable session.
std::optional<SessionRecord> read_session(const std::filesystem::path& folder,
                                          const std::string& own_file = "");

// Writes the newest record, on its own thread: atomically, soon, but not at every step of a dragged slider.
class SessionWriter {
 public:
  // `told` is called on its thread after each write: empty, or the error.
  SessionWriter(std::filesystem::path folder, std::function<void(const std::string& error)> told);
  // Writes what is pending.
  ~SessionWriter();
  void put(SessionRecord record);

 private:
  void run();

  std::filesystem::path folder_;
  std::function<void(const std::string&)> told_;
  std::mutex mutex_;
  std::condition_variable wakes_;
  std::optional<SessionRecord> waiting_;
  bool stops_ = false;
  std::thread thread_;
};

}  // namespace fascicle::studio
