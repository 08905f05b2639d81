#include "host/cli/bench_measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

#include <malloc.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "host/build/build.h"
#include "host/scene/scene.h"

namespace fascicle::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double bench_h = 1.0 / 600.0;
constexpr std::uint32_t bench_iterations = 20;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::uint64_t status_bytes(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key + ":")) return std::stoull(line.substr(key.size() + 1)) * 1024;
  return 0;
}

}  // namespace

const char* name_of(BenchMesh mesh) {
  return mesh == BenchMesh::filled ? "filled" : "regular";
}

BenchBody bench_body(std::uint32_t vertices, model::Integrator integrator, BenchMesh mesh) {
  // The bar has (k + 1)^2 (5 k + 1) vertices.
  std::uint32_t k = 1;
  const auto count = [](std::uint64_t cells) { return (cells + 1) * (cells + 1) * (5 * cells + 1); };
  while (count(k) < vertices) ++k;
  if (k > 1 && vertices - count(k - 1) < count(k) - vertices) --k;
  BenchBody body;
  body.grid = {k + 1, 5 * k + 1, k + 1};
  const bool implicit = integrator == model::Integrator::implicit_step;
  scene::SceneOverrides overrides;
  overrides.set = {"bar.size=[0.1, 0.5, 0.1]",
                   "bar.vertices=[" + std::to_string(k + 1) + ", " + std::to_string(5 * k + 1) + ", " +
                       std::to_string(k + 1) + "]",
                   "bar.jitter=0.1", "layers.body.beta=0.7", "layers.body.fibre=[0.0, 1.0, 0.0]"};
  scene::Scene scene = scene::load_scene(implicit ? "rod-hang" : "bar-hang-none", overrides);
  build::BuildOptions options;
  if (mesh == BenchMesh::filled) {
    const mesh::TetMesh regular = build::make_bar(std::get<scene::Bar>(scene.geometry), scene.name);
    const build::RenderMesh boundary = build::boundary_render_mesh(regular, scene.name);
    mesh::SurfaceMesh surface{.vertices = {}, .triangles = boundary.triangles};
    for (std::size_t v = 0; v < boundary.corners.size(); ++v) {
      scene::Vector3d place = scene::Vector3d::Zero();
      for (std::size_t c = 0; c < 4; ++c)
        place += boundary.weights[v][c] * regular.vertices[boundary.corners[v][c]];
      surface.vertices.push_back(place);
    }
    scene.geometry = std::move(surface);
    scene.body.cage = scene::Cage::off;
    scene.body.vertices = vertices;
    options.mesher_seconds = 600.0;
  }
  build::Report report;
  body.model = build::build_model(scene, report, options);
  body.options = {.integrator = integrator, .iterations = bench_iterations};
  return body;
}

BenchDrive::BenchDrive(const model::Model& model, std::uint32_t substeps)
    : substeps_(substeps), gravity_{0.0f, static_cast<float>(-9.81 / model.unit), 0.0f} {
  for (const model::Layer& layer : model.layers)
    decay_.push_back(static_cast<float>(std::exp(-layer.damping * bench_h)));
}

model::Drive BenchDrive::drive() const {
  model::Drive drive;
  drive.substeps = substeps_;
  drive.h = bench_h;
  drive.gravity = gravity_;
  drive.decay = decay_;
  return drive;
}

std::uint32_t bench_substeps(std::uint32_t vertices, std::uint32_t passes, bool quick) {
  const double work = (quick ? 1e6 : 2e6) / (static_cast<double>(vertices) * passes);
  // About as many as a frame has; with fewer, the CPU solver could not combine several substeps.
  const double least = std::max(2.0, 8.0 / passes);
  return static_cast<std::uint32_t>(std::clamp(work, least, 200.0));
}

std::uint32_t substeps_in(double seconds, model::Solver& solver, const model::Model& model) {
  constexpr std::uint32_t fewest = 2, most = 4000;
  std::uint32_t substeps = fewest;
  double took = timed_frame(solver, BenchDrive(model, substeps).drive());
  while (took < seconds / 4 && substeps < most) {
    substeps = std::min(4 * substeps, most);
    took = timed_frame(solver, BenchDrive(model, substeps).drive());
  }
  return std::clamp(static_cast<std::uint32_t>(substeps * seconds / took), fewest, most);
}

double timed_frame(model::Solver& solver, const model::Drive& drive) {
  const Clock::time_point start = Clock::now();
  solver.submit(drive, {});
  solver.collect();
  return seconds_since(start);
}

double triad_rate(unsigned threads) {
  constexpr std::size_t count = (std::size_t{64} << 20) / sizeof(double);
  constexpr int passes = 4;
  std::vector<double> a(count, 1.0), b(count, 2.0), c(count, 3.0);
  const auto part = [&](unsigned thread) {
    const std::size_t first = count * thread / threads, last = count * (thread + 1) / threads;
    for (std::size_t k = first; k < last; ++k) a[k] = b[k] + 1.5 * c[k];
  };
  double best = 1e30;
  for (int pass = 0; pass < passes; ++pass) {
    const Clock::time_point start = Clock::now();
    // The destructor joins them, also if the system refuses to start another one.
    std::vector<std::jthread> others;
    for (unsigned thread = 1; thread < threads; ++thread) others.emplace_back(part, thread);
    part(0);
    others.clear();
    best = std::min(best, seconds_since(start));
  }
  return 3.0 * sizeof(double) * count / best * 1e-9;
}

std::uint64_t resident_bytes() {
  return status_bytes("VmRSS");
}

std::uint64_t peak_resident_bytes() {
  return status_bytes("VmHWM");
}

void reset_peak() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  // Writing 5 resets the peak to the current size (proc(5)).
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace fascicle::cli
