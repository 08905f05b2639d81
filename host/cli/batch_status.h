// The state of a batch's jobs, from the files in its folders. Needs no scheduler, and works on any host that
// sees the folders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/batch_summary.h"
#include "host/cli/command.h"

namespace fascicle::cli {

// The state of one job. `row.status` is one word, `text` a line.
struct JobState {
  SummaryRow row;
  std::string text = {};
  std::vector<std::string> unreadable = {};  // which of its files cannot be read, and why
};

// `job` must have its name, its folder and its settings. If batch.json, as written at this time, says how the
// job's last run ended, it also has its `exit_status`, `error` and `device`. The newest counts of that, the
// bake's manifest and the job's record. `summary_settings` is the settings_text() of its row there. A bake of
// other settings than the job's does not count as done.
JobState state_of(const std::filesystem::path& output, SummaryRow job,
                  std::optional<std::filesystem::file_time_type> summary_written,
                  const std::string& summary_settings = {});

// The batch's exit status: that of its first failure, or else `interrupted` if a job is not done.
ExitCode code_of(const std::vector<JobState>& jobs);

// fascicle batch status
CLI::App* add_batch_status(CLI::App& batch, Command& command);

}  // namespace fascicle::cli
