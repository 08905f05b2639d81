// Which jobs a batch has, whether its list, its folder of bakes or the folder of a scheduler's script is
// named.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/batch_summary.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {

// In the folder that --emit writes: the batch as it was when it was handed over.
inline constexpr const char* plan_file = "plan.json";

struct BatchPlan {
  std::filesystem::path folder = {};  // that --emit wrote; empty: another was named
  std::filesystem::path output = {};
  std::vector<scene::Job> jobs = {};
  std::vector<SummaryRow> known = {};  // from batch.json
};

// Of a list of jobs, of a folder with plan.json or of one with batch.json. Throws base::BakeError where there
// is neither, scene::SceneError for a list that cannot be read.
BatchPlan find_plan(const std::filesystem::path& path);

void write_plan(const std::filesystem::path& folder, const std::filesystem::path& list,
                const scene::Jobs& jobs);

// The jobs that --job names: names, numbers from 1 on, and ranges of numbers as 3-7, separated by commas. A
// job whose name reads as a number is found by its name. Throws UsageError.
std::vector<scene::Job> chosen_jobs(const std::vector<scene::Job>& jobs, const std::string& list);

}  // namespace fascicle::cli
