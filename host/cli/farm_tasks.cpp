#include "host/cli/farm_tasks.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <map>
#include <memory>

#include "host/build/cache.h"
#include "host/cli/estimate.h"
#include "host/cli/exit_codes.h"
#include "host/cli/memory.h"
#include "host/cli/text.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {
namespace {

using FarmClock = std::chrono::steady_clock;

// The cost of baking a model.
struct Cost {
  double seconds_before = 0.0;  // until the first frame, including the build
  double seconds_frame = 0.0;
};

Cost measured_cost(const scene::Job& job, const FarmBatch& batch, std::uint64_t& memory, bool& is_on_cpu) {
  scene::SceneOverrides overrides;
  overrides.set = job.set;
  if (!job.clip.empty()) overrides.clip = job.clip;
  BakeRequest request;
  request.output.folder = batch.jobs.output / job.name;
  request.output.formats = job.formats;
  request.writes_nothing = true;
  request.devices = {parse_device(is_on_cpu ? "cpu" : batch.device)};
  request.threads = std::min(batch.threads, processor_threads());
  request.build.cache = build::default_cache_folder();
  const auto silent = [](Severity, const std::string&) {};
  const FarmClock::time_point start = FarmClock::now();
  std::unique_ptr<PreparedBake> prepared;
  try {
    scene::Scene scene = scene::load_scene(job.scene, overrides);
    // One clip stands for all; a bake without contact takes a fraction of the time.
    scene.contact.unless_torn = false;
    prepared = prepare_bake(std::move(scene), request, silent);
  } catch (const NoSuchDevice&) {
    if (is_on_cpu) throw;
    is_on_cpu = true;  // only the nodes have the GPU
    return measured_cost(job, batch, memory, is_on_cpu);
  }
  Cost cost;
  cost.seconds_before = std::chrono::duration<double>(FarmClock::now() - start).count();
  const Estimate estimate = estimate_of(*prepared, request.output);
  cost.seconds_frame = estimate.seconds / static_cast<double>(std::max<std::uint64_t>(1, estimate.frames));
  memory = std::max({memory, estimate.solver_bytes, peak_memory()});
  return cost;
}

}  // namespace

void cut_into_tasks(FarmBatch& batch, const std::vector<FarmJob>& jobs, unsigned group, Log& log) {
  constexpr double longest_measuring = 60.0, worth_a_task = 120.0;  // s
  const FarmClock::time_point start = FarmClock::now();
  std::map<std::string, Cost> costs;
  Cost largest;
  bool is_on_cpu = false;
  std::uint64_t memory = 0;
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    if (costs.contains(jobs[k].model)) continue;
    // Variations of one body cost about the same: if time runs out, assume the largest measured cost.
    const bool has_time = std::chrono::duration<double>(FarmClock::now() - start).count() < longest_measuring;
    const Cost cost = has_time ? measured_cost(batch.jobs.jobs[k], batch, memory, is_on_cpu) : largest;
    costs[jobs[k].model] = cost;
    largest.seconds_before = std::max(largest.seconds_before, cost.seconds_before);
    largest.seconds_frame = std::max(largest.seconds_frame, cost.seconds_frame);
  }
  if (is_on_cpu && batch.is_gpu)
    log.info("this machine has no device " + batch.device + "; measuring times on its CPU instead");

  std::map<std::string, std::size_t> open;  // by model: the task that takes its next job
  std::vector<double> seconds;              // per task
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const Cost& cost = costs.at(jobs[k].model);
    const double bake = cost.seconds_before + cost.seconds_frame * static_cast<double>(jobs[k].frames);
    const auto found = open.find(jobs[k].model);
    const bool has_room = found != open.end() && (group > 0 ? batch.tasks[found->second].size() < group
                                                            : seconds[found->second] + bake <= worth_a_task);
    if (!has_room) {
      open[jobs[k].model] = batch.tasks.size();
      batch.tasks.emplace_back();
      seconds.push_back(0.0);
    }
    const std::size_t task = open.at(jobs[k].model);
    batch.tasks[task].push_back(batch.jobs.jobs[k].name);
    seconds[task] += bake;
  }
  // A node may be half as fast as this machine, with a slow file system. A task that is cut short can be
  // resumed.
  batch.seconds = 2.0 * *std::max_element(seconds.begin(), seconds.end()) + 600.0;
  constexpr std::uint64_t step = std::uint64_t{64} << 20, beside = std::uint64_t{256} << 20;
  batch.memory = (2 * memory + beside + step - 1) / step * step;
}

void refuse_control_characters(const std::string& what, const std::string& text) {
  const bool is_plain = std::none_of(text.begin(), text.end(),
                                     [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; });
  if (!is_plain)
    throw UsageError(what +
                     ": contains a control character, such as a newline, which a script cannot hold; "
                     "give it another name");
}

}  // namespace fascicle::cli
