// A batch as a job of Slurm: an array of tasks, and a merge after it.
#pragma once

#include <filesystem>
#include <string>

#include "host/cli/farm_tasks.h"

namespace fascicle::cli {

// Whether the folder's batch was handed over already.
bool was_submitted(const std::filesystem::path& folder);

// Writes array.sbatch, merge.sbatch, submit, tasks and plan.json. `options` are the user's own of sbatch;
// they win over ours.
void write_slurm_job(const std::filesystem::path& folder, const FarmBatch& batch, const std::string& options);

// Runs the folder's `submit`. Throws std::runtime_error where Slurm refuses it or is not there.
void submit_slurm_job(const std::filesystem::path& folder);

}  // namespace fascicle::cli
