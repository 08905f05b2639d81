#include "host/cli/many_bakes.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <iostream>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>
#include <poll.h>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/base/part_file.h"
#include "host/cli/child_bake.h"
#include "host/cli/interrupt.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

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
  Batch(ManyBakes asked, Log& log) : asked_(std::move(asked)), log_(log), outcomes_(asked_.bakes.size()) {}

  ExitCode run() {
    check_devices();
    check_folders();
    fill_slots();
    if (asked_.dry_run) {
      print_plan();
      return ExitCode::done;
    }
    for (std::size_t job = 0; job < asked_.bakes.size(); ++job) waiting_.push_back(job);
    bake::make_folder(asked_.output);
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
      watch_memory();
      end_jobs();
      show();
    }
    log_.clear_bar();
    print_results();
    write_summary();
    return code(interrupted);
  }

 private:
  struct Device {
    std::string label;
    unsigned threads;  // of each bake; 0: as it takes by itself
  };
  struct Slot {
    Device device;
    std::unique_ptr<ChildBake> bake;
    std::size_t job;
    Clock::time_point start;
  };

  // In turns, so that few jobs are shared by all devices.
  void fill_slots() {
    std::vector<std::pair<Device, unsigned>> devices;
    unsigned most = 0;
    for (const std::string& label : split_device_list(asked_.devices)) {
      const bool is_cpu = parse_device(label).kind == DeviceRequest::Kind::cpu;
      const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
      const unsigned at_once = asked_.at_once > 0 ? asked_.at_once
                               : is_cpu           ? cores
                                                  : bakes_on_a_gpu(label, cores);
      const auto bakes = static_cast<unsigned>(std::min<std::size_t>(at_once, asked_.bakes.size()));
      const unsigned threads =
          asked_.threads > 0 || !is_cpu || bakes <= 1 ? asked_.threads : std::max(1U, cores / bakes);
      devices.push_back({{label, threads}, bakes});
      most = std::max(most, bakes);
    }
    for (unsigned turn = 0; turn < most; ++turn)
      for (const auto& [device, bakes] : devices)
        if (turn < bakes) slots_.push_back({device, nullptr, 0, {}});
  }

  // A GPU waits for the thread that feeds it for most of a bake. A driver that computes on the CPU takes all
  // cores for one.
  static unsigned bakes_on_a_gpu(const std::string& label, unsigned cores) {
    constexpr unsigned most = 8;
    const std::vector<gpu::DeviceInfo> found = candidates(parse_device(label), gpu::list_devices());
    if (found.empty() || found.front().software) return 1;
    return std::clamp(cores / 2, 1U, most);
  }

  fs::path folder_of(const OneBake& job) const { return asked_.output / job.name; }

  // A device that is not there would fail one job after the other, faster than the others bake them.
  void check_devices() const {
    const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
    const std::vector<std::string> labels = split_device_list(asked_.devices);
    const std::vector<DeviceRequest> requests = parse_device_list(asked_.devices);
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

  void check_folders() const {
    for (const OneBake& job : asked_.bakes) {
      if (!asked_.overwrite && !asked_.resume && bake::holds_bake(folder_of(job)))
        throw bake::FolderInUse(folder_of(job).string() +
                                ": holds a bake; --resume bakes what is not done, --overwrite "
                                "bakes all again");
    }
  }

  std::vector<std::string> command_of(const OneBake& job, const Device& device) const {
    std::vector<std::string> command{"bake",     job.scene,   "-o", folder_of(job).string(),
                                     "--device", device.label};
    if (device.threads > 0) command.insert(command.end(), {"--threads", std::to_string(device.threads)});
    command.push_back(asked_.overwrite ? "--overwrite" : "--resume");
    command.insert(command.end(), job.options.begin(), job.options.end());
    return command;
  }

  bool is_busy() const {
    return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.bake != nullptr; });
  }

  void begin_jobs() {
    for (Slot& slot : slots_) {
      if (slot.bake || waiting_.empty()) continue;
      const auto next =
          std::find_if(waiting_.begin(), waiting_.end(), [this](std::size_t job) { return may_begin(job); });
      if (next == waiting_.end()) return;
      slot.job = *next;
      waiting_.erase(next);
      const OneBake& job = asked_.bakes[slot.job];
      slot.start = Clock::now();
      try {
        slot.bake = std::make_unique<ChildBake>(command_of(job, slot.device));
        log_.detail(job.name + " begins on " + slot.device.label);
      } catch (const std::system_error& error) {
        end_job(slot, {.device = slot.device.label,
                       .status = static_cast<int>(ExitCode::unforeseen),
                       .error = error.what()});
      }
    }
  }

  // The first bake of a scene goes alone until it has a frame: the others then find its model in the cache.
  // And how much memory a bake takes is known of those that have frames only.
  bool may_begin(std::size_t job) const {
    if (!is_busy()) return true;
    for (const Slot& slot : slots_)
      if (slot.bake && slot.bake->frames() == 0 && asked_.bakes[slot.job].scene == asked_.bakes[job].scene)
        return false;
    return largest_memory_ > 0 && has_room();
  }

  // Whether one more bake as large as the largest fits beside those that run, each of which may grow to that.
  bool has_room() const {
    const std::optional<std::uint64_t> available = available_memory();
    if (!available) return true;
    std::uint64_t wanted = largest_memory_ + largest_memory_ / 4;
    for (const Slot& slot : slots_)
      if (slot.bake) wanted += largest_memory_ - std::min(largest_memory_, slot.bake->memory().now);
    return wanted <= *available;
  }

  void watch_memory() {
    for (const Slot& slot : slots_)
      if (slot.bake && slot.bake->frames() > 0)
        largest_memory_ = std::max({largest_memory_, slot.bake->memory().most, std::uint64_t{1}});
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
      log_.info(asked_.bakes[slot.job].name + ": " + line);
  }

  void end_jobs() {
    for (Slot& slot : slots_) {
      if (!slot.bake) continue;
      const bool has_ended = slot.bake->has_ended();
      pass_on(slot);
      if (!has_ended) continue;
      Outcome outcome{.device = slot.device.label,
                      .status = slot.bake->status(),
                      .seconds = std::chrono::duration<double>(Clock::now() - slot.start).count(),
                      .error = slot.bake->error(),
                      .warnings = slot.bake->warnings()};
      // Of a bake that was refused the folder may hold an older one.
      if (word_of(outcome) != "failed") outcome.hash = last_hash(folder_of(asked_.bakes[slot.job]));
      slot.bake.reset();
      end_job(slot, std::move(outcome));
    }
  }

  void end_job(const Slot& slot, Outcome outcome) {
    const OneBake& job = asked_.bakes[slot.job];
    ++ended_;
    for (const std::string& warning : outcome.warnings) log_.warning(job.name + ": " + warning);
    const std::string line = "[" + std::to_string(ended_) + "/" + std::to_string(asked_.bakes.size()) + "] " +
                             job.name + " on " + slot.device.label + ": " + word_of(outcome) + ", " +
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
    constexpr std::size_t most_shown = 4;
    std::size_t shown = 0;
    std::string text = std::to_string(ended_) + " of " + std::to_string(asked_.bakes.size()) + " ended";
    for (const Slot& slot : slots_) {
      if (!slot.bake) continue;
      if (++shown > most_shown) continue;
      text += "; " + slot.device.label + ": " + asked_.bakes[slot.job].name;
      if (slot.bake->frames() > 0)
        text += " " + std::to_string(slot.bake->frame()) + "/" + std::to_string(slot.bake->frames());
    }
    if (shown > most_shown) text += "; and " + std::to_string(shown - most_shown) + " more";
    log_.state(text);
  }

  void write_summary() const {
    Json rows = Json::array();
    for (std::size_t k = 0; k < outcomes_.size(); ++k) {
      const OneBake& job = asked_.bakes[k];
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
    base::write_whole(asked_.output / scene::batch_summary,
                      Json{{"jobs", rows}}.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  }

  void print_plan() const {
    std::cout << "dry run of " << asked_.bakes.size() << (asked_.bakes.size() == 1 ? " job" : " jobs")
              << ": nothing is written\n";
    for (const OneBake& job : asked_.bakes) {
      std::cout << "  fascicle";
      for (const std::string& word : command_of(job, slots_.front().device))
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
      rows.emplace_back(asked_.bakes[k].name, text);
    }
    std::cout << columns_text(rows) << "wrote " << (asked_.output / scene::batch_summary).string() << "\n";
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
    log_.warning(asked_.overwrite
                     ? "interrupted; the same command with --resume (and without --overwrite) goes on with "
                       "what was begun, --overwrite starts all again"
                     : "interrupted; the same command with --resume goes on");
    return ExitCode::interrupted;
  }

  ManyBakes asked_;
  Log& log_;
  std::vector<Outcome> outcomes_;
  std::vector<Slot> slots_;
  std::deque<std::size_t> waiting_;
  std::size_t ended_ = 0;
  std::uint64_t largest_memory_ = 0;  // bytes, of a bake that had frames
};

}  // namespace

ExitCode bake_many(ManyBakes asked, Log& log) {
  return Batch(std::move(asked), log).run();
}

void add_many_bakes_options(CLI::App& subcommand, unsigned& at_once) {
  subcommand
      .add_option(
          "--at-once", at_once,
          "Bakes at once on each device; 0 takes one for each core on the CPU, where memory allows, and "
          "shares the cores among them")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
}

}  // namespace fascicle::cli
