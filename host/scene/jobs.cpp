#include "host/scene/jobs.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "host/scene/scene_check.h"

namespace fascicle::scene {
namespace {

// More are a slip, and would take weeks.
constexpr std::size_t most_jobs = 10'000;
constexpr std::size_t longest_job_name = 200;

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
  return texts;
}

const toml::table& table_of(const toml::node& node, const std::string& path) {
  if (!node.is_table()) fail(node.source(), path, "is a table: [" + path + "]");
  return *node.as_table();
}

// As `--set` takes it.
std::string value_text(const toml::node& value) {
  if (value.is_floating_point()) return shortest(*value.value<double>());
  std::ostringstream out;
  value.visit([&out](const auto& v) { out << toml::toml_formatter{v}; });
  return one_line(out.str());
}

// What can stand in a file's name on any system.
std::string file_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
    if (kept) name += c;
    if (!kept && c != '"' && !name.empty() && name.back() != '_') name += '_';
  }
  return name;
}

// Each job once for each value of one more key.
std::vector<Job> varied(const std::vector<Job>& jobs, const toml::key& key, const toml::node& node,
                        const std::string& path) {
  const toml::array* values = node.as_array();
  if (values == nullptr || values->empty())
    fail(node.source(), join_path(path, key.str()), "takes a list of values, one or more");
  std::vector<Job> all;
  for (const Job& job : jobs)
    for (const toml::node& value : *values) {
      Job one = job;
      one.set.push_back(std::string(key.str()) + "=" + value_text(value));
      if (values->size() > 1) one.name += "-" + file_name(value_text(value));
      all.push_back(std::move(one));
    }
  if (all.size() > most_jobs) fail(node.source(), path, "makes more than 10,000 bakes");
  return all;
}

std::vector<Job> jobs_of(const std::string& name, const toml::table& table,
                         const std::filesystem::path& folder, const std::vector<std::string>& formats) {
  const std::string path = join_path("job", name);
  check_keys(table, path, {"scene", "clips", "set", "format", "vary"});
  Job job{.name = file_name(name),
          .scene = text_at(table, path, "scene"),
          .clip = {},
          .set = texts_at(table, path, "set"),
          .formats = texts_at(table, path, "format")};
  if (job.scene.empty()) fail(table.source(), path, "lacks scene");
  if (job.name.empty())
    fail(table.source(), path, "has a name that cannot be a file's; use letters and digits");
  if (std::filesystem::is_regular_file(folder / job.scene)) job.scene = (folder / job.scene).string();
  if (job.formats.empty()) job.formats = formats;

  const std::vector<std::string> clips = texts_at(table, path, "clips");
  std::vector<Job> jobs;
  for (const std::string& clip : clips) {
    jobs.push_back(job);
    jobs.back().clip = clip;
    if (clips.size() > 1) jobs.back().name += "-" + file_name(clip);
  }
  if (clips.empty()) jobs.push_back(job);
  if (const toml::node* vary = table.get("vary"))
    for (const auto& [key, node] : in_order(table_of(*vary, join_path(path, "vary"))))
      jobs = varied(jobs, *key, *node, join_path(path, "vary"));
  return jobs;
}

toml::table parse(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw SceneError(file.string() + ": cannot be read; give a list of jobs (see fascicle batch --help)");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    fail(error.source(), "TOML", error.description());
  }
}

}  // namespace

Jobs read_jobs(const std::filesystem::path& file) {
  const toml::table root = parse(file);
  check_keys(root, "", {"output", "format", "job"});
  Jobs jobs;
  jobs.output = text_at(root, "", "output");
  if (jobs.output.empty()) jobs.output = std::filesystem::path("out") / file.stem();
  const std::vector<std::string> formats = texts_at(root, "", "format");
  const toml::node* list = root.get("job");
  if (list == nullptr) fail(root.source(), "job", "is missing; give at least one [job.NAME]");
  std::set<std::string> names;  // in lower case: some file systems have one folder for both
  for (const auto& [name, node] : in_order(table_of(*list, "job"))) {
    const std::string path = join_path("job", name->str());
    for (Job& job : jobs_of(std::string(name->str()), table_of(*node, path), file.parent_path(), formats)) {
      if (job.name.front() == '.' || job.name.size() > longest_job_name || job.name == batch_summary)
        fail(name->source(), path,
             "makes a bake called " + job.name +
                 ", which cannot be the name of its folder; choose another, of at most 200 letters");
      std::string lower = job.name;
      for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (!names.insert(lower).second)
        fail(name->source(), path, "makes a second bake called " + job.name + "; name it otherwise");
      jobs.jobs.push_back(std::move(job));
    }
  }
  if (jobs.jobs.empty()) fail(list->source(), "job", "is empty; give at least one [job.NAME]");
  if (jobs.jobs.size() > most_jobs) fail(list->source(), "job", "makes more than 10,000 bakes");
  return jobs;
}

}  // namespace fascicle::scene
