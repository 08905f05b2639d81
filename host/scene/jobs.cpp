#include "host/scene/jobs.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>
#include <system_error>

#include "host/base/file.h"
#include "host/rig/pose.h"
#include "host/scene/parse_toml.h"
#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// More would take weeks, and are surely a mistake.
constexpr std::size_t most_jobs = 10'000;
constexpr std::size_t longest_job_name = 200;
// Every job has its own copy of its texts, so without limits a small file could fill the memory. No honest
// list comes near them.
constexpr std::size_t longest_text = std::size_t{64} << 10;  // bytes
constexpr std::size_t most_text = std::size_t{64} << 20;     // bytes, of all jobs
constexpr const char* too_long = "has a text of more than 65,536 bytes; write long values into a scene file";
// For a folder, whose name may also get a job's name as prefix and numbers as suffix.
constexpr std::size_t longest_clip_name = 80;

void check_keys(const toml::table& table, const std::string& path, const std::vector<std::string>& names) {
  for (const auto& [key, node] : table)
    if (std::find(names.begin(), names.end(), key.str()) == names.end())
      fail_unknown(key.source(), path, key.str(), names);
}

std::string text_at(const toml::table& table, const std::string& path, const char* key) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return {};
  const auto text = node->value<std::string>();
  if (!node->is_string() || text->empty()) fail(node->source(), join_path(path, key), "takes a text");
  if (text->size() > longest_text) fail(node->source(), join_path(path, key), too_long);
  return *text;
}

std::vector<std::string> texts_at(const toml::table& table, const std::string& path, const char* key) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  std::vector<std::string> texts;
  if (array != nullptr)
    for (const toml::node& entry : *array)
      if (entry.is_string()) texts.push_back(*entry.value<std::string>());
  if (array == nullptr || texts.size() != array->size() || texts.empty())
    fail(node->source(), join_path(path, key), "takes a list of texts, one or more");
  if (std::any_of(texts.begin(), texts.end(), [](const auto& text) { return text.size() > longest_text; }))
    fail(node->source(), join_path(path, key), too_long);
  return texts;
}

bool flag_at(const toml::table& table, const std::string& path, const char* key, bool otherwise) {
  const toml::node* node = table.get(key);
  if (node == nullptr) return otherwise;
  const std::optional<bool> value = node->value_exact<bool>();
  if (!value) fail(node->source(), join_path(path, key), "takes true or false");
  return *value;
}

const toml::table& table_of(const toml::node& node, const std::string& path) {
  if (!node.is_table()) fail(node.source(), path, "is a table: [" + path + "]");
  return *node.as_table();
}

// In the form that `--set` takes.
std::string value_text(const toml::node& value) {
  if (value.is_floating_point()) return shortest(*value.value<double>());
  if (const toml::array* values = value.as_array()) {
    std::string text;
    for (const toml::node& one : *values) text += (text.empty() ? "" : ", ") + value_text(one);
    return "[" + text + "]";
  }
  std::ostringstream out;
  value.visit([&out](const auto& v) { out << toml::toml_formatter{v}; });
  // toml++ breaks a long table into several lines.
  std::string text = out.str();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return text;
}

std::string in_lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool every_file_system_allows(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
}

// Keeps the characters that every file system allows in a name.
std::string file_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool kept = every_file_system_allows(c);
    if (kept) name += c;
    if (!kept && c != '"' && !name.empty() && name.back() != '_') name += '_';
  }
  if (text.ends_with(']') && name.ends_with('_')) name.pop_back();
  return name;
}

// Jobs, and the memory that they take.
struct MadeJobs {
  std::vector<Job> jobs = {};
  std::size_t bytes = 0;
};

std::size_t bytes_of(const std::vector<std::string>& texts) {
  std::size_t bytes = 0;
  for (const std::string& text : texts) bytes += sizeof text + text.size();
  return bytes;
}

std::size_t bytes_of(const Job& job) {
  return sizeof job + job.name.size() + job.scene.size() + job.clip.size() + bytes_of(job.set) +
         bytes_of(job.formats);
}

// Before they are made: whether the list may have these jobs besides those of earlier tables.
void check_total(const toml::node& node, const std::string& path, const MadeJobs& before, std::size_t jobs,
                 std::size_t bytes) {
  if (jobs > most_jobs - before.jobs.size())
    fail(node.source(), path, "makes more than 10,000 bakes; make several lists");
  if (bytes > most_text - before.bytes)
    fail(node.source(), path,
         "makes bakes with more than 64 MiB of text in all; shorten it, or make several lists");
}

// Makes one copy of each job for each value of another key.
void vary(const toml::key& key, const toml::node& node, const std::string& path, const MadeJobs& before,
          MadeJobs& made) {
  const toml::array* values = node.as_array();
  if (values == nullptr || values->empty())
    fail(node.source(), join_path(path, key.str()), "takes a list of values, one or more");
  check_total(node, path, before, made.jobs.size() * values->size(), made.bytes);
  struct Value {
    std::string setting, name;
  };
  std::vector<Value> taken;
  std::size_t bytes = made.bytes * values->size();
  for (const toml::node& value : *values) {
    const std::string text = value_text(value);
    taken.push_back(
        {std::string(key.str()) + "=" + text, values->size() > 1 ? "-" + file_name(text) : std::string()});
    const Value& one = taken.back();
    if (one.setting.size() > longest_text) fail(value.source(), join_path(path, key.str()), too_long);
    bytes += made.jobs.size() * (sizeof one.setting + one.setting.size() + one.name.size());
  }
  check_total(node, path, before, made.jobs.size() * values->size(), bytes);
  made.bytes = bytes;
  if (taken.size() == 1) {
    // With many such keys, copying the jobs for each would take long.
    for (Job& job : made.jobs) job.set.push_back(taken.front().setting);
    return;
  }
  std::vector<Job> all;
  for (const Job& job : made.jobs)
    for (const Value& one : taken) {
      all.push_back(job);
      all.back().set.push_back(one.setting);
      all.back().name += one.name;
    }
  made.jobs = std::move(all);
}

// The clips that `clips` names. For "all", reads the character.
std::vector<NamedClip> clips_of(const toml::table& table, const std::string& path, const Job& job) {
  const toml::node* node = table.get("clips");
  if (node == nullptr) return {};
  std::vector<std::string> wanted;
  if (const auto text = node->value<std::string>()) {
    if (*text != "all") fail(node->source(), join_path(path, "clips"), "takes a list of texts, or \"all\"");
    wanted = {*text};
  } else {
    wanted = texts_at(table, path, "clips");
    if (wanted.size() > most_jobs)
      fail(node->source(), join_path(path, "clips"), "makes more than 10,000 bakes; make several lists");
  }
  if (wanted != std::vector<std::string>{"all"}) {
    std::vector<NamedClip> clips;
    for (const std::string& clip : wanted) clips.push_back({clip, file_name(clip)});
    return clips;
  }
  SceneOverrides overrides;
  overrides.set = job.set;
  try {
    const Scene scene = load_scene(job.scene, overrides);
    const auto* character = std::get_if<rig::Character>(&scene.geometry);
    if (character == nullptr || !scene.characters.empty())
      throw SceneError("\"all\" needs a single character, and " + job.scene + " is not one");
    return named_clips(*character, wanted);
  } catch (const SceneError& error) {
    fail(node->source(), join_path(path, "clips"), error.what());
  }
}

MadeJobs jobs_of(const std::string& name, const toml::table& table, const std::filesystem::path& folder,
                 const Job& of_all, const MadeJobs& before) {
  if (name.size() > longest_text) fail(table.source(), "job", too_long);
  const std::string path = join_path("job", name);
  check_keys(table, path, {"scene", "clips", "set", "format", "keep_frames", "vary"});
  Job job{.name = file_name(name),
          .scene = text_at(table, path, "scene"),
          .clip = {},
          .set = texts_at(table, path, "set"),
          .formats = texts_at(table, path, "format"),
          .keep_frames = flag_at(table, path, "keep_frames", of_all.keep_frames)};
  if (job.scene.empty()) fail(table.source(), path, "lacks scene");
  if (job.name.empty())
    fail(table.source(), path, "has a name that cannot be a file name; use letters and digits");
  std::error_code none;
  if (std::filesystem::is_regular_file(folder / job.scene, none)) job.scene = (folder / job.scene).string();
  if (job.formats.empty()) job.formats = of_all.formats;

  const std::vector<NamedClip> clips = clips_of(table, path, job);
  MadeJobs made{.bytes = bytes_of(job) * std::max<std::size_t>(clips.size(), 1)};
  for (const NamedClip& clip : clips) made.bytes += clip.clip.size() + clip.file_name.size() + 1;
  check_total(table, path, before, std::max<std::size_t>(clips.size(), 1), made.bytes);
  for (const NamedClip& clip : clips) {
    made.jobs.push_back(job);
    made.jobs.back().clip = clip.clip;
    if (clips.size() > 1) made.jobs.back().name += "-" + clip.file_name;
  }
  if (clips.empty()) made.jobs.push_back(job);
  if (const toml::node* values = table.get("vary")) {
    const std::string path_of_values = join_path(path, "vary");
    for (const auto& [key, node] : in_order(table_of(*values, path_of_values)))
      vary(*key, *node, path_of_values, before, made);
  }
  return made;
}

toml::table parse(const std::filesystem::path& file) {
  try {
    return parse_toml(base::read_input(file, most_toml_bytes), file.string());
  } catch (const base::InputError& error) {
    throw SceneError(std::string(error.what()) + "; give a list of jobs (see fascicle batch --help)");
  }
}

}  // namespace

bool is_job_name(std::string_view name) {
  return !name.empty() && name.front() != '.' && name.size() <= longest_job_name && name != batch_summary &&
         std::all_of(name.begin(), name.end(), every_file_system_allows);
}

Jobs read_jobs(const std::filesystem::path& file) {
  const toml::table root = parse(file);
  check_keys(root, "", {"output", "format", "keep_frames", "job"});
  Jobs jobs;
  jobs.output = text_at(root, "", "output");
  if (jobs.output.empty()) jobs.output = std::filesystem::path("out") / file.stem();
  Job of_all;
  of_all.formats = texts_at(root, "", "format");
  of_all.keep_frames = flag_at(root, "", "keep_frames", true);
  const toml::node* list = root.get("job");
  if (list == nullptr) fail(root.source(), "job", "is missing; give at least one [job.NAME]");
  std::set<std::string> names;  // in lower case, since some file systems ignore case
  MadeJobs all;
  for (const auto& [name, node] : in_order(table_of(*list, "job"))) {
    const std::string path = join_path("job", name->str());
    MadeJobs made = jobs_of(std::string(name->str()), table_of(*node, path), file.parent_path(), of_all, all);
    all.bytes += made.bytes;
    for (Job& job : made.jobs) {
      if (!is_job_name(job.name))
        fail(name->source(), path,
             "makes a bake called " + job.name.substr(0, longest_job_name) +
                 ", which cannot be a folder name; choose another, of at most 200 characters");
      if (!names.insert(in_lower_case(job.name)).second)
        fail(name->source(), path, "makes a second bake called " + job.name + "; give it another name");
      all.jobs.push_back(std::move(job));
    }
  }
  if (all.jobs.empty()) fail(list->source(), "job", "is empty; give at least one [job.NAME]");
  jobs.jobs = std::move(all.jobs);
  return jobs;
}

std::vector<NamedClip> named_clips(const rig::Character& character, const std::vector<std::string>& wanted) {
  if (character.clips.empty()) throw SceneError("clips: the character has none");
  std::vector<const rig::Clip*> clips;
  if (wanted == std::vector<std::string>{"all"})
    for (const rig::Clip& clip : character.clips) clips.push_back(&clip);
  else
    for (const std::string& name : wanted) {
      const rig::Clip* clip = rig::find_clip(character, name);
      if (std::find(clips.begin(), clips.end(), clip) != clips.end())
        throw SceneError("clips: `" + name + "` is listed twice");
      clips.push_back(clip);
    }
  const auto number_of = [&](const rig::Clip* clip) {
    return std::to_string(static_cast<std::size_t>(clip - character.clips.data()));
  };
  // The name if it finds this clip again. It does not if another clip has the same name or the name is a
  // number, and --clip would strip the quotes from a quoted name.
  const auto text_of = [&](const rig::Clip* clip) {
    const std::size_t first = clip->name.find_first_not_of(' ');
    const bool is_quoted =
        first != std::string::npos && (clip->name[first] == '"' || clip->name[first] == '\'');
    const bool is_plain = !is_quoted && std::none_of(clip->name.begin(), clip->name.end(), [](char c) {
      return std::iscntrl(static_cast<unsigned char>(c)) != 0;
    });
    return !clip->name.empty() && is_plain && rig::find_clip(character, clip->name) == clip ? clip->name
                                                                                            : number_of(clip);
  };
  const auto short_name = [](const rig::Clip* clip) {
    return file_name(clip->name.substr(clip->name.find_last_of("|:/") + 1));
  };
  std::map<std::string, std::size_t> count;
  for (const rig::Clip* clip : clips) ++count[in_lower_case(short_name(clip))];
  std::set<std::string> taken{batch_summary};
  std::vector<NamedClip> named;
  for (const rig::Clip* clip : clips) {
    std::string name = short_name(clip).substr(0, longest_clip_name);
    if (name.empty() || name.front() == '.') name.insert(0, "clip");
    // The number distinguishes clips of the same name, and completes a name that cannot be a file's.
    std::string folder = name;
    if (name != short_name(clip) || count[in_lower_case(name)] > 1) folder += "-" + number_of(clip);
    while (!taken.insert(in_lower_case(folder)).second) folder += "-" + number_of(clip);
    named.push_back({text_of(clip), folder});
  }
  return named;
}

}  // namespace fascicle::scene
