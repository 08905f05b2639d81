#include "host/cli/batch_plan.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/json_text.h"
#include "host/base/nearest_name.h"
#include "host/base/text.h"
#include "host/cli/batch_summary.h"
#include "host/cli/exit_codes.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using PlanJson = nlohmann::ordered_json;

base::BakeError damaged_plan(const fs::path& folder, const std::string& why = {}) {
  return base::BakeError((folder / plan_file).string() + ": is damaged" + why +
                         "; give the list of jobs instead of the folder");
}

BatchPlan read_plan(const fs::path& folder) {
  const std::string text = base::read_input(folder / plan_file, base::most_json_bytes);
  try {
    const PlanJson json = PlanJson::parse(base::shallow_json(text));
    BatchPlan plan{.folder = folder, .output = json.at("output").get<std::string>()};
    for (const PlanJson& job : json.at("jobs")) {
      plan.jobs.push_back({job.at("job"), job.at("scene"), job.at("clip"), job.at("set"), job.at("format")});
      // The plan may come from a stranger, and a job's name becomes a path.
      if (const std::string& name = plan.jobs.back().name; !scene::is_job_name(name))
        throw damaged_plan(folder, ": \"" + base::shown_text(name.substr(0, 200)) + "\" is not a job's name");
    }
    return plan;
  } catch (const PlanJson::exception&) {
    throw damaged_plan(folder);
  }
}

std::optional<std::size_t> number_of(std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

BatchPlan find_plan(const fs::path& path) {
  if (!fs::is_directory(path)) {
    scene::Jobs jobs = scene::read_jobs(path);
    return {.output = std::move(jobs.output), .jobs = std::move(jobs.jobs)};
  }
  if (fs::exists(path / plan_file)) return read_plan(path);
  const std::optional<std::vector<SummaryRow>> known = read_batch_summary(path);
  if (!known)
    throw base::BakeError(path.string() + ": contains neither " + scene::batch_summary + " nor " + plan_file +
                          ", so no batch was started there; give its list of jobs");
  BatchPlan plan{.output = path};
  for (const SummaryRow& row : *known)
    plan.jobs.push_back({row.job, row.scene, row.clip, row.set, row.formats});
  return plan;
}

bool holds_plan(const fs::path& folder) {
  if (!fs::exists(folder / plan_file)) return false;
  try {
    read_plan(folder);
    return true;
  } catch (const base::BakeError&) {
    return false;
  } catch (const base::SceneError&) {
    return false;
  }
}

void refuse_path_not_utf8(const fs::path& path) {
  const std::string text = path.string();
  for (std::string_view rest = text; !rest.empty();)
    if (!base::take_code_point(rest))
      throw UsageError(text +
                       ": this path is not UTF-8, which --emit cannot write down; rename the folder or file");
}

void write_plan(const fs::path& folder, const fs::path& list, const scene::Jobs& jobs) {
  PlanJson rows = PlanJson::array();
  for (const scene::Job& job : jobs.jobs)
    rows.push_back({{"job", job.name},
                    {"scene", job.scene},
                    {"clip", job.clip},
                    {"set", job.set},
                    {"format", job.formats}});
  const PlanJson plan{{"list", list.string()}, {"output", jobs.output.string()}, {"jobs", rows}};
  base::write_whole(folder / plan_file, plan.dump(2, ' ', false, PlanJson::error_handler_t::replace) + "\n");
}

std::vector<scene::Job> chosen_jobs(const std::vector<scene::Job>& jobs, const std::string& list) {
  std::vector<scene::Job> chosen;
  const auto add = [&](const scene::Job& job) {
    if (std::none_of(chosen.begin(), chosen.end(), [&](const auto& other) { return other.name == job.name; }))
      chosen.push_back(job);
  };
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) {
    const auto named =
        std::find_if(jobs.begin(), jobs.end(), [&](const auto& job) { return job.name == word; });
    if (named != jobs.end()) {
      add(*named);
      continue;
    }
    const std::size_t dash = word.find('-');
    const std::optional<std::size_t> first = number_of(std::string_view(word).substr(0, dash));
    const std::optional<std::size_t> last =
        dash == std::string::npos ? first : number_of(std::string_view(word).substr(dash + 1));
    if (first && last && *first >= 1 && *first <= *last && *last <= jobs.size()) {
      for (std::size_t k = *first; k <= *last; ++k) add(jobs[k - 1]);
      continue;
    }
    std::vector<std::string> names;
    for (const scene::Job& job : jobs) names.push_back(job.name);
    const std::string hint = base::nearest_name_hint(word, names);
    throw UsageError("--job: there is no job \"" + word + "\" among the " + std::to_string(jobs.size()) +
                     (hint.empty() ? "; --dry-run lists them" : hint));
  }
  if (chosen.empty()) throw UsageError("--job: no job given");
  return chosen;
}

}  // namespace fascicle::cli
