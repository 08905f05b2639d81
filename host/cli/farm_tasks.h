// A batch cut into tasks for a farm, and what each task must be given.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/log.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {

struct FarmBatch {
  std::filesystem::path program, list, here;  // absolute; `here` is the folder that the command was given in
  scene::Jobs jobs;                           // its output absolute
  std::string device;
  unsigned threads = 0;
  unsigned at_once = 0;                              // tasks; 0: as many as the farm likes
  bool is_gpu = false;                               // the device
  std::vector<std::vector<std::string>> tasks = {};  // names of each one's jobs, one after the other
  double seconds = 0.0;                              // that the longest task may take
  std::uint64_t memory = 0;                          // bytes that a task may take
};

// What the tasks are made from. Jobs of one `model` share what the first of them builds.
struct FarmJob {
  std::string model;
  std::uint64_t frames = 0;
};

// Measures bakes of the batch's models on this machine, for at most about a minute, and cuts the batch into
// tasks: at most `group` jobs of one model each; 0: as many as take about two minutes. Fills in tasks,
// seconds and memory.
void cut_into_tasks(FarmBatch& batch, const std::vector<FarmJob>& jobs, unsigned group, Log& log);

// Throws UsageError for what cannot stand in a line of a script or of a template.
void refuse_control_characters(const std::string& what, const std::string& text);

}  // namespace fascicle::cli
