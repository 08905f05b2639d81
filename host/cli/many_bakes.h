// Runs several bakes at once as separate processes on several devices, with a common progress display, and
// resumable as a whole: for fascicle batch and fascicle bake --clips.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/command.h"

namespace fascicle::cli {

struct OneBake {
  std::string name;   // name of its folder in the output folder
  std::string scene;  // in the form that `fascicle bake` takes
  std::string clip;   // for the summary, like the next line
  std::vector<std::string> set, formats;
  std::vector<std::string> options;  // of `fascicle bake`, except folder, device, --overwrite and --resume
  // Equal for bakes that share a model, which the first builds and caches for the others; empty: not cached.
  std::string model = {};
};

struct ManyBakes {
  std::filesystem::path output = {};
  std::vector<OneBake> bakes = {};
  std::string devices = "cpu";  // separated by commas, or "auto"
  unsigned at_once = 0;         // per device; 0: as many as help
  unsigned threads = 0;         // per bake on a CPU; 0: divide the cores among the parallel bakes
  bool overwrite = false, resume = false, dry_run = false;
  // Other processes bake other jobs of the batch. Each writes its own records (job_record.h), and the final
  // merge writes batch.json.
  bool is_part = false;
};

// Runs all bakes. Writes batch.json at the start, with nothing begun, and at the end. Returns the status of
// the first failure. Throws if nothing can start.
ExitCode bake_many(ManyBakes asked, Log& log);

// --at-once
CLI::Option* add_many_bakes_options(CLI::App& subcommand, unsigned& at_once);

}  // namespace fascicle::cli
