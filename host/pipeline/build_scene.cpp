#include "host/pipeline/build_scene.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/pipeline/kept_model.h"
#include "host/pipeline/long_wait.h"
#include "host/pipeline/text.h"

namespace fascicle::pipeline {
namespace {

constexpr std::size_t warning_vertices_shown = 8;
// Faster builds are not cached: finding them would take as long.
constexpr double least_kept_seconds = 0.2;

// The build polls is_cancelled; each poll may be due for a progress message.
build::BuildOptions with_words(const build::BuildOptions& options, const Say& say) {
  build::BuildOptions result = options;
  result.is_cancelled = [asked = options.is_cancelled, wait = std::make_shared<LongWait>(say)] {
    wait->go_on("still building the body");
    return asked && asked();
  };
  return result;
}

void leave_out_irrelevant_warnings(const scene::Scene& scene, build::Report& report) {
  if (scene.gravity.isZero(0.0))
    std::erase_if(report.warnings, [](const build::Warning& warning) { return warning.is_of_gravity; });
}

}  // namespace

Built build_scene(const scene::Scene& scene, const build::BuildOptions& options, const Say& say) {
  Built built;
  const auto start = std::chrono::steady_clock::now();
  const std::optional<std::string> key = kept_model_key(scene, options);
  if (std::optional<KeptModel> kept = key ? find_kept_model(*key, options) : std::nullopt) {
    built.model = std::move(kept->model);
    built.report = std::move(kept->report);
    built.report.is_kept = true;
    built.report.body_from_cache = false;
    built.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  } else {
    built.model = build::build_model(scene, built.report, with_words(options, say));
    // Solvers rely on it: a build error would cause wild reads there.
    model::check_model(built.model);
    if (key && built.report.seconds >= least_kept_seconds)
      keep_model(*key, built.model, built.report, options);
  }
  leave_out_irrelevant_warnings(scene, built.report);
  built.steps = build::choose_steps(scene, built.model, built.report);
  if (built.report.is_kept)
    say_detail(say, "the model came from " + options.cache.string());
  else if (built.report.body_from_cache)
    say_detail(say, "the filled body came from " + options.cache.string());
  say_detail(say, "model: " + counted_text(built.report.vertices, "vertex", "vertices") + ", " +
                      counted_text(built.report.tetrahedra, "tetrahedron", "tetrahedra") + ", " +
                      (built.report.is_kept ? "found in " : "built in ") +
                      duration_text(built.report.seconds));
  say_detail(say, "substeps: " + std::to_string(built.steps.substeps) + " a frame; " + built.steps.reason);
  if (built.model.is_implicit())
    say_detail(say, "iterations: " + std::to_string(built.steps.iterations) + " a substep");
  return built;
}

Built build_scene_again(const scene::Scene& scene, const build::BuildOptions& options,
                        build::BuildMemory& memory) {
  Built built;
  built.model = build::build_model(scene, built.report, options, memory);
  model::check_model(built.model);
  leave_out_irrelevant_warnings(scene, built.report);
  built.steps = build::choose_steps(scene, built.model, built.report);
  return built;
}

model::SolverOptions solver_options(const scene::Scene& scene, const build::Steps& steps) {
  const scene::SolverSettings& solver = scene.solver;
  return {.integrator = solver.integrator,
          .rotation = solver.rotation,
          .iterations = steps.iterations,
          .viscosity = solver.viscosity};
}

std::string warning_text(const build::Warning& warning) {
  if (warning.vertices.empty()) return warning.text;
  std::string text = warning.text + " (vertices";
  for (std::size_t k = 0; k < warning.vertices.size() && k < warning_vertices_shown; ++k)
    text += " " + std::to_string(warning.vertices[k]);
  return text + (warning.vertices.size() > warning_vertices_shown ? " ...)" : ")");
}

void say_warnings(const build::Report& report, const Say& say) {
  for (const build::Warning& warning : report.warnings) say_warning(say, warning_text(warning));
}

std::vector<bake::OpenEndEntry> open_ends_of(const build::Report& report) {
  // Indexed by build::OpenEnd::Fate.
  static constexpr std::array<const char*, 3> fates{"closed", "left open: the outline of a sheet",
                                                    "left open: a hem around several limbs"};
  const build::OpenEnds& ends = report.fill.cage.ends;
  std::vector<bake::OpenEndEntry> entries;
  for (std::size_t k = 0; k < ends.vertex.size(); ++k) {
    const bool has_joint =
        ends.joint[k] >= 0 && static_cast<std::size_t>(ends.joint[k]) < report.joints.size();
    entries.push_back({has_joint ? report.joints[static_cast<std::size_t>(ends.joint[k])].name : "",
                       fates[std::min<std::size_t>(ends.fate[k], fates.size() - 1)], ends.width[k],
                       ends.edges[k], ends.vertex[k]});
  }
  return entries;
}

}  // namespace fascicle::pipeline
