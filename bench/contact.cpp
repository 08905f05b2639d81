// fascicle-bench-contact [OPTIONS]: compares contact with Bullet's deformable bodies. Built-in scenes are
// baked twice in one run, by fascicle's CPU solver and by Bullet (bullet_solver.h): the same tetrahedra,
// masses, moduli, skeleton, solids and frames, on one thread, with the same measurements. A table goes to
// stdout.
//
// squeeze is also the check: both must push back with the force of rod theory, to within a tenth. If one does
// not, the run ends with status 6 before anything else is timed, as in `fascicle bench`. Later scenes check
// that what follows the skeleton does.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/bullet_solver.h"
#include "bench/contact_measures.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/bake.h"
#include "host/base/helper_program.h"
#include "host/base/process_start.h"
#include "host/base/version.h"
#include "host/build/cache.h"
#include "host/cli/exit_codes.h"
#include "host/cli/text.h"
#include "host/drive/drive_source.h"
#include "host/pipeline/build_scene.h"
#include "host/pipeline/device_choice.h"

namespace fascicle::bench {
namespace {

namespace fs = std::filesystem;
using cli::number_text;
using Json = nlohmann::ordered_json;

struct Arguments {
  std::vector<std::string> scenes{"squeeze", "drop", "crouch"};
  std::vector<std::string> set;
  std::string json, bakes;
  bool only_bullet = false;
  std::uint32_t rate = 0;
  BulletSettings bullet;
};

// A measured value of a scene; a missing one was not measured, or is not meaningful.
struct Figure {
  std::string scene, name;
  std::optional<double> theory, skinning, fascicle, bullet;
};

struct Subject {
  scene::Scene scene;
  pipeline::Built built;
  const model::Model& model() const { return built.model; }
};

// Processor time of this thread, s: other programs may run at the same time, and frames are measured on
// another thread.
double processor_seconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// Passes a solver's frames on, and records them and their time.
class Recorder : public model::Solver {
 public:
  explicit Recorder(model::Solver& solver) : solver_(solver) {}
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override {
    const double start = processor_seconds();
    solver_.submit(drive, what | model::Read{.positions = true, .velocities = true, .skinned = true}, probe);
    seconds_ += processor_seconds() - start;
  }
  model::Frame collect() override {
    const double start = processor_seconds();
    model::Frame frame = solver_.collect();
    seconds_ += processor_seconds() - start;
    frames_.push_back(frame);
    return frame;
  }
  model::State save() const override { return solver_.save(); }
  void load(const model::State& state) override { solver_.load(state); }

  const Frames& frames() const { return frames_; }
  double milliseconds_a_frame() const { return 1e3 * seconds_ / static_cast<double>(frames_.size()); }

 private:
  model::Solver& solver_;
  Frames frames_;
  double seconds_ = 0.0;
};

class Comparison {
 public:
  explicit Comparison(const Arguments& arguments) : arguments_(arguments) {}

  cli::ExitCode run() {
    for (const std::string& name : arguments_.scenes)
      if (!compare(name)) return cli::ExitCode::difference;
    return cli::ExitCode::done;
  }

  std::string table() const {
    std::string text;
    const auto line = [&](std::array<std::string, 6> cells) {
      constexpr std::array<std::size_t, 6> widths{9, 50, 9, 10, 10, 10};
      for (std::size_t k = 0; k < cells.size(); ++k) {
        cells[k].resize(std::max(widths[k], cells[k].size()), ' ');
        text += cells[k] + (k + 1 < cells.size() ? " " : "\n");
      }
    };
    const auto cell = [](const std::optional<double>& value) { return value ? number_text(*value, 4) : ""; };
    line({"scene", "", "theory", "skinning", "fascicle", "Bullet"});
    for (const Figure& f : figures_)
      line({f.scene, f.name, cell(f.theory), cell(f.skinning), cell(f.fascicle), cell(f.bullet)});
    return text;
  }

  Json json() const;

 private:
  bool compare(const std::string& name);
  Frames bake(const Subject& subject, model::Solver& solver, std::uint32_t substeps, const std::string& what);
  Measures measure(const Subject& subject, std::uint32_t substeps, const Frames& frames, double force) const;
  void add(const std::string& scene, const Measures& measures, std::optional<double> Figure::*of);
  Figure& figure(const std::string& scene, const std::string& name);

  const Arguments& arguments_;
  std::vector<Figure> figures_;
  double milliseconds_ = 0.0;  // per frame, in the last bake
};

// Per second. With fewer substeps, more of a bear's flesh passes through itself.
constexpr double bullet_contact_rate = 960.0;
std::uint32_t bullet_substeps(const Subject& subject, const Arguments& arguments) {
  if (arguments.rate == 0 && !subject.model().has_contact()) return subject.built.steps.substeps;
  const double rate = arguments.rate == 0 ? bullet_contact_rate : arguments.rate;
  return static_cast<std::uint32_t>(std::max(1l, std::lround(rate / subject.scene.fps)));
}

Frames Comparison::bake(const Subject& subject, model::Solver& solver, std::uint32_t substeps,
                        const std::string& what) {
  const base::TemporaryFolder temporary;
  bake::BakeOptions options;
  options.folder = arguments_.bakes.empty() ? temporary.path() / what
                                            : fs::path(arguments_.bakes) / (subject.scene.name + "-" + what);
  options.overwrite = true;
  options.substeps = substeps;
  options.iterations = subject.built.steps.iterations;
  options.checkpoint_seconds = 1e9;
  options.device.solver = options.device.name = what;
  options.device.threads = 1;
  options.on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
    if (frame % 10 == 0 || frame == frames)
      std::cerr << subject.scene.name << ", " << what << ": frame " << frame << " of " << frames << "\n";
  };
  Recorder recorder(solver);
  bake::bake(subject.scene, subject.model(), recorder, options);
  milliseconds_ = recorder.milliseconds_a_frame();
  return recorder.frames();
}

Measures Comparison::measure(const Subject& subject, std::uint32_t substeps, const Frames& frames,
                             double force) const {
  drive::DriveSource drives(subject.scene, subject.model(), substeps);
  // Without solids, the scene tests self-contact.
  if (drives.solids(frames.back().index).empty())
    return measure_crouch(subject.scene, subject.model(), frames);
  if (std::holds_alternative<scene::Bar>(subject.scene.geometry))
    return measure_squeeze(subject.scene, subject.model(), drives, frames, force);
  return measure_drop(subject.scene, subject.model(), drives, frames);
}

Figure& Comparison::figure(const std::string& scene, const std::string& name) {
  for (Figure& f : figures_)
    if (f.scene == scene && f.name == name) return f;
  figures_.push_back({scene, name, {}, {}, {}, {}});
  return figures_.back();
}

void Comparison::add(const std::string& scene, const Measures& measures, std::optional<double> Figure::*of) {
  for (const auto& [name, value] : measures) figure(scene, name).*of = value;
}

bool Comparison::compare(const std::string& name) {
  scene::SceneOverrides overrides;
  overrides.set = arguments_.set;
  if (name == "drop") overrides.end = 5.0;  // the built-in scene ends before it comes to rest
  Subject subject{scene::load_scene(name, overrides), {}};
  build::BuildOptions options;
  options.cache = build::default_cache_folder();
  subject.built = pipeline::build_scene(subject.scene, options, {});
  const model::Model& model = subject.model();
  const bool is_bar = std::holds_alternative<scene::Bar>(subject.scene.geometry);
  const std::uint32_t frames = static_cast<std::uint32_t>(scene::frame_count(subject.scene));
  double own_force = 0.0, bullet_force = 0.0;
  std::cerr << name << ": " << model.vertex_count << " vertices, " << model.tetrahedron_count()
            << " tetrahedra, " << frames << " frames\n";

  if (!arguments_.only_bullet) {
    const std::uint32_t substeps = subject.built.steps.substeps;
    const auto solver = cpu_reference::make_cpu_solver(
        model, pipeline::solver_options(subject.scene, subject.built.steps), 1);
    const Frames baked = bake(subject, *solver, substeps, "fascicle");
    const double milliseconds = milliseconds_;
    if (is_bar) {
      drive::DriveSource drives(subject.scene, model, substeps);
      own_force = force_on_top(model, flesh_forces(model, *solver, drives.drive(frames)));
    }
    add(name, measure(subject, substeps, baked, own_force), &Figure::fascicle);
    figure(name, "substeps a second").fascicle = substeps * subject.scene.fps;
    figure(name, "processor time, ms a frame").fascicle = milliseconds;
    if (model.has_contact())
      add(name, measure_overlap(model, baked, &model::Frame::skinned), &Figure::skinning);
  }

  const std::uint32_t substeps = bullet_substeps(subject, arguments_);
  BulletSettings settings = arguments_.bullet;
  settings.self = settings.self && model.has_contact();
  settings.self_friction = subject.scene.contact.friction;
  BulletSolver solver(model, settings);
  const Frames baked = bake(subject, solver, substeps, "bullet");
  const double milliseconds = milliseconds_;
  if (is_bar) bullet_force = force_on_top(model, solver.flesh_forces());
  if (!(furthest_from_skeleton(model, baked) < 1e-5 * model::extent(model)))
    throw std::runtime_error(name + ": Bullet's vertices that follow the skeleton do not");
  add(name, measure(subject, substeps, baked, bullet_force), &Figure::bullet);
  figure(name, "substeps a second").bullet = substeps * subject.scene.fps;
  figure(name, "processor time, ms a frame").bullet = milliseconds;
  if (!is_bar) return true;
  const double theory = rod_force(subject.scene);
  figure(name, force_name).theory = theory;
  const auto is_off = [&](double force) { return !(std::abs(force - theory) < 0.1 * theory); };
  return !is_off(bullet_force) && (arguments_.only_bullet || !is_off(own_force));
}

Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json Comparison::json() const {
  const BulletSettings& b = arguments_.bullet;
  Json object{{"machine",
               {{"processor", pipeline::processor_name()},
                {"cores", pipeline::processor_threads()},
                {"fascicle", base::fascicle_version},
                {"solver_version", base::solver_version},
                {"bullet", bullet_version()}}},
              {"bullet_settings",
               {{"integrator", b.implicit ? "implicit" : "explicit"},
                {"law", b.linear ? "corotated linear" : "Neo-Hookean"},
                {"contacts", b.projects ? "projection" : "Lagrange multipliers"},
                {"line_search", b.line_search},
                {"newton_steps", b.newton_steps},
                {"poisson", b.poisson},
                {"viscosity", b.viscosity},
                {"margin", b.margin},
                {"repulsion", b.repulsion},
                {"error_reduction", b.error_reduction},
                {"contact_iterations", b.contact_iterations}}},
              {"figures", Json::array()}};
  for (const Figure& f : figures_)
    object["figures"].push_back({{"scene", f.scene},
                                 {"name", f.name},
                                 {"theory", json_of(f.theory)},
                                 {"skinning", json_of(f.skinning)},
                                 {"fascicle", json_of(f.fascicle)},
                                 {"bullet", json_of(f.bullet)}});
  return object;
}

void add_options(CLI::App& app, Arguments& a) {
  BulletSettings& b = a.bullet;
  app.add_option("--scenes", a.scenes, "of squeeze, drop and crouch")
      ->delimiter(',')
      ->check(CLI::IsMember({"squeeze", "drop", "crouch"}));
  app.add_option("--set", a.set, "PATH=VALUE, a key of the scenes, for both")->allow_extra_args(false);
  app.add_option("--json", a.json, "file for the figures and the machine");
  app.add_option("--bakes", a.bakes, "folder for the bakes, which `fascicle render` draws");
  app.add_flag("--only-bullet", a.only_bullet, "leave fascicle out");
  app.add_option("--rate", a.rate,
                 "Bullet: substeps a second; 0: as many as fascicle takes, and 960 in crouch");
  app.add_flag("--implicit", b.implicit, "Bullet: implicit elastic forces");
  app.add_flag("!--lagrange", b.projects, "Bullet: contacts with solids by Lagrange multipliers");
  app.add_flag("--line-search", b.line_search, "Bullet: line search in Newton's steps");
  app.add_option("--newton", b.newton_steps, "Bullet: Newton steps, most, a substep");
  app.add_flag("--linear", b.linear, "Bullet: corotated linear elasticity");
  app.add_flag("!--raw-moduli", b.converts, "Bullet: moduli as its Neo-Hookean law takes them");
  app.add_option("--poisson", b.poisson, "Bullet: Poisson's ratio");
  app.add_option("--viscosity", b.viscosity, "Bullet: s");
  app.add_option("--margin", b.margin, "Bullet: m");
  app.add_option("--repulsion", b.repulsion, "Bullet: N/m between flesh that meets flesh");
  app.add_flag("!--no-self", b.self, "Bullet: flesh does not meet flesh");
  app.add_option("--error-reduction", b.error_reduction, "Bullet: share of a depth in a plane, a substep");
  app.add_option("--contact-iterations", b.contact_iterations, "Bullet: with solids, a substep");
}

}  // namespace
}  // namespace fascicle::bench

int main(int count, char** words) {
  fascicle::base::open_standard_streams();
  using fascicle::cli::ExitCode;
  fascicle::bench::Arguments arguments;
  CLI::App app{"contact beside Bullet's deformable bodies", "fascicle-bench-contact"};
  fascicle::bench::add_options(app, arguments);
  CLI11_PARSE(app, count, words);
  try {
    fascicle::bench::Comparison comparison(arguments);
    const ExitCode code = comparison.run();
    std::cout << comparison.table();
    if (code == ExitCode::difference)
      std::cerr << "fascicle-bench-contact: a bar does not push back as rod theory says\n";
    if (!arguments.json.empty()) {
      std::ofstream file(arguments.json);
      file << comparison.json().dump(2) << "\n";
      if (!file.flush()) throw std::runtime_error(arguments.json + ": cannot be written");
    }
    return static_cast<int>(code);
  } catch (const std::exception& error) {
    std::cerr << "fascicle-bench-contact: " << error.what() << "\n";
    return static_cast<int>(ExitCode::unforeseen);
  }
}
