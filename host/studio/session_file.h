// The session on disk: every text that the scene has had, so that nothing is lost when page or program dies.
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
// What an earlier session of another scene is called from then on.
inline constexpr const char* old_session_file_name = "session.before.json";

struct SessionRecord {
  std::string source;     // Scene::source
  std::string base_hash;  // of the text that the session began with
  std::vector<HistoryStep> steps;
  std::size_t at = 0;
  // The scene file that was saved last, the hash of the text that was in force, and those of what was
  // written; of paints by the keys that name their files.
  std::string saved_file = {}, saved_hash = {}, saved_text = {};
  std::map<std::string, std::string> saved_paints = {};
};

std::string session_text(const SessionRecord& record);
// Nothing where the text is no session's.
std::optional<SessionRecord> parse_session(const std::string& text);
// Nothing where there is none in the folder, or it cannot be used.
std::optional<SessionRecord> read_session(const std::filesystem::path& folder);

// Writes the newest of what it is given, on a thread of its own: whole or not at all, and soon, but not at
// every step of a slider that is dragged.
class SessionWriter {
 public:
  // `told` is called on its thread after each writing: empty, or why it could not be written.
  SessionWriter(std::filesystem::path folder, std::function<void(const std::string& error)> told);
  // Writes what is left.
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
