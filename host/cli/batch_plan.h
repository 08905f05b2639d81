// Finds the jobs of a batch from its list, its folder of bakes or the folder of a scheduler's script.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/jobs.h"

namespace fascicle::cli {

// In the folder that --emit writes: the batch as it was submitted.
inline constexpr const char* plan_file = "plan.json";

struct BatchPlan {
  std::filesystem::path folder = {};  // written by --emit; empty if the path was something else
  std::filesystem::path output = {};
  std::vector<scene::Job> jobs = {};
};

// Reads a list of jobs, a folder with plan.json or one with batch.json. Throws base::BakeError if there is
// neither, scene::SceneError if the list cannot be read.
BatchPlan find_plan(const std::filesystem::path& path);

// Whether the folder has a plan.json that can be read.
bool holds_plan(const std::filesystem::path& folder);

// Throws UsageError for a path that plan.json or a template cannot hold: JSON is UTF-8.
void refuse_path_not_utf8(const std::filesystem::path& path);
void write_plan(const std::filesystem::path& folder, const std::filesystem::path& list,
                const scene::Jobs& jobs);

// The jobs that --job selects: names, numbers from 1 and ranges such as 3-7, separated by commas. A job whose
// name looks like a number is found by its name. Throws UsageError.
std::vector<scene::Job> chosen_jobs(const std::vector<scene::Job>& jobs, const std::string& list);

}  // namespace fascicle::cli
