// batch.json: what became of each job of a batch.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fascicle::cli {

// A job's row. `status` is done, running, interrupted, cut off, failed or not begun.
struct SummaryRow {
  std::string job;
  std::filesystem::path folder;
  std::string scene, clip;
  std::vector<std::string> set, formats;
  std::string device = {}, status = "not begun";
  std::optional<int> exit_status = {};  // of the last run that came to its end
  double seconds = 0.0;
  std::string hash = {}, error = {};
  std::vector<std::string> warnings = {};
};

// Replaces the file of the batch's output folder whole.
void write_batch_summary(const std::filesystem::path& output, const std::vector<SummaryRow>& rows);
// Of each job who it is, and how its last run ended. Nothing where there is no such file. Throws
// bake::BakeError where it is damaged.
std::optional<std::vector<SummaryRow>> read_batch_summary(const std::filesystem::path& output);

// "done", "interrupted" or "failed", of a run with this exit status.
std::string word_of_status(int exit_status);

}  // namespace fascicle::cli
