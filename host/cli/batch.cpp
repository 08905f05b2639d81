// fascicle batch: bakes a list of jobs on several devices, or submits it to a farm.
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "host/bake/folder.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/base/nearest_name.h"
#include "host/cli/batch_plan.h"
#include "host/cli/batch_status.h"
#include "host/cli/command.h"
#include "host/cli/farm_tasks.h"
#include "host/cli/many_bakes.h"
#include "host/cli/openjd_template.h"
#include "host/cli/slurm_job.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/jobs.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;

struct BatchArguments {
  std::string jobs;
  ManyBakes many;                     // everything except the jobs
  std::optional<std::string> chosen;  // the jobs for this process, if not all
  std::string output;  // with `emit`, the file or folder to write; otherwise the folder of the bakes
  std::string emit;    // slurm, openjd or empty
  std::string slurm_options;
  unsigned group = 0;
  bool submit = false;
};

// For a task that begins in another folder.
void refuse_relative_inputs(const scene::Scene& scene) {
  for (const auto& [file, hash] : scene.input_hashes)
    if (!file.starts_with("builtin:") && fs::path(file).is_relative())
      throw scene::SceneError(file +
                              ": was found from the current folder, and the tasks of --emit openjd begin in "
                              "others; put it next to the list, or give its full path");
}

// Reports everything that can be rejected before the first bake starts; returns the number of frames.
std::uint64_t check(const scene::Job& job, bool begins_here = true) {
  scene::SceneOverrides overrides;
  overrides.set = job.set;
  if (!job.clip.empty()) overrides.clip = job.clip;
  std::uint64_t frames = 0;
  try {
    const scene::Scene scene = scene::load_scene(job.scene, overrides);
    if (!begins_here) refuse_relative_inputs(scene);
    frames = scene::frame_count(scene);
  } catch (const scene::SceneError& error) {
    throw scene::SceneError("job." + job.name + ": " + error.what());
  }
  for (const std::string& format : job.formats)
    if (const std::vector<std::string> names = bake::accepted_formats();
        std::find(names.begin(), names.end(), format) == names.end())
      throw scene::SceneError("job." + job.name + ": there is no format \"" + format + "\"" +
                              base::nearest_name_hint(format, names));
  bake::BakeOutput output;
  output.formats = job.formats;
  output.keep_frames = job.keep_frames;
  try {
    (void)bake::formats_to_write(output);
  } catch (const bake::ContradictingOptions& error) {
    throw scene::SceneError("job." + job.name + ": " + error.what());
  }
  return frames;
}

OneBake bake_of(const scene::Job& job) {
  OneBake bake{job.name, job.scene, job.clip, job.set, job.formats, {}};
  if (!job.clip.empty()) bake.options = {"--clip", job.clip};
  for (const std::string& set : job.set) bake.options.push_back("--set=" + set);
  for (const std::string& format : job.formats) bake.options.push_back("--format=" + format);
  if (!job.keep_frames) bake.options.push_back("--keep-frames=false");
  bake.model = job.scene;
  for (const std::string& set : job.set) bake.model += "\n" + set;
  return bake;
}

ExitCode bake_jobs(const BatchArguments& arguments, Log& log) {
  scene::Jobs jobs = scene::read_jobs(arguments.jobs);
  ManyBakes many = arguments.many;
  many.devices = with_all_devices(many.devices, devices_for(many.devices));
  (void)parse_device_list(many.devices);  // rejects "auto"
  many.output = arguments.output.empty() ? jobs.output : fs::path(arguments.output);
  // An empty list must not count as all jobs: a farm's task would then bake everything.
  many.is_part = arguments.chosen.has_value();
  if (many.is_part) jobs.jobs = chosen_jobs(jobs.jobs, *arguments.chosen);
  for (const scene::Job& job : jobs.jobs) {
    check(job);
    many.bakes.push_back(bake_of(job));
  }
  return bake_many(std::move(many), log);
}

FarmBatch farm_batch(const BatchArguments& arguments) {
  // Beyond this, another task next to a bake is worth more than further threads.
  constexpr unsigned threads = 4;
  const fs::path list = fs::absolute(arguments.jobs).lexically_normal();
  FarmBatch batch{.program = fs::read_symlink("/proc/self/exe"),
                  .list = list,
                  .here = fs::current_path(),
                  .jobs = scene::read_jobs(list),  // by the path that the tasks get
                  .device = arguments.many.devices,
                  .threads = arguments.many.threads > 0 ? arguments.many.threads : threads,
                  .at_once = arguments.many.at_once};
  batch.jobs.output = fs::absolute(batch.jobs.output).lexically_normal();
  const std::vector<DeviceRequest> devices = parse_device_list(batch.device);
  if (devices.size() > 1)
    throw UsageError("--emit: a task has one device; write a script for each of \"" + batch.device + "\"");
  batch.is_gpu = devices.front().kind == DeviceRequest::Kind::vulkan;
  refuse_control_characters("--slurm", arguments.slurm_options);
  for (const fs::path& path :
       {batch.program, batch.list, batch.here, batch.jobs.output, fs::absolute(arguments.output)}) {
    refuse_control_characters(path.string(), path.string());
    refuse_path_not_utf8(path);
  }
  return batch;
}

// Prints a summary before submission.
void print_farm(const BatchArguments& arguments, const FarmBatch& batch) {
  std::size_t most = 0;
  for (const std::vector<std::string>& task : batch.tasks) most = std::max(most, task.size());
  std::vector<std::pair<std::string, std::string>> rows{
      {"jobs", count_text(batch.jobs.jobs.size())},
      {"tasks", count_text(batch.tasks.size()) + ", of at most " + std::to_string(most) +
                    (most == 1 ? " job" : " jobs")},
      {"each requests", std::to_string(batch.threads) + (batch.threads == 1 ? " core" : " cores") +
                            (batch.is_gpu ? ", a GPU" : "") + " and " + bytes_text(batch.memory)},
      {"bakes go to", batch.jobs.output.string()}};
  if (arguments.emit == "slurm") {
    rows.insert(rows.begin() + 3, {"time limit", duration_text(batch.seconds)});
    if (!arguments.submit)
      rows.emplace_back("submit with", shell_word((fs::path(arguments.output) / "submit").string()));
    rows.emplace_back("status", "fascicle batch status " + shell_word(arguments.output));
  }
  std::cout << (arguments.many.dry_run ? "dry run: nothing is written\n" : "wrote " + arguments.output + "\n")
            << columns_text(rows);
}

ExitCode emit_jobs(const BatchArguments& arguments, Log& log) {
  if (arguments.output.empty())
    throw UsageError(arguments.emit == "slurm"
                         ? "--emit slurm: give the folder to write, as in -o job"
                         : "--emit openjd: give the file to write, as in -o template.json");
  FarmBatch batch = farm_batch(arguments);
  const fs::path written = (fs::absolute(arguments.output) / "").lexically_normal().parent_path();
  const bool is_slurm = arguments.emit == "slurm";
  if (is_slurm)
    refuse_others_slurm_files(written);
  else
    refuse_others_template(written);
  if (is_slurm && was_submitted(written) && !arguments.many.resume)
    throw UsageError(arguments.output +
                     ": was already submitted to Slurm; --resume rewrites it for what is not done");
  std::vector<FarmJob> jobs;
  for (const scene::Job& job : batch.jobs.jobs) {
    jobs.push_back({bake_of(job).model, check(job, is_slurm)});
    if (!arguments.many.resume && bake::holds_bake(batch.jobs.output / job.name))
      throw bake::FolderInUse((batch.jobs.output / job.name).string() +
                              ": holds a bake; --resume bakes what is not done, or choose another output");
  }
  cut_into_tasks(batch, jobs, arguments.group, log);
  constexpr std::size_t most_of_slurm = 1000;
  if (is_slurm && batch.tasks.size() > most_of_slurm)
    log.warning(
        count_text(batch.tasks.size()) +
        " tasks are more than Slurm takes in one array by default (MaxArraySize); a larger --group makes "
        "fewer");
  if (!arguments.many.dry_run && is_slurm) write_slurm_job(written, batch, arguments.slurm_options);
  if (!arguments.many.dry_run && !is_slurm) write_openjd_template(written, batch);
  print_farm(arguments, batch);
  if (arguments.submit && !arguments.many.dry_run) {
    std::cout.flush();
    submit_slurm_job(written);
  }
  return ExitCode::done;
}

void add_farm_options(CLI::App& subcommand, BatchArguments& arguments) {
  auto* emit =
      subcommand
          .add_option(
              "--emit", arguments.emit,
              "Bake nothing; write a Slurm array script or an Open Job Description job template for a farm")
          ->check(CLI::IsMember({"slurm", "openjd"}).description(""))
          ->option_text("slurm|openjd");
  subcommand
      .add_option("-o,--output", arguments.output,
                  "With --emit: the folder (slurm) or file (openjd: .json, .yaml) to write. Otherwise: the "
                  "folder of the bakes, in place of the one in JOBS")
      ->option_text("PATH");
  subcommand
      .add_option(
          "--group", arguments.group,
          "With --emit: jobs of the same model per task, at most; default: as many as take about two minutes")
      ->check(CLI::Range(1U, 10000U).description(""))
      ->needs(emit)
      ->option_text("N");
  subcommand
      .add_option("--slurm", arguments.slurm_options,
                  "Further options for sbatch, which override ours, as in \"--partition=x --account=y\"")
      ->needs(emit)
      ->option_text("OPTIONS");
  subcommand.add_flag("--submit", arguments.submit, "Submit the script to Slurm")->needs(emit);
}

}  // namespace

void add_batch(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand(
      "batch", "Bake a list of scenes, clips and variations, on several devices or a farm");
  const auto arguments = std::make_shared<BatchArguments>();
  // Not marked as required, because `status` has no such argument; the callback checks it.
  subcommand
      ->add_option(
          "JOBS", arguments->jobs,
          "TOML: [job.NAME] with scene, clips = [...], set = [\"KEY=VALUE\", ...], format = [...], "
          "keep_frames and [job.NAME.vary] \"KEY\" = [values]; output, format and keep_frames for all")
      ->option_text(" ");
  subcommand
      ->add_option("--device", arguments->many.devices,
                   "Devices that share the jobs, separated by commas: cpu, cpu:LEVEL, vulkan, vulkan:N; all: "
                   "every real GPU and the CPU; default: cpu. A job whose device fails moves to another")
      ->option_text("LIST");
  subcommand
      ->add_option(
          "--threads", arguments->many.threads,
          "Threads of each CPU bake; 0: parallel bakes share the cores. With --emit: cores of a task; 0: 4")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  auto* overwrite = subcommand->add_flag("--overwrite", arguments->many.overwrite, "Replace existing bakes");
  auto* resume =
      subcommand->add_flag("--resume", arguments->many.resume, "Continue with the jobs that are not done");
  overwrite->excludes(resume);
  subcommand->add_flag("--dry-run", arguments->many.dry_run, "Print each job's command; write nothing");
  subcommand
      ->add_option("--job", arguments->chosen,
                   "Bake only some of the jobs, while other processes bake the rest: names, numbers from 1, "
                   "or ranges such as 3-7, separated by commas. batch status --merge then writes batch.json")
      ->option_text("LIST");
  add_log_options(*subcommand, command.log);
  add_many_bakes_options(*subcommand, arguments->many.at_once)
      ->description(
          "Parallel bakes on each device; 0: on the CPU one per core, as far as memory allows; they share "
          "the cores. With --emit slurm: parallel tasks; 0: as many as Slurm allows");
  add_farm_options(*subcommand, *arguments);
  overwrite->excludes("--emit");
  subcommand->get_option("--job")->excludes("--emit");
  const CLI::App* status = add_batch_status(*subcommand, command);
  subcommand->callback([arguments, status, &command] {
    if (status->parsed()) return;
    if (arguments->jobs.empty()) throw CLI::RequiredError("JOBS");
    if (arguments->submit && arguments->emit != "slurm") throw CLI::RequiredError("--submit: --emit slurm");
    command.watches_interrupts = arguments->emit.empty();
    command.run = [arguments](Log& log) {
      return arguments->emit.empty() ? bake_jobs(*arguments, log) : emit_jobs(*arguments, log);
    };
  });
}

}  // namespace fascicle::cli
