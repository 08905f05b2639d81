// batch.json: the result of each job of a batch.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::cli {

// One job. `status` is done, running, interrupted, cut off, failed or not begun.
struct SummaryRow {
  std::string job;
  std::filesystem::path folder;
  std::string scene, clip;
  std::vector<std::string> set, formats;
  std::string device = {}, status = "not begun";
  std::optional<int> exit_status = {};  // of the last run that ended
  double seconds = 0.0;
  std::string hash = {}, error = {};
  std::vector<std::string> warnings = {};
};

// Atomically replaces the file in the batch's output folder.
void write_batch_summary(const std::filesystem::path& output, const std::vector<SummaryRow>& rows);
// The settings of each job, and how its last run ended. nullopt if the file does not exist. Throws
// bake::BakeError if it is damaged.
std::optional<std::vector<SummaryRow>> read_batch_summary(const std::filesystem::path& output);

// "done", "interrupted" or "failed", for this exit status.
std::string word_of_status(int exit_status);

}  // namespace fascicle::cli
