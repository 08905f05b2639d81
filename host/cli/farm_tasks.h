// Splits a batch into tasks for a farm, and determines the resources of each task.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/log.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {

struct FarmBatch {
  std::filesystem::path program, list, here;  // absolute; `here` is the folder where the command was run
  scene::Jobs jobs;                           // with an absolute output
  std::string device;
  unsigned threads = 0;
  unsigned at_once = 0;                              // tasks; 0: up to the farm
  bool is_gpu = false;                               // whether `device` is one
  std::vector<std::vector<std::string>> tasks = {};  // the names of each task's jobs, run in sequence
  double seconds = 0.0;                              // time limit for the longest task
  std::uint64_t memory = 0;                          // bytes per task
};

// What the tasks are made from. Jobs with the same `model` share what the first of them builds.
struct FarmJob {
  std::string model;
  std::uint64_t frames = 0;
};

// Measures bakes of the batch's models on this machine, for about a minute at most, and splits the batch into
// tasks. A task has at most `group` jobs of one model; 0: as many as take about two minutes. Sets tasks,
// seconds and memory.
void cut_into_tasks(FarmBatch& batch, const std::vector<FarmJob>& jobs, unsigned group, Log& log);

// Throws UsageError for text that a line of a script or a template cannot hold.
void refuse_control_characters(const std::string& what, const std::string& text);

}  // namespace fascicle::cli
