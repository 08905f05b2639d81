// fascicle batch: a list of bakes on several devices.
#include <algorithm>
#include <memory>
#include <utility>

#include "host/bake/options.h"
#include "host/base/nearest_name.h"
#include "host/cli/command.h"
#include "host/cli/many_bakes.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/jobs.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
namespace {

struct BatchArguments {
  std::string jobs;
  ManyBakes many;  // all but the jobs
};

// All that can be refused before the first bake begins.
void check(const scene::Job& job) {
  scene::SceneOverrides overrides;
  overrides.set = job.set;
  if (!job.clip.empty()) overrides.clip = job.clip;
  try {
    (void)scene::load_scene(job.scene, overrides);
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
  const scene::Jobs jobs = scene::read_jobs(arguments.jobs);
  ManyBakes many = arguments.many;
  many.devices = with_all_devices(many.devices, gpu::list_devices());
  (void)parse_device_list(many.devices);  // refuses "auto"
  many.output = jobs.output;
  for (const scene::Job& job : jobs.jobs) {
    check(job);
    many.bakes.push_back(bake_of(job));
  }
  return bake_many(std::move(many), log);
}

}  // namespace

void add_batch(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("batch", "Bake a list of scenes, clips and variations, on several devices");
  const auto arguments = std::make_shared<BatchArguments>();
  subcommand
      ->add_option(
          "JOBS", arguments->jobs,
          "TOML: [job.NAME] with scene, clips = [...], set = [\"KEY=VALUE\", ...], format = [...], "
          "keep_frames and [job.NAME.vary] \"KEY\" = [values]; output, format and keep_frames for all")
      ->required()
      ->option_text(" ");
  subcommand
      ->add_option("--device", arguments->many.devices,
                   "Devices to share the jobs, separated by commas: cpu, cpu:LEVEL, vulkan, vulkan:N; all: "
                   "every real GPU "
                   "and the CPU; default: cpu. A job whose device fails goes to another")
      ->option_text("LIST");
  subcommand
      ->add_option("--threads", arguments->many.threads,
                   "Threads of each CPU bake; 0 shares the cores among those at once")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  auto* overwrite =
      subcommand->add_flag("--overwrite", arguments->many.overwrite, "Replace bakes that are there");
  auto* resume = subcommand->add_flag("--resume", arguments->many.resume, "Go on with what is not done yet");
  overwrite->excludes(resume);
  subcommand->add_flag("--dry-run", arguments->many.dry_run, "Print each job's command; write nothing");
  add_log_options(*subcommand, command.log);
  add_many_bakes_options(*subcommand, arguments->many.at_once);
  subcommand->callback(
      [arguments, &command] { command.run = [arguments](Log& log) { return bake_jobs(*arguments, log); }; });
}

}  // namespace fascicle::cli
