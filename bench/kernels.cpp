// fascicle-bench-kernels [OPTIONS of Google Benchmark]: the CPU's stages alone, at every instruction level
// that the machine has, and the two rotations of a moment, on one thread. Each is verified before it is
// timed: a stage's bits against the scalar stage's, a rotation against the one its moment was made from. A
// difference ends the run with status 6, as in `fascicle bench`.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/huge_pages.h"
#include "cpu_reference/solver/lane_stages.h"
#include "cpu_reference/solver/slices.h"
#include "cpu_reference/solver/stages.h"
#include "host/base/process_start.h"
#include "host/cli/bench_measure.h"
#include "host/cli/exit_codes.h"
#include "host/model/implicit.h"
#include "shaders/kernel/rotation.inc"

namespace fascicle::bench {
namespace {

using cpu_reference::Column;
using cpu_reference::Fields;
using cpu_reference::LaneStage;
using cpu_reference::LaneStages;
using cpu_reference::LineAllocator;
using cpu_reference::Simd;
using model::Integrator;
using Matrix = kernel::Matrix<float>;
using Quaternion = kernel::Quaternion<float>;

// The result differs from the expected one, so it is not timed.
struct Difference : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct TimedStage {
  const char* name;
  Integrator integrator;
  LaneStage LaneStages::*in_lanes;
  void (*one_by_one)(const model::Model&, const cpu_reference::SubstepInput&, Fields&, cpu_reference::Range);
  bool needs_maps;  // from the region stage
};
constexpr TimedStage region_stage{"region", Integrator::explicit_step, &LaneStages::region,
                                  &cpu_reference::region, false};
constexpr std::array<TimedStage, 3> timed_stages{
    {region_stage,
     {"update", Integrator::explicit_step, &LaneStages::update, &cpu_reference::update, true},
     {"iterate", Integrator::implicit_step, &LaneStages::iterate, &cpu_reference::iterate, true}}};

// Two sizes for which bench/README.md has results. The first takes about 1 MB, which fits in a core's caches,
// the second 20.
constexpr std::array<std::uint32_t, 2> sizes{4600, 106624};

// The falling bar of `fascicle bench`, at the first region stage of a substep; for an implicit one, with the
// coefficients of the middle iteration.
struct MovingBar {
  MovingBar(std::uint32_t vertices, Integrator integrator)
      : bar(cli::bench_body(vertices, integrator)), drive(bar.model, substeps_before) {
    size_fields(bar.model, begun);
    slices = make_slices(bar.model, begun.memory);
    fill_constants(bar.model, slices, begun);
    in.step = model::first_substep(bar.model, drive.drive());
    in.decay = drive.drive().decay;
    place_moving_state();
    if (bar.model.is_implicit()) begin_implicit();
    now = begun;
  }

  void place_moving_state() {
    const auto solver = cpu_reference::make_cpu_solver(bar.model, bar.options, 1);
    cli::timed_frame(*solver, drive.drive());
    const model::State state = solver->save();
    using namespace cpu_reference;
    scatter(state.positions, 3, begun.vertices, vertex_stride, 0);
    scatter(state.velocities, 3, begun.velocities, vector_stride, 0);
    scatter(state.rotations, 4, begun.regions, region_stride, rotation_place);
    scatter(state.positions_before, 3, begun.positions_before, vector_stride, 0);
    scatter(state.velocities_before, 3, begun.velocities_before, vector_stride, 0);
  }

  void begin_implicit() {
    tables = model::implicit_tables(bar.model, bar.options, drive.drive().h);
    in.implicit = model::implicit_step(bar.model, tables, true);
    in.responses = std::span<const shader::Response>(tables.responses)
                       .subspan(in.implicit.first_response, bar.model.vertex_count);
    const model::Relaxation& middle = tables.relaxations[1].at(bar.options.iterations / 2);
    in.implicit.gain = middle.gain;
    in.implicit.omega = middle.omega;
    predict(bar.model, in, begun, {0, bar.model.vertex_count});
  }

  static constexpr std::uint32_t substeps_before = 20;
  cli::BenchBody bar;
  cli::BenchDrive drive;
  cpu_reference::HugePages pages;
  Fields begun{LineAllocator<float>(pages)}, now{LineAllocator<float>(pages)};
  cpu_reference::Slices slices;
  model::ImplicitTables tables;
  cpu_reference::SubstepInput in;
};

void run(MovingBar& body, const TimedStage& stage, Simd level) {
  const model::Model& model = body.bar.model;
  if (level == Simd::scalar)
    stage.one_by_one(model, body.in, body.now, {0, model.vertex_count});
  else
    (lane_stages(level)->*stage.in_lanes)(lane_input(model, body.slices, body.in, body.now),
                                          {0, body.slices.count});
}

// Resets to the start of the substep, then advances to the start of the stage.
void prepare(MovingBar& body, const TimedStage& stage, Simd level) {
  body.now = body.begun;
  if (stage.needs_maps) run(body, region_stage, level);
}

// All values that any of the stages writes, one after the other.
std::vector<float> written(const MovingBar& body) {
  using namespace cpu_reference;
  const model::Model& model = body.bar.model;
  const Fields& now = body.now;
  std::vector<Column> columns{{now.vertices, vertex_stride, 0, 3},
                              {now.regions, region_stride, 0, region_stride},
                              {now.velocities, vector_stride, 0, 3}};
  if (!model.is_implicit()) return gathered(model.vertex_count, columns);
  columns.push_back({now.iterate_before, vector_stride, 0, 3});
  columns.push_back({now.goals, vector_stride, 0, 3});
  std::vector<float> values = gathered(model.vertex_count, columns);
  // Nothing reads a kinematic vertex's goal: the lanes write a value there, the scalar stage does not.
  const std::size_t width = values.size() / model.vertex_count;
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    if (model.is_kinematic(static_cast<std::uint32_t>(i)))
      std::fill_n(values.begin() + static_cast<std::ptrdiff_t>((i + 1) * width - 3), 3, 0.0f);
  return values;
}

std::string name_of_run(const TimedStage& stage, Simd level, std::uint32_t vertices) {
  return std::string(stage.name) + "/" + name_of(level) + "/" + std::to_string(vertices);
}

void verify(MovingBar& body, const TimedStage& stage) {
  const auto result = [&](Simd level) {
    prepare(body, stage, level);
    run(body, stage, level);
    return written(body);
  };
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  const std::uint32_t vertices = body.bar.model.vertex_count;
  const std::vector<float> scalar = result(Simd::scalar);
  for (const Simd level : cpu_reference::available_simd()) {
    const std::vector<float> values = result(level);
    const auto differs = std::ranges::mismatch(values, scalar, {}, bits, bits).in1;
    if (differs == values.end()) continue;
    const auto place = static_cast<std::size_t>(differs - values.begin());
    throw Difference(name_of_run(stage, level, vertices) + ": other bits than the scalar stage at vertex " +
                     std::to_string(place / (values.size() / vertices)) +
                     ", not timed; see fascicle validate");
  }
}

// Created on first use, with every stage that is timed on it verified.
MovingBar& verified_bar(std::uint32_t vertices, Integrator integrator) {
  static std::map<std::pair<std::uint32_t, Integrator>, std::unique_ptr<MovingBar>> bars;
  std::unique_ptr<MovingBar>& bar = bars[{vertices, integrator}];
  if (bar) return *bar;
  bar = std::make_unique<MovingBar>(vertices, integrator);
  for (const TimedStage& stage : timed_stages)
    if (stage.integrator == integrator) verify(*bar, stage);
  return *bar;
}

// Runs `work` as often as Google Benchmark wants it. Its own rates have SI prefixes, so nanoseconds are
// measured here, in processor time because other programs may run at the same time.
template <class Work>
void time_items(benchmark::State& state, std::size_t items, const char* counter, const Work& work) {
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    work();
    benchmark::ClobberMemory();
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  state.counters[counter] =
      seconds * 1e9 / static_cast<double>(state.iterations()) / static_cast<double>(items);
}

// Runs the stage repeatedly on its own result: it executes the same instructions whatever the numbers are.
void time_stage(benchmark::State& state, const TimedStage& stage, Simd level, std::uint32_t vertices) {
  MovingBar& body = verified_bar(vertices, stage.integrator);
  prepare(body, stage, level);
  time_items(state, body.bar.model.vertex_count, "ns_per_vertex", [&] { run(body, stage, level); });
}

struct Moments {
  std::vector<Matrix> moment;
  std::vector<Quaternion> rotation;  // the best fit for the moment
  std::vector<Quaternion> before;    // some degrees away from it
};

// A = R V diag(s) V^T, whose rotation is R.
Moments random_moments(std::size_t count) {
  std::mt19937 engine(1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> stretch(0.5f, 1.0f);
  const Quaternion none{1.0f, 0.0f, 0.0f, 0.0f};
  const auto turned = [&](float w, float size) {
    return kernel::multiply_normalized<float>(
        {w, size * normal(engine), size * normal(engine), size * normal(engine)}, none);
  };
  Moments made;
  for (std::size_t k = 0; k < count; ++k) {
    const Quaternion frame = turned(normal(engine), 1.0f), rotation = turned(normal(engine), 1.0f);
    Matrix a = kernel::matrix_of<float>(kernel::multiply_normalized<float>(rotation, frame));
    const float s[3] = {stretch(engine), stretch(engine), stretch(engine)};
    a = {a.xx * s[0], a.xy * s[1], a.xz * s[2], a.yx * s[0], a.yy * s[1],
         a.yz * s[2], a.zx * s[0], a.zy * s[1], a.zz * s[2]};
    made.moment.push_back(kernel::multiply_transposed<float>(a, kernel::matrix_of<float>(frame)));
    made.rotation.push_back(rotation);
    made.before.push_back(kernel::multiply_normalized<float>(turned(1.0f, 0.02f), rotation));
  }
  return made;
}

// For rotations close to each other; q and -q are the same one.
double degrees_between(const Quaternion& a, const Quaternion& b) {
  const double sign =
      double{a.w} * b.w + double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z < 0 ? -1 : 1;
  const double w = a.w - sign * b.w, x = a.x - sign * b.x, y = a.y - sign * b.y, z = a.z - sign * b.z;
  return 2.0 * std::sqrt(w * w + x * x + y * y + z * z) * 180.0 / std::numbers::pi;
}

// `bound`: largest error, in degrees.
void time_rotation(benchmark::State& state, model::Rotation rotation, double bound) {
  const bool mueller = rotation == model::Rotation::mueller2016;
  static const Moments moments = random_moments(1024);
  const std::size_t count = moments.moment.size();
  std::vector<Quaternion> found(count);
  const auto extract_all = [&] {
    for (std::size_t k = 0; k < count; ++k)
      found[k] = kernel::extract_rotation<float>(moments.before[k], moments.moment[k], mueller);
    benchmark::DoNotOptimize(found.data());
  };
  extract_all();
  for (std::size_t k = 0; k < count; ++k) {
    const double error = degrees_between(found[k], moments.rotation[k]);
    // Written so that NaN counts as a difference too.
    if (error <= bound) continue;
    throw Difference(std::string("extract_rotation/") + name_of(rotation) + ": moment " + std::to_string(k) +
                     "'s rotation is wrong by " + std::to_string(error) + " degrees, not timed");
  }
  time_items(state, count, "ns_per_call", extract_all);
}

void register_all() {
  for (const std::uint32_t vertices : sizes)
    for (const TimedStage& stage : timed_stages)
      for (const Simd level : cpu_reference::available_simd())
        benchmark::RegisterBenchmark(name_of_run(stage, level, vertices).c_str(), time_stage, stage, level,
                                     vertices)
            ->Unit(benchmark::kMicrosecond);
  // Degrees: the bounds of tests/cpu_reference/rotation_test.cpp for such moments, three to five times the
  // worst error here.
  constexpr std::array<std::pair<model::Rotation, double>, 2> bounds{
      {{model::Rotation::qcp, 1.5e-4}, {model::Rotation::mueller2016, 0.03}}};
  for (const auto& [rotation, bound] : bounds)
    benchmark::RegisterBenchmark((std::string("extract_rotation/") + name_of(rotation)).c_str(),
                                 time_rotation, rotation, bound)
        ->Unit(benchmark::kMicrosecond);
}

}  // namespace
}  // namespace fascicle::bench

int main(int count, char** arguments) {
  fascicle::base::open_standard_streams();
  using fascicle::cli::ExitCode;
  fascicle::bench::register_all();
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return static_cast<int>(ExitCode::bad_usage);
  try {
    benchmark::RunSpecifiedBenchmarks();
  } catch (const fascicle::bench::Difference& difference) {
    std::cerr << "fascicle-bench-kernels: " << difference.what() << "\n";
    return static_cast<int>(ExitCode::difference);
  } catch (const std::exception& error) {
    std::cerr << "fascicle-bench-kernels: " << error.what() << "\n";
    return static_cast<int>(ExitCode::unforeseen);
  }
  return static_cast<int>(ExitCode::done);
}
