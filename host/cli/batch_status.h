// How the jobs of a batch stand, from what lies in its folders: it needs no scheduler, and may be asked on
// any host that sees them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/batch_summary.h"
#include "host/cli/command.h"

namespace fascicle::cli {

// One job as it stands. `row.status` says in a word what `text` says in a line.
struct JobState {
  SummaryRow row;
  std::string text;
};

// `job` has a name, a folder, and what is to be baked; `exit_status` and `error` of an earlier run may be
// known. All else comes from the bake's manifest and from the job's record, whichever is newer.
JobState state_of(const std::filesystem::path& output, SummaryRow job);

// The batch's exit status: of its first failure, else interrupted where one is not done.
ExitCode code_of(const std::vector<JobState>& jobs);

// fascicle batch status
CLI::App* add_batch_status(CLI::App& batch, Command& command);

}  // namespace fascicle::cli
