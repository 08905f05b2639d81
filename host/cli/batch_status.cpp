// fascicle batch status: the state of each job, and the merged summary.
#include "host/cli/batch_status.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/base/errors.h"
#include "host/base/file.h"
#include "host/cli/batch_plan.h"
#include "host/cli/job_record.h"
#include "host/cli/text.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

std::optional<fs::file_time_type> time_of(const fs::path& file) {
  std::error_code none;
  const fs::file_time_type time = fs::last_write_time(file, none);
  return none ? std::nullopt : std::optional(time);
}

bool runs(const fs::path& output, const SummaryRow& job, const std::optional<JobRecord>& record) {
  if (bake::is_in_use_here(job.folder)) return true;
  if (!record || record->exit_status) return false;
  // The number of a process that ended may be given to another one.
  if (record->host == name_of_this_host() && !is_there(record->process)) return false;
  const std::optional<fs::file_time_type> marked = time_of(job_record_file(output, job.job));
  const std::optional<fs::file_time_type> written = time_of(job.folder / bake::manifest_name);
  const auto now = fs::file_time_type::clock::now();
  return (marked && now - *marked < sign_of_life_due) || (written && now - *written < sign_of_life_due);
}

std::string frames_text(const bake::ManifestSummary& manifest) {
  return std::to_string(manifest.frames_done) + " of " + std::to_string(manifest.frames);
}

// Takes the result from the manifest of a job that has no record, or an older one.
void take_manifest(const bake::ManifestSummary& manifest, JobState& state) {
  SummaryRow& row = state.row;
  if (manifest.status == name_of(bake::Status::complete)) {
    row.exit_status = static_cast<int>(ExitCode::done);
  } else if (manifest.status == name_of(bake::Status::interrupted)) {
    row.exit_status = static_cast<int>(ExitCode::interrupted);
  } else if (manifest.status == name_of(bake::Status::not_finite)) {
    row.exit_status = static_cast<int>(ExitCode::not_finite);
  } else if (manifest.status == name_of(bake::Status::failed)) {
    row.exit_status = static_cast<int>(ExitCode::unforeseen);
  } else {
    row.exit_status.reset();
  }
  row.error = manifest.message;
}

void put_into_words(const std::optional<bake::ManifestSummary>& manifest, bool is_running, bool has_begun,
                    JobState& state) {
  SummaryRow& row = state.row;
  const std::string at = manifest ? " at frame " + frames_text(*manifest) : ", no frame yet";
  if (is_running) {
    row.status = "running";
    state.text = row.status + at;
  } else if (row.exit_status) {
    row.status = word_of_status(*row.exit_status);
    state.text = row.status;
    if (row.status == "done" && manifest)
      state.text += ", " + counted_text(manifest->frames, "frame", "frames") + " in " +
                    duration_text(row.seconds) + ", last frame " + row.hash;
    if (row.status == "interrupted" && manifest) state.text += at;
    if (row.status == "failed")
      state.text += ": " + (row.error.empty() ? "status " + std::to_string(*row.exit_status) : row.error);
  } else if (has_begun) {
    // The process was killed, or its host went down, so nothing was recorded.
    row.status = "cut off";
    state.text = row.status + at + "; --resume continues";
  } else {
    row.status = state.text = "not begun";
  }
}

}  // namespace

JobState state_of(const fs::path& output, SummaryRow job, std::optional<fs::file_time_type> summary_written,
                  const std::string& summary_settings) {
  JobState state{.row = std::move(job)};
  SummaryRow& row = state.row;
  // The times first: a file that is replaced meanwhile must not count as newer than what was read.
  const auto recorded = time_of(job_record_file(output, row.job));
  const auto written = time_of(row.folder / bake::manifest_name);
  std::optional<bake::ManifestSummary> manifest;
  try {
    manifest = bake::read_manifest(row.folder);
  } catch (const base::InputError& error) {
    state.unreadable.emplace_back(error.what());  // affects only this job
  }
  std::optional<JobRecord> record = read_job_record(output, row.job);
  if (recorded && !record)
    state.unreadable.push_back(job_record_file(output, row.job).string() +
                               ": is damaged, and does not count");
  const auto is_newer = [](const auto& time, const auto& other) {
    return time && (!other || *time >= *other);
  };
  // A bake whose folder is gone is not done, whatever was written of it.
  const auto is_done = [](std::optional<int> status) { return status && word_of_status(*status) == "done"; };
  if (!written && is_done(row.exit_status)) row.exit_status.reset();
  if (!written && record && is_done(record->exit_status)) {
    if (is_newer(recorded, summary_written)) {
      row.exit_status.reset();
      row.error.clear();
    }
    record.reset();
  }
  const bool summary_is_newest =
      row.exit_status && is_newer(summary_written, written) && is_newer(summary_written, recorded);
  if (manifest) {
    row.seconds = manifest->timings.total;
    row.hash = manifest->last_position_hash;
    row.warnings = manifest->warnings;
    if (!summary_is_newest) row.device = manifest->device;
  }
  row.warnings.insert(row.warnings.end(), state.unreadable.begin(), state.unreadable.end());
  const bool record_is_newer = record && is_newer(recorded, written);
  // Of a bake that was made alone since then, nothing says what the list's settings were.
  std::string baked;
  if (is_newer(summary_written, written) && is_newer(summary_written, recorded))
    baked = summary_settings;
  else if (record_is_newer && record->exit_status)
    baked = record->settings;
  if (summary_is_newest) {
    // The row has it.
  } else if (record_is_newer && record->exit_status) {
    row.exit_status = record->exit_status;
    row.error = record->error;
    row.device = record->device;
  } else if (manifest) {
    take_manifest(*manifest, state);
  } else if (record) {
    row.exit_status.reset();
    row.error.clear();
    row.device = record->device;
  }
  put_into_words(manifest, runs(output, row, record), manifest || record, state);
  if (row.status == "done" && !baked.empty() && baked != settings_text(row)) {
    row.exit_status.reset();
    row.hash.clear();
    row.baked = baked;
    row.status = "not begun";
    state.text = row.status + ": its folder holds a bake of other settings; --overwrite bakes it again";
  }
  return state;
}

ExitCode code_of(const std::vector<JobState>& jobs) {
  bool all_done = true;
  for (const JobState& job : jobs) {
    if (job.row.status == "failed" && job.row.exit_status) return code_of_failure(*job.row.exit_status);
    all_done = all_done && job.row.status == "done";
  }
  return all_done ? ExitCode::done : ExitCode::interrupted;
}

namespace {

struct StatusArguments {
  std::string batch;   // a folder, or the list of jobs
  std::string output;  // replaces the batch's own
  bool merge = false;
};

// "4 jobs in out/walks: 2 done, 1 running, 1 failed"
std::string count_line(const fs::path& output, const std::vector<JobState>& jobs) {
  std::map<std::string, std::size_t> count;
  for (const JobState& job : jobs) ++count[job.row.status];
  std::string line = std::to_string(jobs.size()) + (jobs.size() == 1 ? " job in " : " jobs in ") +
                     shown_text(output.string()) + ":";
  const char* before = " ";
  for (const char* word : {"done", "running", "interrupted", "cut off", "failed", "not begun"})
    if (count[word] > 0) {
      line += before + std::to_string(count[word]) + " " + word;
      before = ", ";
    }
  return line;
}

// What batch.json says of each job, and when it was written.
struct KnownJobs {
  std::optional<fs::file_time_type> written;
  std::map<std::string, SummaryRow> rows = {};
};

KnownJobs known_jobs(const fs::path& output, Log& log) {
  const fs::path file = output / scene::batch_summary;
  KnownJobs known{.written = time_of(file)};
  try {
    for (SummaryRow& row : read_batch_summary(output).value_or(std::vector<SummaryRow>())) {
      std::string name = row.job;
      known.rows.emplace(std::move(name), std::move(row));
    }
  } catch (const std::runtime_error&) {
    log.warning(file.string() + ": is damaged or of another program, and does not count");
  }
  return known;
}

// A plan may come from a stranger, and name any folder. Its tasks have left records in its own.
void refuse_foreign_output(const BatchPlan& plan) {
  const bool has_begun = std::any_of(plan.jobs.begin(), plan.jobs.end(), [&](const scene::Job& job) {
    return read_job_record(plan.output, job.name).has_value();
  });
  if (!has_begun)
    throw UsageError((plan.folder / plan_file).string() + ": none of its jobs has begun in " +
                     plan.output.string() +
                     ", so --merge writes nothing there; if that folder is right, give "
                     "it with --output");
}

void merge_jobs(const StatusArguments& arguments, const BatchPlan& plan, const std::vector<JobState>& jobs,
                const std::string& report, Log& log) {
  if (!plan.folder.empty() && arguments.output.empty()) refuse_foreign_output(plan);
  refuse_foreign_summary(plan.output, "move it away, and merge again");
  std::vector<SummaryRow> rows;
  for (const JobState& job : jobs) rows.push_back(job.row);
  bake::make_folder(plan.output);
  write_batch_summary(plan.output, rows);
  log.info("wrote " + (plan.output / scene::batch_summary).string());
  if (plan.folder.empty()) return;
  base::write_whole_beside_others(plan.folder / "report.txt", report);
  log.info("wrote " + (plan.folder / "report.txt").string());
}

ExitCode say_status(const StatusArguments& arguments, Log& log) {
  BatchPlan plan = find_plan(arguments.batch);
  if (!arguments.output.empty()) plan.output = arguments.output;
  const KnownJobs known = known_jobs(plan.output, log);
  std::vector<JobState> jobs;
  for (const scene::Job& job : plan.jobs) {
    SummaryRow row{job.name, plan.output / job.name, job.scene, job.clip, job.set, job.formats};
    std::string summary_settings;
    if (const auto found = known.rows.find(job.name); found != known.rows.end()) {
      summary_settings = settings_of_bake(found->second);
      row.exit_status = found->second.exit_status;
      row.error = found->second.error;
      row.device = found->second.device;
    }
    jobs.push_back(state_of(plan.output, std::move(row), known.written, summary_settings));
    for (const std::string& why : jobs.back().unreadable) log.warning(job.name + ": " + why);
  }
  std::vector<std::pair<std::string, std::string>> lines;
  for (const JobState& job : jobs) lines.emplace_back(job.row.job, job.text);
  const std::string report = count_line(plan.output, jobs) + "\n" + columns_text(lines);
  // Whoever reads the output may have gone: printing may end the program.
  try {
    if (arguments.merge) merge_jobs(arguments, plan, jobs, report, log);
  } catch (...) {
    std::cout << report;
    throw;
  }
  std::cout << report;
  return code_of(jobs);
}

}  // namespace

CLI::App* add_batch_status(CLI::App& batch, Command& command) {
  auto* subcommand = batch.add_subcommand("status", "Show the state of each job");
  const auto arguments = std::make_shared<StatusArguments>();
  subcommand
      ->add_option("BATCH", arguments->batch,
                   "The output folder of the batch, the folder that --emit wrote, or the list of jobs")
      ->required()
      ->option_text(" ");
  subcommand
      ->add_option("-o,--output", arguments->output, "Folder of the bakes, if it is not the one in the list")
      ->option_text("DIR");
  subcommand->add_flag(
      "--merge", arguments->merge,
      "Write batch.json into the folder of the bakes, and report.txt into the folder that --emit wrote");
  add_log_options(*subcommand, command.log);
  subcommand->callback(
      [arguments, &command] { command.run = [arguments](Log& log) { return say_status(*arguments, log); }; });
  return subcommand;
}

}  // namespace fascicle::cli
