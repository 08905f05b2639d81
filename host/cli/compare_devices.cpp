#include "host/cli/compare_devices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>

#include "cpu_reference/oracle/oracle.h"
#include "host/bake/bake.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"

namespace fascicle::cli {
namespace {

using OnFrame = std::function<void(const std::string& what, std::uint64_t frame, std::uint64_t frames)>;

// Counts stage values on their way to a comparison.
class CountingProbe : public model::Probe {
 public:
  CountingProbe(model::Probe& next, std::uint64_t& count) : next_(next), count_(count) {}
  void on_stage(const model::Where& where, std::span<const float> values) override {
    count_ += values.size();
    next_.on_stage(where, values);
  }

 private:
  model::Probe& next_;
  std::uint64_t& count_;
};

class CountingSolver : public model::Solver {
 public:
  explicit CountingSolver(model::Solver& solver) : solver_(solver) {}
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override {
    if (probe == nullptr) {
      solver_.submit(drive, what);
      return;
    }
    CountingProbe counting(*probe, count_);
    solver_.submit(drive, what, &counting);
  }
  model::Frame collect() override { return solver_.collect(); }
  model::State save() const override { return solver_.save(); }
  void load(const model::State& state) override { solver_.load(state); }
  std::uint64_t count() const { return count_; }

 private:
  model::Solver& solver_;
  std::uint64_t count_ = 0;
};

void check_finite(const model::Frame& frame, std::uint64_t number, const std::string& device) {
  for (std::size_t k = 0; k < frame.positions.size(); ++k)
    if (!std::isfinite(frame.positions[k]))
      throw bake::NotFinite("positions are no longer finite numbers on " + device + " in frame " +
                            std::to_string(number) + " at vertex " + std::to_string(k / 3) +
                            "; use more substeps, a lower alpha or smaller forces");
}

// The inputs shared by all parts of one validation.
struct Run {
  const model::Model& model;
  const model::SolverOptions& options;
  drive::DriveSource source;
  model::State start;
  std::uint64_t frames, oracle_frames;
  const OnFrame& on_frame;

  std::unique_ptr<model::Solver> solver(const ChosenDevice& device) const {
    std::unique_ptr<model::Solver> made = device.make_solver(model, options);
    made->load(start);
    return made;
  }
  // Drives that also report each requested frame.
  model::DriveSource drives(const std::string& what, std::uint64_t last) {
    return [this, what, last](std::uint64_t frame) {
      on_frame(what, frame, last);
      return source.drive(frame);
    };
  }
};

HashComparison compare_hashes(Run& run, const ChosenDevice& a, const ChosenDevice& b) {
  const std::unique_ptr<model::Solver> solver_a = run.solver(a), solver_b = run.solver(b);
  const model::DriveSource drives =
      run.drives("comparing hashes of " + a.label() + " and " + b.label(), run.frames);
  HashComparison comparison;
  for (std::uint64_t frame = 1; frame <= run.frames; ++frame) {
    const model::Drive drive = drives(frame);
    solver_a->submit(drive, {.positions = true});
    solver_b->submit(drive, {.positions = true});
    const model::Frame frame_a = solver_a->collect(), frame_b = solver_b->collect();
    comparison.last_hash_a = model::position_hash(frame_a);
    comparison.last_hash_b = model::position_hash(frame_b);
    comparison.frames = frame;
    // Compare before checking for finite values: devices that diverge to different non-finite values do
    // differ.
    if (comparison.last_hash_a != comparison.last_hash_b) {
      comparison.first_different_frame = frame;
      return comparison;
    }
    check_finite(frame_a, frame, a.label());
  }
  return comparison;
}

Comparison compare(Run& run, const ChosenDevice& a, const ChosenDevice& b, double extent) {
  Comparison comparison;
  comparison.a = a.label();
  comparison.b = b.label();
  comparison.exact = a.description().exact && b.description().exact;
  const std::unique_ptr<model::Solver> solver_a = run.solver(a), solver_b = run.solver(b);
  if (!comparison.exact) {
    const model::DriveSource drives =
        run.drives("measuring " + b.label() + " against " + a.label(), run.frames);
    comparison.distance = model::distance_to(run.model, *solver_b, *solver_a, drives, run.frames);
    comparison.relative = comparison.distance.largest / extent;
    return comparison;
  }
  comparison.hashes = compare_hashes(run, a, b);
  CountingSolver counting(*solver_a);
  comparison.difference = model::first_difference(
      counting, *solver_b, run.drives("comparing stages of " + a.label() + " and " + b.label(), run.frames),
      run.frames);
  comparison.values = counting.count();
  return comparison;
}

OracleComparison compare_with_oracle(Run& run, const ChosenDevice& device, double extent) {
  cpu_reference::Oracle oracle(run.model, run.options);
  oracle.load(run.start);
  const std::unique_ptr<model::Solver> solver = run.solver(device);
  OracleComparison comparison;
  comparison.device = device.label();
  const model::DriveSource drives =
      run.drives("measuring " + device.label() + " against the oracle", run.oracle_frames);
  comparison.distance = model::distance_to(run.model, *solver, oracle, drives, run.oracle_frames);
  comparison.relative = comparison.distance.largest / extent;
  return comparison;
}

}  // namespace

bool Comparison::holds() const {
  return exact ? !starts_differ && !difference && !hashes.first_different_frame : relative <= oracle_bound;
}

bool Validation::holds() const {
  return std::all_of(comparisons.begin(), comparisons.end(), [](const Comparison& c) { return c.holds(); }) &&
         std::all_of(oracle.begin(), oracle.end(), [](const OracleComparison& c) { return c.holds(); });
}

Validation validate(const scene::Scene& scene, const Built& built, const model::SolverOptions& options,
                    const std::vector<ChosenDevice>& devices, std::uint64_t frames,
                    std::uint64_t oracle_frames, const OnFrame& on_frame) {
  const model::Model& model = built.model;
  Run run{model,         options, drive::DriveSource(scene, model, built.steps.substeps), {}, frames,
          oracle_frames, on_frame};
  const auto start_on = [&](const ChosenDevice& device) {
    on_frame("preparing " + device.label(), 0, frames);
    const std::unique_ptr<model::Solver> solver = device.make_solver(model, options);
    return drive::lead_in(scene, model, run.source, *solver).state;
  };
  run.start = start_on(devices.front());
  Validation validation;
  validation.frames = frames;
  validation.oracle_frames = oracle_frames;
  validation.extent = model::extent(model);
  for (std::size_t k = 1; k < devices.size(); ++k) {
    validation.comparisons.push_back(compare(run, devices.front(), devices[k], validation.extent));
    Comparison& comparison = validation.comparisons.back();
    if (comparison.exact) comparison.starts_differ = start_on(devices[k]) != run.start;
  }
  if (oracle_frames == 0) return validation;
  // Devices found identical share one distance, which is measured once.
  validation.oracle.push_back(compare_with_oracle(run, devices.front(), validation.extent));
  for (std::size_t k = 1; k < devices.size(); ++k) {
    const Comparison& comparison = validation.comparisons[k - 1];
    if (comparison.exact && comparison.holds()) {
      OracleComparison same = validation.oracle.front();
      same.device = devices[k].label();
      validation.oracle.push_back(same);
    } else {
      validation.oracle.push_back(compare_with_oracle(run, devices[k], validation.extent));
    }
  }
  return validation;
}

}  // namespace fascicle::cli
