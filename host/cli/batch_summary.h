// batch.json: the result of each job of a batch.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/cli/exit_codes.h"

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
  std::string baked = {};  // settings_text() of the bake in its folder, if the row's are other settings
};

// What a job was told to bake, as text that is only compared: its scene, clip, settings and formats. For a
// SummaryRow, or what else has these members.
template <class Job>
std::string settings_text(const Job& job) {
  const std::filesystem::path scene(job.scene);
  // One list may be called by several paths. A built-in scene has only a name.
  const bool is_file = scene.has_extension() || scene.has_parent_path();
  return nlohmann::json{is_file ? std::filesystem::weakly_canonical(scene).string() : job.scene, job.clip,
                        job.set, job.formats}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}
// The settings of the bake in a job's folder, as far as its row tells; empty: unknown.
std::string settings_of_bake(const SummaryRow& row);

// Atomically replaces the file in the batch's output folder.
void write_batch_summary(const std::filesystem::path& output, const std::vector<SummaryRow>& rows);
// The settings of each job, and how its last run ended. nullopt if the file does not exist. Throws
// base::BakeError if it is damaged, or holds what write_batch_summary never writes: it may come from a
// stranger, and a job's name becomes a path.
std::optional<std::vector<SummaryRow>> read_batch_summary(const std::filesystem::path& output);
// Before it is replaced. Throws base::BakeError if there is a batch.json that cannot be read, as it may
// belong to another program; `remedy` says what to do.
void refuse_foreign_summary(const std::filesystem::path& output, const std::string& remedy);

// "done", "interrupted" or "failed", for this exit status.
std::string word_of_status(int exit_status);
// The exit status of a batch whose first failure is a job with this one.
ExitCode code_of_failure(int exit_status);

// Whether a process can end with this status, which a file gives.
template <class Json>
bool is_exit_status(const Json& value) {
  return value.is_number_integer() && value >= 0 && value <= 255;
}

}  // namespace fascicle::cli
