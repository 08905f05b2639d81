// fascicle batch: a list of bakes on several devices, one process on each at a time, with one view of all and
// resumable as a whole.
#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>
#include <poll.h>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/outputs.h"
#include "host/base/nearest_name.h"
#include "host/base/part_file.h"
#include "host/cli/child_bake.h"
#include "host/cli/command.h"
#include "host/cli/interrupt.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/jobs.h"
#include "host/scene/scene_table.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct BatchArguments {
  std::string jobs, devices = "cpu";
  unsigned threads = 0;
  bool overwrite = false, resume = false, dry_run = false;
};

// What has become of a job; of one that was never begun there is no status.
struct Outcome {
  std::string device;
  std::optional<int> status;
  double seconds = 0.0;
  std::string error = {}, hash = {};
  std::vector<std::string> warnings = {};
};

std::string word_of(const Outcome& outcome) {
  if (!outcome.status) return "not begun";
  if (*outcome.status == static_cast<int>(ExitCode::done)) return "done";
  if (*outcome.status == static_cast<int>(ExitCode::interrupted)) return "interrupted";
  return "failed";
}

std::string last_hash(const fs::path& folder) {
  const std::optional<bake::ManifestSummary> manifest = bake::read_manifest(folder);
  return manifest ? manifest->last_position_hash : std::string();
}

class Batch {
 public:
  Batch(const BatchArguments& arguments, scene::Jobs jobs, Log& log)
      : arguments_(arguments), jobs_(std::move(jobs)), log_(log), outcomes_(jobs_.jobs.size()) {}

  ExitCode run() {
    check_devices();
    check_all();
    if (arguments_.dry_run) {
      print_plan();
      return ExitCode::done;
    }
    for (const std::string& label : split_device_list(arguments_.devices))
      slots_.push_back({label, nullptr, 0, {}});
    for (std::size_t job = 0; job < jobs_.jobs.size(); ++job) waiting_.push_back(job);
    bake::make_folder(jobs_.output);
    const std::atomic<bool>& interrupted = catch_interrupts();
    bool told = false;
    while (is_busy() || (!waiting_.empty() && !interrupted)) {
      if (!interrupted) begin_jobs();
      if (interrupted && !told) {
        told = true;
        for (const Slot& slot : slots_)
          if (slot.bake) slot.bake->interrupt();
      }
      wait_for_words();
      end_jobs();
      show();
    }
    log_.clear_bar();
    print_results();
    write_summary();
    return code(interrupted);
  }

 private:
  struct Slot {
    std::string device;
    std::unique_ptr<ChildBake> bake;
    std::size_t job;
    Clock::time_point start;
  };

  fs::path folder_of(const scene::Job& job) const { return jobs_.output / job.name; }

  // A device that is not there would fail one job after the other, faster than the others bake them.
  void check_devices() const {
    const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
    const std::vector<std::string> labels = split_device_list(arguments_.devices);
    const std::vector<DeviceRequest> requests = parse_device_list(arguments_.devices);
    for (std::size_t k = 0; k < requests.size(); ++k) {
      const std::vector<cpu_reference::Simd> levels = cpu_reference::available_simd();
      const cpu_reference::Simd simd = requests[k].simd;
      const bool is_there = requests[k].kind == DeviceRequest::Kind::cpu
                                ? simd == cpu_reference::Simd::automatic ||
                                      std::find(levels.begin(), levels.end(), simd) != levels.end()
                                : !candidates(requests[k], devices).empty();
      if (!is_there) throw NoSuchDevice(labels[k] + ": there is no such device; fascicle devices lists them");
    }
  }

  // Everything else that can be refused before the first bake begins.
  void check_all() const {
    for (const scene::Job& job : jobs_.jobs) {
      scene::SceneOverrides overrides;
      overrides.set = job.set;
      if (!job.clip.empty()) overrides.clip = job.clip;
      try {
        (void)scene::load_scene(job.scene, overrides);
      } catch (const scene::SceneError& error) {
        throw scene::SceneError("job." + job.name + ": " + error.what());
      }
      for (const std::string& format : job.formats)
        if (const std::vector<std::string>& names = bake::format_names();
            std::find(names.begin(), names.end(), format) == names.end())
          throw scene::SceneError("job." + job.name + ": there is no format \"" + format + "\"" +
                                  base::nearest_name_hint(format, names));
      if (!arguments_.overwrite && !arguments_.resume && bake::holds_bake(folder_of(job)))
        throw bake::FolderInUse(folder_of(job).string() +
                                ": holds a bake; --resume bakes what is not done, --overwrite "
                                "bakes all again");
    }
  }

  std::vector<std::string> command_of(const scene::Job& job, const std::string& device) const {
    std::vector<std::string> command{"bake", job.scene, "-o", folder_of(job).string(), "--device", device};
    if (arguments_.threads > 0)
      command.insert(command.end(), {"--threads", std::to_string(arguments_.threads)});
    command.push_back(arguments_.overwrite ? "--overwrite" : "--resume");
    if (!job.clip.empty()) command.insert(command.end(), {"--clip", job.clip});
    for (const std::string& set : job.set) command.push_back("--set=" + set);
    for (const std::string& format : job.formats) command.push_back("--format=" + format);
    return command;
  }

  bool is_busy() const {
    return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.bake != nullptr; });
  }

  void begin_jobs() {
    for (Slot& slot : slots_) {
      if (slot.bake || waiting_.empty()) continue;
      slot.job = waiting_.front();
      waiting_.pop_front();
      const scene::Job& job = jobs_.jobs[slot.job];
      slot.start = Clock::now();
      try {
        slot.bake = std::make_unique<ChildBake>(command_of(job, slot.device));
        log_.detail(job.name + " begins on " + slot.device);
      } catch (const std::system_error& error) {
        end_job(
            slot,
            {.device = slot.device, .status = static_cast<int>(ExitCode::unforeseen), .error = error.what()});
      }
    }
  }

  void wait_for_words() {
    std::vector<pollfd> ends;
    for (const Slot& slot : slots_)
      if (slot.bake && slot.bake->descriptor() >= 0) ends.push_back({slot.bake->descriptor(), POLLIN, 0});
    constexpr int milliseconds = 100;
    (void)::poll(ends.data(), ends.size(), milliseconds);
    for (const Slot& slot : slots_)
      if (slot.bake) slot.bake->listen();
  }

  // What others wrote on a bake's stderr, such as its driver.
  void pass_on(const Slot& slot) {
    for (const std::string& line : slot.bake->take_other_lines())
      log_.info(jobs_.jobs[slot.job].name + ": " + line);
  }

  void end_jobs() {
    for (Slot& slot : slots_) {
      if (!slot.bake) continue;
      const bool has_ended = slot.bake->has_ended();
      pass_on(slot);
      if (!has_ended) continue;
      Outcome outcome{.device = slot.device,
                      .status = slot.bake->status(),
                      .seconds = std::chrono::duration<double>(Clock::now() - slot.start).count(),
                      .error = slot.bake->error(),
                      .warnings = slot.bake->warnings()};
      // Of a bake that was refused the folder may hold an older one.
      if (word_of(outcome) != "failed") outcome.hash = last_hash(folder_of(jobs_.jobs[slot.job]));
      slot.bake.reset();
      end_job(slot, std::move(outcome));
    }
  }

  void end_job(const Slot& slot, Outcome outcome) {
    const scene::Job& job = jobs_.jobs[slot.job];
    ++ended_;
    for (const std::string& warning : outcome.warnings) log_.warning(job.name + ": " + warning);
    const std::string line = "[" + std::to_string(ended_) + "/" + std::to_string(jobs_.jobs.size()) + "] " +
                             job.name + " on " + slot.device + ": " + word_of(outcome) + ", " +
                             duration_text(outcome.seconds);
    if (word_of(outcome) == "failed")
      log_.error(line + ": " +
                 (outcome.error.empty() ? "status " + std::to_string(*outcome.status) : outcome.error));
    else
      log_.info(line);
    outcomes_[slot.job] = std::move(outcome);
  }

  // One line for all devices: what each is at.
  void show() {
    std::string text = std::to_string(ended_) + " of " + std::to_string(jobs_.jobs.size()) + " ended";
    for (const Slot& slot : slots_) {
      if (!slot.bake) continue;
      text += "; " + slot.device + ": " + jobs_.jobs[slot.job].name;
      if (slot.bake->frames() > 0)
        text += " " + std::to_string(slot.bake->frame()) + "/" + std::to_string(slot.bake->frames());
    }
    log_.state(text);
  }

  void write_summary() const {
    Json rows = Json::array();
    for (std::size_t k = 0; k < outcomes_.size(); ++k) {
      const scene::Job& job = jobs_.jobs[k];
      const Outcome& outcome = outcomes_[k];
      rows.push_back({{"job", job.name},
                      {"folder", folder_of(job).string()},
                      {"scene", job.scene},
                      {"clip", job.clip},
                      {"set", job.set},
                      {"format", job.formats},
                      {"device", outcome.device},
                      {"status", word_of(outcome)},
                      {"exit_status", outcome.status ? Json(*outcome.status) : Json()},
                      {"seconds", outcome.seconds},
                      {"last_position_hash", outcome.hash},
                      {"error", outcome.error},
                      {"warnings", outcome.warnings}});
    }
    base::write_whole(jobs_.output / scene::batch_summary,
                      Json{{"jobs", rows}}.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  }

  void print_plan() const {
    std::cout << "dry run of " << jobs_.jobs.size() << (jobs_.jobs.size() == 1 ? " job" : " jobs")
              << ": nothing is written\n";
    for (const scene::Job& job : jobs_.jobs) {
      std::cout << "  fascicle";
      for (const std::string& word : command_of(job, split_device_list(arguments_.devices).front()))
        std::cout << " "
                  << (word.find_first_of(" |\"'[]{}()$&;*?") == std::string::npos ? word : "'" + word + "'");
      std::cout << "\n";
    }
  }

  void print_results() const {
    std::vector<std::pair<std::string, std::string>> rows;
    for (std::size_t k = 0; k < outcomes_.size(); ++k) {
      const Outcome& outcome = outcomes_[k];
      std::string text = word_of(outcome);
      if (outcome.status) text += " on " + outcome.device + " in " + duration_text(outcome.seconds);
      if (!outcome.hash.empty()) text += ", last frame " + outcome.hash;
      rows.emplace_back(jobs_.jobs[k].name, text);
    }
    std::cout << columns_text(rows) << "wrote " << (jobs_.output / scene::batch_summary).string() << "\n";
  }

  // The first failure's, as the others may follow from it.
  ExitCode code(bool interrupted) const {
    for (const Outcome& outcome : outcomes_)
      if (word_of(outcome) == "failed") {
        const int status = *outcome.status;
        return status <= static_cast<int>(ExitCode::difference) ? static_cast<ExitCode>(status)
                                                                : ExitCode::unforeseen;
      }
    if (!interrupted) return ExitCode::done;
    log_.warning(arguments_.overwrite
                     ? "interrupted; the same command with --resume (and without --overwrite) goes on with "
                       "what was begun, --overwrite starts all again"
                     : "interrupted; the same command with --resume goes on");
    return ExitCode::interrupted;
  }

  const BatchArguments& arguments_;
  scene::Jobs jobs_;
  Log& log_;
  std::vector<Outcome> outcomes_;
  std::vector<Slot> slots_;
  std::deque<std::size_t> waiting_;
  std::size_t ended_ = 0;
};

}  // namespace

void add_batch(CLI::App& app, Command& command) {
  auto* subcommand =
      app.add_subcommand("batch", "Bake a list of scenes, clips and variations, on several devices");
  const auto arguments = std::make_shared<BatchArguments>();
  subcommand
      ->add_option(
          "JOBS", arguments->jobs,
          "TOML: [job.NAME] with scene, clips = [...], set = [\"KEY=VALUE\", ...], format = [...] and "
          "[job.NAME.vary] \"KEY\" = [values]; output and format for all")
      ->required()
      ->option_text(" ");
  subcommand
      ->add_option(
          "--device", arguments->devices,
          "Devices to share the jobs, separated by commas: cpu, cpu:LEVEL, vulkan, vulkan:N; default: cpu")
      ->option_text("LIST");
  subcommand
      ->add_option("--threads", arguments->threads, "Threads of each CPU bake; 0 takes one for each core")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
  auto* overwrite = subcommand->add_flag("--overwrite", arguments->overwrite, "Replace bakes that are there");
  auto* resume = subcommand->add_flag("--resume", arguments->resume, "Go on with what is not done yet");
  overwrite->excludes(resume);
  subcommand->add_flag("--dry-run", arguments->dry_run, "Print each job's command; write nothing");
  add_log_options(*subcommand, command.log);
  subcommand->callback([arguments, &command] {
    command.run = [arguments](Log& log) {
      return Batch(*arguments, scene::read_jobs(arguments->jobs), log).run();
    };
  });
}

}  // namespace fascicle::cli
