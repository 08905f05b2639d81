// Several bakes at once, each a process of its own, on several devices, with one view of all and resumable as
// a whole: what fascicle batch and fascicle bake --clips do.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/command.h"

namespace fascicle::cli {

struct OneBake {
  std::string name;   // of its folder in the output folder
  std::string scene;  // as `fascicle bake` takes it
  std::string clip;   // for the summary, as what follows
  std::vector<std::string> set, formats;
  std::vector<std::string> options;  // of `fascicle bake`, all but its folder, its device and how it begins
  // Alike of bakes whose model the first of them builds and keeps for the others; empty: nothing is kept.
  std::string model = {};
};

struct ManyBakes {
  std::filesystem::path output = {};
  std::vector<OneBake> bakes = {};
  std::string devices = "cpu";  // separated by commas, or "auto"
  unsigned at_once = 0;         // on each device; 0: as many as help
  unsigned threads = 0;         // of each bake on a CPU; 0: the cores shared among those at once
  bool overwrite = false, resume = false, dry_run = false;
  // Other processes bake other jobs of the batch: each leaves a record of its own (job_record.h), and
  // batch.json is written by who merges them.
  bool is_part = false;
};

// Bakes all and writes batch.json, first with nothing begun. The status is that of the first failure. Throws
// where nothing can begin.
ExitCode bake_many(ManyBakes asked, Log& log);

// --at-once
CLI::Option* add_many_bakes_options(CLI::App& subcommand, unsigned& at_once);

}  // namespace fascicle::cli
