#include "host/cli/slurm_job.h"

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "host/bake/folder.h"
#include "host/base/file.h"
#include "host/cli/batch_plan.h"
#include "host/cli/exit_codes.h"
#include "host/cli/text.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* submit_script = "submit";
constexpr const char* submitted_ids = "submitted";

std::string directive(const std::string& option) {
  return "#SBATCH " + option + "\n";
}

std::string array_script(const fs::path& folder, const FarmBatch& batch, const std::string& options) {
  const std::string count = std::to_string(batch.jobs.jobs.size());
  std::string text =
      "#!/bin/bash\n"
      "# Bakes of fascicle, written by `fascicle batch --emit slurm`: " +
      count + (batch.jobs.jobs.size() == 1 ? " job" : " jobs") + " in an array of " +
      std::to_string(batch.tasks.size()) + (batch.tasks.size() == 1 ? " task.\n" : " tasks.\n") +
      "# The script `submit` next to this file submits it; `fascicle batch status` shows each job.\n";
  text += directive("--job-name=fascicle");
  text += directive("--array=1-" + std::to_string(batch.tasks.size()) +
                    (batch.at_once > 0 ? "%" + std::to_string(batch.at_once) : ""));
  text += directive("--cpus-per-task=" + std::to_string(batch.threads));
  text += directive("--mem=" + std::to_string(batch.memory >> 20) + "M");
  text += directive("--time=" + std::to_string(static_cast<long>(std::ceil(batch.seconds / 60.0))));
  if (batch.is_gpu) text += directive("--gres=gpu:1");
  text += directive("--signal=B:TERM@120");
  text += directive("--requeue");
  text += directive("--open-mode=append");
  text += directive("--output=log/%a.txt");
  if (!options.empty()) text += directive(options);
  text += "\nfascicle=" + in_quotes(batch.program.string()) + "\nlist=" + in_quotes(batch.list.string()) +
          "\noutput=" + in_quotes(batch.jobs.output.string()) + "\nfolder=" + in_quotes(folder.string()) +
          "\n# Paths of scenes may be relative to this folder.\ncd " + in_quotes(batch.here.string()) +
          " || exit 1\n";
  text +=
      "task=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\n"
      "jobs=$(sed -n \"${SLURM_ARRAY_TASK_ID}p\" \"$folder/tasks\")\n"
      "if [ -z \"$jobs\" ]; then\n"
      "  echo \"$folder/tasks has no line $SLURM_ARRAY_TASK_ID: the batch was emitted anew\" >&2\n"
      "  exit 1\n"
      "fi\n"
      "\n"
      "\"$fascicle\" batch \"$list\" --job \"$jobs\" --output \"$output\" --device " +
      shell_word(batch.device) + " --threads " + std::to_string(batch.threads) +
      " \\\n  --at-once 1 --resume &\n"
      "bake=$!\n"
      "# Two minutes before the limit Slurm signals this shell only; if it takes the node away, it signals\n"
      "# all processes. The bake finishes its frame; a second signal would end it at once.\n"
      "warned=\n"
      "trap 'warned=1; kill -TERM \"$bake\"; trap \"warned=1\" TERM' TERM\n"
      "wait \"$bake\"\n"
      "status=$?\n"
      "# A signal ends the wait, not the bake.\n"
      "while [ -n \"$warned\" ]; do\n"
      "  warned=\n"
      "  wait \"$bake\"\n"
      "  status=$?\n"
      "done\n"
      "\n"
      "# 75: interrupted; the same command continues. Slurm itself requeues jobs that lost their node, and\n"
      "# never those that their user cancelled; this requeues jobs that reached their time limit.\n"
      "if [ \"$status\" -eq 75 ] && [ \"${SLURM_RESTART_COUNT:-0}\" -lt 100 ] &&\n"
      "  [ \"$(squeue --noheader --jobs=\"$task\" --format=%T)\" = RUNNING ]; then\n"
      "  scontrol requeue \"$task\" && exit 0\n"
      "fi\n"
      "exit \"$status\"\n";
  return text;
}

std::string merge_script(const fs::path& folder, const FarmBatch& batch, const std::string& options) {
  std::string text =
      "#!/bin/bash\n"
      "# Runs after the bakes of array.sbatch, even if some failed: writes batch.json next to the bakes\n"
      "# and report.txt here. Its exit status is that of the first bake that failed.\n";
  text += directive("--job-name=fascicle-merge");
  text += directive("--mem=256M");
  text += directive("--time=10");
  text += directive("--requeue");
  text += directive("--output=log/merge.txt");
  if (!options.empty()) text += directive(options);
  return text + "\nexec " + in_quotes(batch.program.string()) + " batch status " +
         in_quotes(folder.string()) + " --output " + in_quotes(batch.jobs.output.string()) + " --merge\n";
}

// Slurm expands % in the name of a log's folder. If there is one, give the full name with each % doubled.
std::string log_option(const fs::path& folder, const std::string& name) {
  std::string text;
  for (const char c : folder.string()) text += c == '%' ? std::string("%%") : std::string(1, c);
  return text == folder.string() ? "" : "--output=" + in_quotes(text + "/log/" + name) + " ";
}

std::string submit_text(const fs::path& folder) {
  return "#!/bin/sh\n"
         "# Submits the bakes of array.sbatch to Slurm, and then their merge; `submitted` has the job ids.\n"
         "set -eu\ncd " +
         in_quotes(folder.string()) +
         "\nmkdir -p log\n"
         "array=$(sbatch --parsable " +
         log_option(folder, "%a.txt") +
         "array.sbatch)\n"
         "array=${array%%;*}\n"
         "echo \"array $array\" > submitted\n"
         "# Without its merge the bakes would be submitted twice: the user is told to try again.\n"
         "merge=$(sbatch --parsable " +
         log_option(folder, "merge.txt") +
         "--dependency=\"afterany:$array\" merge.sbatch) ||\n"
         "  { scancel \"$array\"; rm -f submitted; exit 1; }\n"
         "merge=${merge%%;*}\n"
         "echo \"merge $merge\" >> submitted\n"
         "echo \"submitted to Slurm: array $array, merge $merge\"\n";
}

}  // namespace

bool was_submitted(const fs::path& folder) {
  return fs::exists(folder / submitted_ids);
}

void refuse_others_slurm_files(const fs::path& folder) {
  if (holds_plan(folder)) return;
  for (const char* name :
       {plan_file, "tasks", "array.sbatch", "merge.sbatch", submit_script, submitted_ids, "report.txt"})
    if (fs::exists(fs::symlink_status(folder / name)))
      throw UsageError(
          (folder / name).string() +
          ": --emit would replace this file. No plan.json that can be read says that it wrote it; move "
          "it away or give another folder");
}

void write_slurm_job(const fs::path& folder, const FarmBatch& batch, const std::string& options) {
  bake::make_folder(folder);
  // The plan comes first: it marks the folder as ours.
  write_plan(folder, batch.list, batch.jobs);
  // Left over from an earlier batch.
  fs::remove(folder / submitted_ids);
  fs::remove(folder / "report.txt");
  std::string tasks;
  for (const std::vector<std::string>& names : batch.tasks) {
    for (const std::string& name : names) tasks += (&name == &names.front() ? "" : ",") + name;
    tasks += "\n";
  }
  base::write_whole(folder / "tasks", tasks);
  base::write_whole(folder / "array.sbatch", array_script(folder, batch, options));
  base::write_whole(folder / "merge.sbatch", merge_script(folder, batch, options));
  base::write_whole(folder / submit_script, submit_text(folder));
  constexpr fs::perms may_run = fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
  fs::permissions(folder / submit_script, may_run, fs::perm_options::add);
}

void submit_slurm_job(const fs::path& folder) {
  const std::string script = (folder / submit_script).string();
  if (std::system("command -v sbatch >/dev/null 2>&1") != 0)
    throw std::runtime_error("--submit: sbatch was not found; run " + script + " on a machine with Slurm");
  if (std::system(("sh " + in_quotes(script)).c_str()) != 0)
    throw std::runtime_error("--submit: Slurm rejected it, for the reason above. Fix that, then run " +
                             script);
}

}  // namespace fascicle::cli
