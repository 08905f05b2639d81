// fascicle bench: the time per substep on each requested device, and of other programs for comparison. Each
// device's results must first match the scalar stages bit by bit; a time for a wrong result is worthless.
#include <algorithm>
#include <iostream>
#include <memory>

#include "cpu_reference/solver/cpu_solver.h"
#include "cpu_reference/solver/slices.h"
#include "cpu_reference/solver/sweeps.h"
#include "gpu/measure.h"
#include "host/base/version.h"
#include "host/cli/bench_measure.h"
#include "host/cli/bench_peers.h"
#include "host/cli/bench_results.h"
#include "host/cli/command.h"
#include "host/cli/text.h"
#include "host/model/validate.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::cli {
namespace {

struct BenchArguments {
  std::vector<std::uint32_t> vertices;
  std::vector<unsigned> threads;
  std::string devices = "cpu";
  std::string integrator = "both";
  std::vector<std::string> meshes;
  std::uint32_t rounds = 7;
  bool quick = false, peers = true;
  std::string json, csv, against;
};

constexpr std::uint32_t quick_vertices = 19000;
constexpr std::uint32_t quick_rounds = 5;

// A solver to time, and the row for its times.
struct Contestant {
  std::unique_ptr<model::Solver> solver;
  std::size_t row;
  std::uint32_t substeps;  // per sample
  gpu::Device* gpu;        // null: the CPU
};

std::vector<model::Integrator> integrators_of(const BenchArguments& arguments) {
  using model::Integrator;
  if (const auto one = base::named<Integrator>(arguments.integrator)) return {*one};
  return {Integrator::explicit_step, Integrator::implicit_step};
}

// Whether two solvers have the same state after two short frames. Resets both to rest.
bool ends_alike(model::Solver& a, model::Solver& b, const model::Model& model) {
  // More passes than the CPU solver takes in one sweep.
  const BenchDrive drive(model, model.is_implicit() ? 1 : cpu_reference::most_swept_passes + 1);
  for (int frame = 0; frame < 2; ++frame) {
    timed_frame(a, drive.drive());
    timed_frame(b, drive.drive());
  }
  const bool alike = a.save() == b.save();
  const model::State rest = model::rest_state(model);
  a.load(rest);
  b.load(rest);
  return alike;
}

// A benchmark must not touch the user's caches.
DeviceRequest without_kept_pipelines(DeviceRequest request) {
  request.keeps_pipelines = false;
  return request;
}

class Bench {
 public:
  Bench(const BenchArguments& arguments, BenchBefore before, Log& log)
      : arguments_(arguments), before_(std::move(before)), log_(log) {
    results_.machine.processor = processor_name();
    results_.machine.compiler = ChosenDevice::cpu(1, cpu_reference::Simd::automatic, "").description().driver;
    results_.machine.version = base::fascicle_version;
    results_.machine.cores = processor_threads();
    for (const cpu_reference::Simd level : cpu_reference::available_simd())
      results_.machine.levels.emplace_back(name_of(level));
  }

  ExitCode run() {
    const std::vector<DeviceRequest> requests = parse_device_list(arguments_.devices);
    for (const std::string& mesh : arguments_.meshes)
      for (const std::uint32_t vertices : arguments_.vertices)
        if (!measure(vertices, mesh == name_of(BenchMesh::filled) ? BenchMesh::filled : BenchMesh::regular,
                     requests))
          return ExitCode::difference;
    for (BenchRow& row : results_.rows) {
      if (!row.bytes) continue;
      const bool is_gpu = results_.machine.gpus.contains(row.device);
      if (is_gpu && !results_.copy.contains(row.device)) continue;
      const double rate = is_gpu ? results_.copy.at(row.device) : results_.triad.at(row.threads);
      row.triad = *row.bytes / row.median() / rate;
    }
    report();
    return ExitCode::done;
  }

 private:
  static void take_one_frame(const BenchBody& body) {
    const auto solver = cpu_reference::make_cpu_solver(body.model, body.options, 1);
    timed_frame(*solver, BenchDrive(body.model, 1).drive());
  }

  // Measures everything of one size in turn, round by round, so that other load on the machine affects all
  // alike.
  bool measure(std::uint32_t vertices, BenchMesh mesh, const std::vector<DeviceRequest>& requests) {
    std::vector<std::unique_ptr<BenchBody>> bodies;
    std::vector<std::vector<Contestant>> contestants;
    for (const model::Integrator integrator : integrators_of(arguments_)) {
      // Run a small body first, so that the program's own pages do not count towards the body's.
      take_one_frame(bench_body(100, integrator, BenchMesh::regular));
      reset_peak();
      const std::uint64_t before = resident_bytes();
      bodies.push_back(std::make_unique<BenchBody>(bench_body(vertices, integrator, mesh)));
      const BenchBody& body = *bodies.back();
      take_one_frame(body);
      const double peak = static_cast<double>(peak_resident_bytes() - before) / body.model.vertex_count;
      contestants.emplace_back();
      if (!enter(body, mesh, requests, peak, contestants.back())) return false;
    }
    std::vector<Peer> peers;
    if (arguments_.peers && mesh == BenchMesh::regular) peers = enter_peers(bodies.front()->grid);
    for (std::uint32_t round = 0; round < arguments_.rounds; ++round) {
      for (std::size_t k = 0; k < bodies.size(); ++k)
        for (const Contestant& contestant : contestants[k]) {
          time_one(*bodies[k], contestant);
          // Immediately, because idle devices lower their clocks.
          if (contestant.gpu) time_copies(contestant);
        }
      for (const Peer& peer : peers)
        results_.rows[peer.row].samples.push_back(run_peer(peer.kind, peer.grid, peer.substeps));
      for (const unsigned threads : arguments_.threads)
        results_.triad[threads] = std::max(results_.triad[threads], triad_rate(threads));
      log_.info("bench: " + count_text(bodies.front()->model.vertex_count) + " vertices, round " +
                std::to_string(round + 1) + " of " + std::to_string(arguments_.rounds));
    }
    for (std::size_t k = 0; k < bodies.size(); ++k)
      for (const Contestant& contestant : contestants[k])
        if (contestant.gpu) time_stages(*bodies[k], contestant);
    return true;
  }

  // Creates the solvers of one body and checks each against the scalar stages.
  bool enter(const BenchBody& body, BenchMesh mesh, const std::vector<DeviceRequest>& requests, double peak,
             std::vector<Contestant>& contestants) {
    const std::uint32_t passes =
        body.options.integrator == model::Integrator::implicit_step ? body.options.iterations : 1;
    for (const DeviceRequest& request : requests) {
      const bool is_cpu = request.kind == DeviceRequest::Kind::cpu;
      for (const unsigned threads : is_cpu ? arguments_.threads : std::vector<unsigned>{1}) {
        devices_.push_back(std::make_unique<ChosenDevice>(
            choose_device(without_kept_pipelines(request), threads, say_on(log_))));
        const ChosenDevice& device = *devices_.back();
        std::unique_ptr<model::Solver> solver = device.make_solver(body.model, body.options);
        const auto scalar =
            cpu_reference::make_cpu_solver(body.model, body.options, 0, cpu_reference::Simd::scalar);
        if (!ends_alike(*solver, *scalar, body.model)) {
          std::cout << device.label()
                    << ": results differ from the scalar stages, so it is not timed; see fascicle validate\n";
          return false;
        }
        BenchRow row;
        row.solver = device.description().solver;
        row.device = device.label();
        row.mesh = name_of(mesh);
        row.integrator = name_of(body.options.integrator);
        row.vertices = body.model.vertex_count;
        row.threads = threads;
        row.passes = passes;
        if (is_cpu && request.simd != cpu_reference::Simd::scalar)
          row.bytes = cpu_reference::substep_bytes(body.model, passes);
        if (is_cpu) row.peak_bytes = peak;
        if (device.gpu() != nullptr) {
          row.bytes = gpu::substep_bytes(body.model, passes);
          results_.machine.gpus[row.device] = device.description().name + ", " + device.description().driver;
        }
        const std::uint32_t substeps = is_cpu
                                           ? bench_substeps(row.vertices, passes, arguments_.quick)
                                           : substeps_in(arguments_.quick ? 0.1 : 0.3, *solver, body.model);
        contestants.push_back({std::move(solver), results_.rows.size(), substeps, device.gpu()});
        results_.rows.push_back(std::move(row));
      }
    }
    return true;
  }

  void time_one(const BenchBody& body, const Contestant& contestant) {
    BenchRow& row = results_.rows[contestant.row];
    const std::uint32_t substeps = contestant.substeps;
    const BenchDrive drive(body.model, substeps);
    // Warm the caches: in a bake, frames follow each other directly.
    timed_frame(*contestant.solver, BenchDrive(body.model, 1).drive());
    const double seconds = timed_frame(*contestant.solver, drive.drive());
    row.samples.push_back(seconds * 1e9 / substeps / row.vertices);
  }

  void time_stages(const BenchBody& body, const Contestant& contestant) {
    BenchRow& row = results_.rows[contestant.row];
    // Wake the device first, because idle devices lower their clocks.
    time_one(body, contestant);
    row.samples.pop_back();
    const BenchDrive drive(body.model, 1);
    try {
      for (const gpu::StageTime& time :
           gpu::stage_times(*contestant.gpu, body.model, body.options, drive.drive()))
        row.stages[time.stage] = time.nanoseconds / row.vertices;
    } catch (const gpu::DeviceError& error) {
      log_.warning(row.device + ": the stages could not be timed: " + error.what());
    }
  }

  // Needs memory in addition to the solvers'; skipped if there is not enough.
  void time_copies(const Contestant& contestant) {
    const std::string& device = results_.rows[contestant.row].device;
    try {
      const double rate = gpu::copy_rate(*contestant.gpu) * 1e-9;
      results_.copy[device] = std::max(results_.copy[device], rate);
    } catch (const gpu::DeviceError& error) {
      log_.warning(device + ": the copy rate could not be measured: " + error.what());
    }
  }

  struct Peer {
    std::string kind;
    std::array<std::uint32_t, 3> grid;
    std::uint32_t substeps;
    std::size_t row;
  };
  std::vector<Peer> enter_peers(const std::array<std::uint32_t, 3>& grid) {
    std::vector<Peer> peers;
    const std::uint32_t vertices = grid[0] * grid[1] * grid[2];
    // Above this, setting up Bullet's clusters takes minutes.
    constexpr std::uint32_t most = 150000;
    if (!has_peer_program() || vertices > most) {
      log_.info(has_peer_program()
                    ? "bench: skipping Bullet (too many vertices)"
                    : "bench: skipping Bullet (fascicle-bench-bullet is not next to fascicle; ./do "
                      "bench builds it)");
      return peers;
    }
    for (const char* kind : {"bullet-clusters", "bullet-links"}) {
      BenchRow row;
      row.solver = row.device = kind;
      row.integrator = "its own";
      row.vertices = vertices;
      peers.push_back(
          {kind, grid, std::max(3U, bench_substeps(vertices, 8, arguments_.quick)), results_.rows.size()});
      results_.rows.push_back(std::move(row));
    }
    return peers;
  }

  void report() {
    std::cout << results_.machine.processor << ", " << results_.machine.cores << " cores\n"
              << bench_table(results_);
    if (!arguments_.json.empty()) write_bench_json(arguments_.json, results_);
    if (!arguments_.csv.empty()) write_bench_csv(arguments_.csv, results_);
    if (arguments_.against.empty()) return;
    if (before_.processor != results_.machine.processor)
      log_.warning(arguments_.against + " was measured on another processor, " + before_.processor +
                   "; differences in time say nothing about the program");
    const BenchComparison comparison = compare_bench(results_, before_);
    std::cout << "against " << arguments_.against << "\n" << comparison.text;
    if (comparison.text.empty()) std::cout << "  it has no row that matches this run\n";
    if (comparison.slower > 0)
      log_.warning(std::to_string(comparison.slower) +
                   (comparison.slower == 1 ? " row became slower" : " rows became slower"));
  }

  const BenchArguments& arguments_;
  BenchBefore before_;
  Log& log_;
  BenchResults results_;
  std::vector<std::unique_ptr<ChosenDevice>> devices_;  // must outlive their solvers
};

ExitCode run_bench(BenchArguments arguments, Log& log) {
  if (arguments.quick) arguments.rounds = std::min(arguments.rounds, quick_rounds);
  if (arguments.vertices.empty())
    arguments.vertices = arguments.quick ? std::vector<std::uint32_t>{quick_vertices}
                                         : std::vector<std::uint32_t>{5000, 19000, 105000, 1000000};
  if (arguments.meshes.empty()) arguments.meshes = {name_of(BenchMesh::regular)};
  if (arguments.threads.empty()) {
    arguments.threads = {1};
    if (processor_threads() > 1) arguments.threads.push_back(processor_threads());
  }
  BenchBefore before;
  if (!arguments.against.empty()) before = read_bench_json(arguments.against);
  refuse_unwritable("--json", arguments.json);
  refuse_unwritable("--csv", arguments.csv);
  return Bench(arguments, std::move(before), log).run();
}

}  // namespace

void add_bench(CLI::App& app, Command& command) {
  auto* subcommand = app.add_subcommand("bench",
                                        "Time the substeps of a bar, beside other programs; results are "
                                        "compared bit by bit before they are timed");
  const auto arguments = std::make_shared<BenchArguments>();
  subcommand->add_flag("--quick", arguments->quick, "19,000 vertices and few rounds: under a minute");
  subcommand
      ->add_option("--vertices", arguments->vertices,
                   "Approximate numbers of vertices, separated by commas; default: 5000,19000,105000,1000000")
      ->delimiter(',')
      ->check(CLI::Range(12U, 20000000U).description(""))
      ->option_text("LIST");
  subcommand
      ->add_option("--devices", arguments->devices,
                   "Devices to time: cpu, cpu:LEVEL (a level of vector instructions), vulkan, vulkan:N, "
                   "separated by commas; default: cpu")
      ->option_text("LIST");
  subcommand
      ->add_option("--threads", arguments->threads,
                   "Threads of the CPU solver, separated by commas; default: 1 and one per core")
      ->delimiter(',')
      ->check(CLI::Range(1U, 1024U).description(""))
      ->option_text("LIST");
  subcommand->add_option("--integrator", arguments->integrator, "explicit, implicit or both; default: both")
      ->check(CLI::IsMember({name_of(model::Integrator::explicit_step),
                             name_of(model::Integrator::implicit_step), "both"})
                  .description(""))
      ->option_text("NAME");
  subcommand
      ->add_option("--meshes", arguments->meshes,
                   "regular, filled (meshed from the surface of the same bar) or both, separated by commas; "
                   "default: regular")
      ->delimiter(',')
      ->check(CLI::IsMember({name_of(BenchMesh::regular), name_of(BenchMesh::filled)}).description(""))
      ->option_text("LIST");
  subcommand->add_option("--rounds", arguments->rounds, "Samples per measurement, taken in turn; default: 7")
      ->check(CLI::Range(1U, 1000U).description(""))
      ->option_text("N");
  subcommand->add_flag("--peers,!--no-peers", arguments->peers,
                       "Time Bullet on the same bar if fascicle-bench-bullet is installed; default: on");
  subcommand->add_option("--json", arguments->json, "Write the results as JSON")->option_text("FILE");
  subcommand->add_option("--csv", arguments->csv, "Write the results as CSV")->option_text("FILE");
  subcommand->add_option("--against", arguments->against, "Report what is slower than in a --json FILE")
      ->option_text("FILE");
  add_log_options(*subcommand, command.log);
  subcommand->callback(
      [arguments, &command] { command.run = [arguments](Log& log) { return run_bench(*arguments, log); }; });
}

}  // namespace fascicle::cli
