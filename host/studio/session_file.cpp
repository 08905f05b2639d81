#include "host/studio/session_file.h"

#include <chrono>
#include <map>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "host/base/file.h"
#include "host/base/json_number.h"
#include "host/base/json_text.h"
#include "host/scene/paint_file.h"
#include "host/scene/scene_json.h"
#include "host/studio/commands.h"
#include "host/studio/scene_keys.h"

namespace fascicle::studio {

using scene::Json;

namespace {

// 2: paint on several characters.
constexpr int version = 2;
constexpr const char* version_key = "fascicle_studio";
constexpr auto pace = std::chrono::milliseconds(100);
// Painted characters in a step. The file may be a stranger's: many keys can name one large paint, and each
// key of an object is compared with all before it.
constexpr unsigned most_painted = 256;

// "character.paint" or "character.NAME.paint".
bool names_a_paint(std::string_view key) {
  constexpr std::string_view before = "character.", after = ".paint";
  if (key == paint_path) return true;
  return key.size() > before.size() + after.size() && key.starts_with(before) && key.ends_with(after) &&
         is_plain_name(key.substr(before.size(), key.size() - before.size() - after.size()));
}

// A scene file in the session's folder. A scene's own name may have characters that a page may not choose.
bool names_a_scene_file(std::string_view name, std::string_view own_file) {
  constexpr std::string_view extension = ".toml";
  constexpr std::size_t longest = 255;
  return name.size() > extension.size() && name.size() <= longest && name.ends_with(extension) &&
         (name.front() != '.' || name == own_file) && name.find('/') == std::string_view::npos &&
         name.find('\0') == std::string_view::npos;
}

}  // namespace

std::string session_text(const SessionRecord& record) {
  Json steps = Json::array(), paints = Json::array();
  std::map<const std::string*, std::size_t> number_of;
  for (const HistoryStep& step : record.steps) {
    steps.push_back({{"label", step.label}, {"text", step.text}, {"built", step.is_built}});
    for (const auto& [key, paint] : step.paints) {
      const auto [known, is_new] = number_of.try_emplace(paint.get(), paints.size());
      if (is_new) paints.push_back(*paint);
      steps.back()["paint"][key] = known->second;
    }
  }
  return scene::dump({{version_key, version},
                      {"source", record.source},
                      {"base_hash", record.base_hash},
                      {"at", record.at},
                      {"saved_file", record.saved_file},
                      {"saved_hash", record.saved_hash},
                      {"saved_text", record.saved_text},
                      {"saved_paints", record.saved_paints},
                      {"paints", std::move(paints)},
                      {"steps", std::move(steps)}},
                     1);
}

std::optional<SessionRecord> parse_session(const std::string& text, const std::string& own_file) {
  try {
    const Json json = Json::parse(base::shallow_json(text, most_painted));
    if (json.at(version_key) != version) return std::nullopt;
    SessionRecord record;
    record.source = json.at("source").get<std::string>();
    record.base_hash = json.at("base_hash").get<std::string>();
    const auto at = base::whole_number<std::size_t>(json.at("at"));
    if (!at) return std::nullopt;
    record.at = *at;
    record.saved_file = json.at("saved_file").get<std::string>();
    record.saved_hash = json.at("saved_hash").get<std::string>();
    record.saved_text = json.at("saved_text").get<std::string>();
    record.saved_paints = json.value("saved_paints", record.saved_paints);
    std::vector<PaintText> paints;
    for (const Json& paint : json.value("paints", Json::array())) {
      paints.push_back(std::make_shared<const std::string>(paint.get<std::string>()));
      if (paints.back()->size() > scene::most_paint_bytes) return std::nullopt;
    }
    for (const Json& step : json.at("steps")) {
      // Sessions of older programs do not say what was built.
      record.steps.push_back({step.at("label").get<std::string>(),
                              step.at("text").get<std::string>(),
                              {},
                              step.value("built", true)});
      if (!step.contains("paint")) continue;
      for (const auto& [key, of_key] : step["paint"].items()) {
        const auto number = base::whole_number<std::size_t>(of_key);
        if (!number || *number >= paints.size()) return std::nullopt;
        // File names are made from the key.
        if (!names_a_paint(key)) return std::nullopt;
        record.steps.back().paints[key] = paints[*number];
      }
    }
    if (record.at >= record.steps.size()) return std::nullopt;
    // The session writes to this file, so a session file from elsewhere must not name one outside the folder.
    if (!record.saved_file.empty() && !names_a_scene_file(record.saved_file, own_file)) return std::nullopt;
    return record;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<SessionRecord> read_session(const std::filesystem::path& folder, const std::string& own_file) {
  const std::optional<std::string> text =
      base::read_input_if_there(folder / session_file_name, base::most_json_bytes);
  return text ? parse_session(*text, own_file) : std::nullopt;
}

SessionWriter::SessionWriter(std::filesystem::path folder, std::function<void(const std::string&)> told)
    : folder_(std::move(folder)), told_(std::move(told)), thread_([this] { run(); }) {}

SessionWriter::~SessionWriter() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  wakes_.notify_all();
  thread_.join();
}

void SessionWriter::put(SessionRecord record) {
  {
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(record);
  }
  wakes_.notify_all();
}

void SessionWriter::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wakes_.wait(lock, [this] { return stops_ || waiting_; });
    if (!waiting_) return;
    const SessionRecord record = *std::exchange(waiting_, std::nullopt);
    lock.unlock();
    std::string error;
    try {
      base::write_whole(folder_ / session_file_name, session_text(record));
    } catch (const std::exception& failure) {
      error = failure.what();
    }
    if (told_) told_(error);
    lock.lock();
    wakes_.wait_for(lock, pace, [this] { return stops_; });
  }
}

}  // namespace fascicle::studio
