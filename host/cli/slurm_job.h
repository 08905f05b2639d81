// Writes a batch as a Slurm job: an array of tasks, followed by a merge.
#pragma once

#include <filesystem>
#include <string>

#include "host/cli/farm_tasks.h"

namespace fascicle::cli {

// Whether the folder's batch has already been submitted.
bool was_submitted(const std::filesystem::path& folder);

// Throws UsageError if the folder holds a file that write_slurm_job replaces or removes, and no plan.json
// says that an earlier batch wrote it.
void refuse_others_slurm_files(const std::filesystem::path& folder);

// Writes array.sbatch, merge.sbatch, submit, tasks and plan.json. `options` are the user's options for
// sbatch; they override ours.
void write_slurm_job(const std::filesystem::path& folder, const FarmBatch& batch, const std::string& options);

// Runs the folder's `submit`. Throws std::runtime_error if Slurm rejects it or is missing.
void submit_slurm_job(const std::filesystem::path& folder);

}  // namespace fascicle::cli
