#include "host/cli/batch_summary.h"

#include <nlohmann/json.hpp>

#include "host/bake/sealed_json.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/base/json_text.h"
#include "host/cli/exit_codes.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {

namespace {

using SummaryJson = nlohmann::ordered_json;

base::BakeError damaged(const std::filesystem::path& output) {
  return base::BakeError((output / scene::batch_summary).string() +
                         ": is damaged; give the list of jobs instead of the folder");
}

}  // namespace

void write_batch_summary(const std::filesystem::path& output, const std::vector<SummaryRow>& rows) {
  SummaryJson list = SummaryJson::array();
  for (const SummaryRow& row : rows)
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
    for (const SummaryJson& row : summary.at("jobs"))
      rows.push_back({.job = row.at("job"),
                      .folder = output / row.at("job").get<std::string>(),
                      .scene = row.at("scene"),
                      .clip = row.at("clip"),
                      .set = row.at("set"),
                      .formats = row.at("format"),
                      .device = row.at("device"),
                      .exit_status = row.at("exit_status").is_null() ? std::optional<int>()
                                                                     : row.at("exit_status").get<int>(),
                      .error = row.at("error")});
    return rows;
  } catch (const SummaryJson::exception&) {
    throw damaged(output);
  }
}

std::string word_of_status(int exit_status) {
  if (exit_status == static_cast<int>(ExitCode::done)) return "done";
  if (exit_status == static_cast<int>(ExitCode::interrupted)) return "interrupted";
  return "failed";
}

}  // namespace fascicle::cli
