#include "host/cli/many_bakes.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include "host/bake/bake.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/base/errors.h"
#include "host/cli/bake_devices.h"
#include "host/cli/batch_summary.h"
#include "host/cli/child_bake.h"
#include "host/cli/device_failures.h"
#include "host/cli/interrupt.h"
#include "host/cli/job_record.h"
#include "host/cli/memory.h"
#include "host/cli/text.h"
#include "host/pipeline/device_choice.h"
#include "host/scene/jobs.h"

namespace fascicle::cli {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// A process ended by a signal has this status plus the signal's number.
constexpr int of_signal = 128;

// The result of a job; without a status if it never began.
struct Outcome {
  std::string device;
  std::optional<int> status;
  double seconds = 0.0;
  std::string error = {}, hash = {};
  std::vector<std::string> warnings = {};
};

std::string word_of(const Outcome& outcome) {
  return outcome.status ? word_of_status(*outcome.status) : "not begun";
}

// Exit statuses of a process crashed by a faulty driver.
bool is_crash(int status) {
  return status == of_signal + SIGSEGV || status == of_signal + SIGABRT || status == of_signal + SIGBUS;
}

std::string last_hash(const fs::path& folder) {
  try {
    const std::optional<bake::ManifestSummary> manifest = bake::read_manifest(folder);
    return manifest ? manifest->last_position_hash : std::string();
  } catch (const base::InputError&) {
    return {};  // one unreadable file must not end the other bakes
  }
}

class Batch {
 public:
  Batch(ManyBakes asked, Log& log)
      : asked_(std::move(asked)),
        log_(log),
        outcomes_(asked_.bakes.size()),
        failures_(split_device_list(asked_.devices)) {}

  ExitCode run() {
    require_devices(asked_.devices);
    check_folders();
    for (BakeDevice& device : devices_at_once(asked_)) slots_.push_back({std::move(device), nullptr, 0, {}});
    if (asked_.dry_run) {
      print_plan();
      return ExitCode::done;
    }
    for (std::size_t job = 0; job < asked_.bakes.size(); ++job) waiting_.push_back(job);
    const std::atomic<bool>& interrupted = interrupts();
    bake::make_folder(asked_.output);
    if (!asked_.is_part) {
      remember_settings();
      write_summary();
    }
    bool told = false;
    while (is_busy() || (!waiting_.empty() && !interrupted)) {
      if (!interrupted) {
        give_up_jobs();
        begin_jobs();
      }
      if (interrupted && !told) {
        told = true;
        for (const Slot& slot : slots_)
          if (slot.bake) slot.bake->interrupt();
      }
      wait_for_words();
      give_signs_of_life();
      watch();
      end_jobs(interrupted);
      show();
    }
    log_.clear_bar();
    if (!interrupted) log_.share(1.0);
    // Whoever reads the output may have gone: printing may end the program.
    try {
      if (!asked_.is_part) write_summary();
    } catch (...) {
      print_results(false);
      throw;
    }
    print_results(!asked_.is_part);
    return code(interrupted);
  }

 private:
  struct Slot {
    BakeDevice device;
    std::unique_ptr<ChildBake> bake;
    std::size_t job;
    Clock::time_point start;
  };

  fs::path folder_of(const OneBake& job) const { return asked_.output / job.name; }

  void check_folders() const {
    for (const OneBake& job : asked_.bakes) {
      if (!asked_.overwrite && !asked_.resume && bake::holds_bake(folder_of(job)))
        throw bake::FolderInUse(folder_of(job).string() +
                                ": holds a bake; --resume bakes what is not done, --overwrite "
                                "bakes everything again");
    }
    if (!asked_.overwrite && !asked_.is_part)
      refuse_foreign_summary(asked_.output, "move it away, or bake everything again with --overwrite");
  }

  std::vector<std::string> command_of(const OneBake& job, const BakeDevice& device) const {
    const auto number = static_cast<std::size_t>(&job - asked_.bakes.data());
    const std::string label = failures_.device_of(number, device.label);
    // A file name that starts with a dash would be taken for an option.
    const std::string scene = job.scene.starts_with('-') ? "./" + job.scene : job.scene;
    std::vector<std::string> command{"bake", scene, "-o", folder_of(job).string(), "--device", label};
    if (device.threads > 0) command.insert(command.end(), {"--threads", std::to_string(device.threads)});
    // Keep the frames that a device finished before it failed.
    command.push_back(asked_.overwrite && !begun_.contains(number) ? "--overwrite" : "--resume");
    command.insert(command.end(), job.options.begin(), job.options.end());
    return command;
  }

  bool is_busy() const {
    return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.bake != nullptr; });
  }

  void begin_jobs() {
    for (Slot& slot : slots_) {
      if (slot.bake || waiting_.empty() || (is_busy() && !has_room(slot.device))) continue;
      const auto next = std::find_if(waiting_.begin(), waiting_.end(), [&](std::size_t job) {
        return may_begin(job) && failures_.may_have(job, slot.device.label);
      });
      if (next == waiting_.end()) continue;
      slot.job = *next;
      waiting_.erase(next);
      const OneBake& job = asked_.bakes[slot.job];
      slot.start = Clock::now();
      keep_record(job, {.device = slot.device.label, .status = {}});
      try {
        slot.bake = std::make_unique<ChildBake>(command_of(job, slot.device));
        log_.detail(job.name + " starts on " + slot.device.label);
      } catch (const std::system_error& error) {
        end_job(slot.job, {.device = slot.device.label,
                           .status = static_cast<int>(ExitCode::unforeseen),
                           .error = error.what()});
      }
    }
  }

  // Of the bakes that share a model, the first runs alone until it has a frame. The others then find the
  // model in the cache.
  bool may_begin(std::size_t job) const {
    const std::string& model = asked_.bakes[job].model;
    if (model.empty() || built_.contains(model)) return true;
    return std::none_of(slots_.begin(), slots_.end(),
                        [&](const Slot& slot) { return slot.bake && asked_.bakes[slot.job].model == model; });
  }

  // Whether one more bake as large as the largest so far fits next to the running ones, each of which may
  // still grow to that size. The size is known once a bake has frames. On a GPU, a bake is assumed to take no
  // more than in main memory.
  bool has_room(const BakeDevice& device) const {
    if (!one_had_frames_) return false;
    std::uint64_t on_device = largest_memory_, wanted = largest_memory_ + largest_memory_ / 4;
    for (const Slot& slot : slots_) {
      if (!slot.bake) continue;
      wanted += largest_memory_ - std::min(largest_memory_, memory_of(slot.bake->process()));
      if (slot.device.label == device.label) on_device += largest_memory_;
    }
    if (device.memory > 0 && on_device > device.memory - device.memory / 4) return false;
    const std::optional<std::uint64_t> available = available_memory();
    return !available || wanted <= *available;
  }

  void watch() {
    for (const Slot& slot : slots_) {
      if (!slot.bake) continue;
      largest_memory_ = std::max(largest_memory_, memory_of(slot.bake->process()));
      if (slot.bake->frames() == 0) continue;
      one_had_frames_ = true;
      built_.insert(asked_.bakes[slot.job].model);
      begun_.insert(slot.job);
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

  // Passes on lines that others, such as the driver, wrote to a bake's stderr.
  void pass_on(const Slot& slot) {
    for (const std::string& line : slot.bake->take_other_lines())
      log_.info(asked_.bakes[slot.job].name + ": " + line);
  }

  // Whether the device failed and another one takes the job, which then resumes from the last checkpoint.
  bool hand_over(const Slot& slot, const Outcome& outcome) {
    const std::string& label = slot.device.label;
    const bool is_gpu = parse_device(label).kind != DeviceRequest::Kind::cpu;
    const bool cannot_run = *outcome.status == static_cast<int>(ExitCode::no_such_device);
    if (!cannot_run && *outcome.status != static_cast<int>(ExitCode::device_failed) &&
        !(is_gpu && is_crash(*outcome.status))) {
      failures_.clear(label);
      return false;
    }
    const bool was_off = failures_.is_off(label);
    failures_.add(slot.job, label, slot.start, cannot_run);
    if (!failures_.has_a_device(slot.job)) return false;
    const std::string what = "on " + label + ": " + outcome.error + "; retrying on another device";
    log_.warning(asked_.bakes[slot.job].name + " " + what);
    if (failures_.is_off(label) && !was_off)
      log_.warning(label + " failed two bakes in a row and is not used again");
    tries_[slot.job].push_back(what);
    outcomes_[slot.job] = outcome;
    waiting_.push_front(slot.job);
    return true;
  }

  // Ends jobs whose last remaining device has been taken off.
  void give_up_jobs() {
    for (std::size_t k = waiting_.size(); k-- > 0;) {
      const std::size_t job = waiting_[k];
      if (failures_.has_a_device(job)) continue;
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(k));
      end_job(job, Outcome(outcomes_[job]));
    }
  }

  void end_jobs(bool interrupted) {
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
      if (*outcome.status >= of_signal && outcome.error.empty())
        outcome.error =
            "its process was killed by signal " + std::to_string(*outcome.status - of_signal) + " (" +
            strsignal(*outcome.status - of_signal) + ")" +
            (*outcome.status == of_signal + SIGKILL ? "; if memory ran out, lower --at-once" : "");
      // If a bake was rejected, the folder may hold an older one.
      if (word_of(outcome) != "failed") outcome.hash = last_hash(folder_of(asked_.bakes[slot.job]));
      const bool is_begun = slot.bake->frames() > 0;
      slot.bake.reset();
      if (is_begun) begun_.insert(slot.job);
      if (!interrupted && hand_over(slot, outcome)) continue;
      end_job(slot.job, std::move(outcome));
    }
  }

  void end_job(std::size_t number, Outcome outcome) {
    const OneBake& job = asked_.bakes[number];
    ++ended_;
    if (word_of(outcome) == "done") built_.insert(job.model);
    outcome.warnings.insert(outcome.warnings.begin(), tries_[number].begin(), tries_[number].end());
    // The clips of a character share most of their warnings.
    for (const std::string& warning : outcome.warnings) {
      if (said_.insert(warning).second)
        log_.warning(job.name + ": " + warning);
      else
        log_.detail(job.name + ": warning: " + warning);
    }
    const std::string line = "[" + std::to_string(ended_) + "/" + std::to_string(asked_.bakes.size()) + "] " +
                             job.name + " on " + outcome.device + ": " + word_of(outcome) + ", " +
                             duration_text(outcome.seconds);
    if (word_of(outcome) == "failed")
      log_.error(line + ": " +
                 (outcome.error.empty() ? "status " + std::to_string(*outcome.status) : outcome.error));
    else
      log_.info(line);
    keep_record(job, outcome);
    outcomes_[number] = std::move(outcome);
  }

  // If this process bakes only part of a batch, records the job for the final merge.
  void keep_record(const OneBake& job, const Outcome& outcome) {
    if (!asked_.is_part) return;
    try {
      write_job_record(asked_.output, job.name,
                       {name_of_this_host(), static_cast<long>(::getpid()), outcome.device, outcome.status,
                        outcome.error, outcome.warnings, settings_text(job)});
    } catch (const std::runtime_error& error) {
      log_.warning(job.name + ": its record cannot be written: " + error.what());
    }
  }

  // A bake may build or settle for longer than a job's record stays fresh.
  void give_signs_of_life() {
    if (!asked_.is_part || Clock::now() - last_sign_ < sign_of_life_interval) return;
    last_sign_ = Clock::now();
    for (const Slot& slot : slots_)
      if (slot.bake) give_sign_of_life(asked_.output, asked_.bakes[slot.job].name);
  }

  // One line that shows what each device is doing.
  void show() {
    constexpr std::size_t most_shown = 4;
    std::size_t shown = 0;
    auto done = static_cast<double>(ended_);
    std::string text = std::to_string(ended_) + " of " + std::to_string(asked_.bakes.size()) + " ended";
    for (const Slot& slot : slots_) {
      if (!slot.bake) continue;
      if (slot.bake->frames() > 0)
        done += static_cast<double>(slot.bake->frame()) / static_cast<double>(slot.bake->frames());
      if (++shown > most_shown) continue;
      text += "; " + slot.device.label + ": " + asked_.bakes[slot.job].name;
      if (slot.bake->frames() > 0)
        text += " " + std::to_string(slot.bake->frame()) + "/" + std::to_string(slot.bake->frames());
    }
    if (shown > most_shown) text += "; and " + std::to_string(shown - most_shown) + " more";
    log_.state(text);
    log_.share(std::min(done / static_cast<double>(asked_.bakes.size()), 0.999));
  }

  void remember_settings() {
    try {
      for (const SummaryRow& row : read_batch_summary(asked_.output).value_or(std::vector<SummaryRow>()))
        if (std::string settings = settings_of_bake(row); !settings.empty())
          before_[row.job] = std::move(settings);
    } catch (const base::BakeError&) {
      // With --overwrite, another program's file is replaced.
    } catch (const base::InputError&) {
    }
  }

  void write_summary() const {
    std::vector<SummaryRow> rows;
    for (std::size_t k = 0; k < outcomes_.size(); ++k) {
      const OneBake& job = asked_.bakes[k];
      const Outcome& outcome = outcomes_[k];
      rows.push_back({.job = job.name,
                      .folder = folder_of(job),
                      .scene = job.scene,
                      .clip = job.clip,
                      .set = job.set,
                      .formats = job.formats,
                      .device = outcome.device,
                      .status = word_of(outcome),
                      .exit_status = outcome.status,
                      .seconds = outcome.seconds,
                      .hash = outcome.hash,
                      .error = outcome.error,
                      .warnings = outcome.warnings});
      // What this run has not begun is what it was.
      if (const auto before = before_.find(job.name); !outcome.status && before != before_.end())
        if (before->second != settings_text(rows.back())) rows.back().baked = before->second;
    }
    write_batch_summary(asked_.output, rows);
  }

  void print_plan() const {
    std::cout << "dry run of " << asked_.bakes.size() << (asked_.bakes.size() == 1 ? " job" : " jobs")
              << ": nothing is written\n";
    for (const OneBake& job : asked_.bakes) {
      std::cout << "  fascicle";
      for (const std::string& word : command_of(job, slots_.front().device))
        std::cout << " " << shell_word(word);
      std::cout << "\n";
    }
  }

  void print_results(bool has_summary) const {
    std::vector<std::pair<std::string, std::string>> rows;
    for (std::size_t k = 0; k < outcomes_.size(); ++k) {
      const Outcome& outcome = outcomes_[k];
      std::string text = word_of(outcome);
      if (outcome.status) text += " on " + outcome.device + " in " + duration_text(outcome.seconds);
      if (!outcome.hash.empty()) text += ", last frame " + outcome.hash;
      rows.emplace_back(asked_.bakes[k].name, text);
    }
    std::cout << columns_text(rows);
    if (has_summary) std::cout << "wrote " << (asked_.output / scene::batch_summary).string() << "\n";
  }

  // If nothing is left to do, the status of the first failure, since the others may follow from it. An
  // interrupted batch with work left says so even after a failure: a farm then goes on with it.
  ExitCode code(bool interrupted) const {
    const auto failure = std::find_if(outcomes_.begin(), outcomes_.end(),
                                      [](const Outcome& outcome) { return word_of(outcome) == "failed"; });
    const bool is_work_left = std::any_of(outcomes_.begin(), outcomes_.end(), [](const Outcome& outcome) {
      return word_of(outcome) != "failed" && word_of(outcome) != "done";
    });
    if (failure != outcomes_.end() && !(interrupted && is_work_left))
      return code_of_failure(*failure->status);
    if (!interrupted && !is_work_left) return ExitCode::done;
    log_.warning(asked_.overwrite
                     ? "interrupted; the same command with --resume (and without --overwrite) continues; "
                       "with --overwrite it starts again"
                     : "interrupted; the same command with --resume continues");
    return ExitCode::interrupted;
  }

  ManyBakes asked_;
  Log& log_;
  std::vector<Outcome> outcomes_;
  std::vector<Slot> slots_;
  std::deque<std::size_t> waiting_;
  DeviceFailures failures_;
  std::map<std::size_t, std::vector<std::string>> tries_;  // per job, on devices that failed
  std::set<std::size_t> begun_;                            // jobs that had frames in this run
  std::size_t ended_ = 0;
  std::set<std::string> built_;  // OneBake::model of bakes that had frames
  bool one_had_frames_ = false;
  Clock::time_point last_sign_ = Clock::now();
  std::map<std::string, std::string> before_;  // per job: the settings of the bake that an earlier run left
  std::uint64_t largest_memory_ = 0;           // bytes, of any bake so far
  std::set<std::string> said_;                 // warnings
};

}  // namespace

ExitCode bake_many(ManyBakes asked, Log& log) {
  return Batch(std::move(asked), log).run();
}

CLI::Option* add_many_bakes_options(CLI::App& subcommand, unsigned& at_once) {
  return subcommand
      .add_option("--at-once", at_once,
                  "Parallel bakes on each device; 0: on the CPU one per core, as far as memory allows; they "
                  "share the cores")
      ->check(CLI::Range(0U, 1024U).description(""))
      ->option_text("N");
}

}  // namespace fascicle::cli
