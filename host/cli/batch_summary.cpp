#include "host/cli/batch_summary.h"

#include <nlohmann/json.hpp>

#include "host/bake/sealed_json.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/json_text.h"
#include "host/base/text.h"
#include "host/cli/exit_codes.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {

namespace {

using SummaryJson = nlohmann::ordered_json;

// `why` is empty or ends the sentence.
base::BakeError damaged(const std::filesystem::path& output, const std::string& why = {}) {
  return base::BakeError((output / scene::batch_summary).string() + ": is damaged" + why +
                         "; give the list of jobs instead of the folder");
}

SummaryRow row_of(const SummaryJson& json, const std::filesystem::path& output) {
  const std::string job = json.at("job");
  if (!scene::is_job_name(job))
    throw damaged(output, ": \"" + base::shown_text(job.substr(0, 200)) + "\" is not a job's name");
  const SummaryJson& status = json.at("exit_status");
  if (!status.is_null() && !is_exit_status(status))
    throw damaged(output, ": the exit status of " + job + " is not one of 0 to 255");
  return {.job = job,
          .folder = output / job,
          .scene = json.at("scene"),
          .clip = json.at("clip"),
          .set = json.at("set"),
          .formats = json.at("format"),
          .device = json.at("device"),
          .exit_status = status.is_null() ? std::optional<int>() : status.get<int>(),
          .error = json.at("error"),
          .baked = json.value("baked", "")};
}

}  // namespace

void write_batch_summary(const std::filesystem::path& output, const std::vector<SummaryRow>& rows) {
  SummaryJson list = SummaryJson::array();
  for (const SummaryRow& row : rows) {
    list.push_back({{"job", row.job},
                    {"folder", row.folder.string()},
                    {"scene", row.scene},
                    {"clip", row.clip},
                    {"set", row.set},
                    {"format", row.formats},
                    {"device", row.device},
                    {"status", row.status},
                    {"exit_status", row.exit_status ? SummaryJson(*row.exit_status) : SummaryJson()},
                    {"seconds", row.seconds},
                    {"last_position_hash", row.hash},
                    {"error", row.error},
                    {"warnings", row.warnings}});
    if (!row.baked.empty()) list.back()["baked"] = row.baked;
  }
  // Several processes may merge at once, so the temporary file needs a unique name.
  base::write_whole_beside_others(
      output / scene::batch_summary,
      bake::sealed_text({{"version", bake::sealed_json_version}, {"jobs", std::move(list)}}, 2) + "\n");
}

std::optional<std::vector<SummaryRow>> read_batch_summary(const std::filesystem::path& output) {
  const std::optional<std::string> text =
      base::read_input_if_there(output / scene::batch_summary, base::most_json_bytes);
  if (!text) return std::nullopt;
  try {
    std::vector<SummaryRow> rows;
    const SummaryJson summary = SummaryJson::parse(base::shallow_json(*text));
    if (!summary.is_object() || bake::is_damaged(summary)) throw damaged(output);
    for (const SummaryJson& row : summary.at("jobs")) rows.push_back(row_of(row, output));
    if (rows.empty()) throw damaged(output, ": it lists no jobs");
    return rows;
  } catch (const SummaryJson::exception&) {
    throw damaged(output);
  }
}

std::string settings_of_bake(const SummaryRow& row) {
  if (!row.baked.empty()) return row.baked;
  return row.exit_status ? settings_text(row) : std::string();
}

void refuse_foreign_summary(const std::filesystem::path& output, const std::string& remedy) {
  const auto refuse = [&](const std::string& why) {
    throw base::BakeError((output / scene::batch_summary).string() + ": would be replaced, but " + why +
                          "; " + remedy);
  };
  try {
    (void)read_batch_summary(output);
  } catch (const base::BakeError&) {
    refuse("is damaged or of another program");
  } catch (const base::InputError& error) {
    refuse(error.reason);
  }
}

std::string word_of_status(int exit_status) {
  if (exit_status == static_cast<int>(ExitCode::done)) return "done";
  if (exit_status == static_cast<int>(ExitCode::interrupted)) return "interrupted";
  return "failed";
}

ExitCode code_of_failure(int exit_status) {
  const bool is_ours = exit_status > static_cast<int>(ExitCode::done) &&
                       exit_status <= static_cast<int>(ExitCode::device_failed);
  return is_ours ? static_cast<ExitCode>(exit_status) : ExitCode::unforeseen;
}

}  // namespace fascicle::cli
