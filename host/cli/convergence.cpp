#include "host/cli/convergence.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/cli/text.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"

namespace fascicle::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t reference_refinement = 2;  // factor on the finest quality's substeps and iterations
constexpr std::uint32_t most_substeps_of_a_frame = 1000;

build::Steps steps_of_quality(scene::Scene scene, scene::Quality quality, const model::Model& model) {
  scene.solver.auto_substeps = true;
  scene.solver.iterations.reset();
  scene.solver.quality = quality;
  build::Report unheard;  // discarded: the scene's warnings were reported when it was built
  return build::choose_steps(scene, model, unheard);
}

std::vector<SteppedSkin> skins_of(const scene::Scene& scene, const Built& built) {
  std::vector<SteppedSkin> skins;
  bool is_scenes_among = false;
  for (const scene::Quality quality :
       {scene::Quality::draft, scene::Quality::normal, scene::Quality::final}) {
    SteppedSkin skin;
    skin.quality = scene::name_of(quality);
    skin.steps = steps_of_quality(scene, quality, built.model);
    skin.is_scenes =
        scene.solver.auto_substeps && !scene.solver.iterations && scene.solver.quality == quality;
    is_scenes_among = is_scenes_among || skin.is_scenes;
    skins.push_back(std::move(skin));
  }
  if (!is_scenes_among) {
    SteppedSkin skin;
    skin.quality = "as stated";
    skin.is_scenes = true;
    skin.steps = built.steps;
    skins.push_back(std::move(skin));
  }
  std::stable_sort(skins.begin(), skins.end(), [](const SteppedSkin& a, const SteppedSkin& b) {
    return a.steps.substeps < b.steps.substeps;
  });
  return skins;
}

// Doubling the iterations squares the residual that `final` leaves of a substep's change.
build::Steps reference_of(const std::vector<SteppedSkin>& skins) {
  build::Steps steps = skins.back().steps;
  for (const SteppedSkin& skin : skins)
    if (skin.quality == scene::name_of(scene::Quality::final))
      steps.iterations = std::max(steps.iterations, skin.steps.iterations);
  steps.substeps = std::min(most_substeps_of_a_frame, steps.substeps * reference_refinement);
  steps.iterations *= reference_refinement;
  return steps;
}

// A solver with its own drives and start state.
struct Stepped {
  std::unique_ptr<drive::DriveSource> drives;
  std::unique_ptr<model::Solver> solver;
  double seconds = 0.0;

  Stepped(const scene::Scene& scene, const model::Model& model, const build::Steps& steps,
          const ChosenDevice& device)
      : drives(std::make_unique<drive::DriveSource>(scene, model, steps.substeps)),
        solver(device.make_solver(model, solver_options(scene, steps))) {
    (void)drive::lead_in(scene, model, *drives, *solver);
  }

  model::Frame step(std::uint64_t frame, model::Read what) {
    const model::Drive drive = drives->drive(frame);
    const Clock::time_point start = Clock::now();
    solver->submit(drive, what);
    model::Frame done = solver->collect();
    seconds += std::chrono::duration<double>(Clock::now() - start).count();
    return done;
  }
};

const std::vector<float>& skin_in(const model::Frame& frame) {
  return frame.surface.empty() ? frame.positions : frame.surface;
}

bake::NotFinite not_finite(std::uint64_t frame, const std::string& how) {
  return bake::NotFinite("positions are no longer finite numbers in frame " + std::to_string(frame) +
                         ", stepped " + how + "; use more substeps");
}

// Adds a frame to a skin's distances; `squares` is the running sum of squares.
void measure(const model::Frame& frame, const model::Frame& reference, double unit, std::uint64_t number,
             SteppedSkin& skin, double& squares) {
  const std::vector<float>&a = skin_in(frame), &b = skin_in(reference);
  for (std::size_t i = 0; i < a.size() / 3; ++i) {
    double squared = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double d =
          (double{a[3 * i + c]} - double{b[3 * i + c]}) * unit + frame.origin[c] - reference.origin[c];
      squared += d * d;
    }
    if (!std::isfinite(squared)) throw not_finite(number, "in quality \"" + skin.quality + '"');
    squares += squared;
    if (squared <= skin.largest * skin.largest) continue;
    skin.largest = std::sqrt(squared);
    skin.frame = number;
    skin.vertex = static_cast<std::uint32_t>(i);
  }
}

std::string fixed_text(double x, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, x);
  return text;
}

}  // namespace

Convergence measure_convergence(
    const scene::Scene& scene, const Built& built, const ChosenDevice& device, std::uint64_t frames,
    const std::function<void(const std::string& what, std::uint64_t frame, std::uint64_t frames)>& on_frame) {
  const model::Model& model = built.model;
  if (!model.is_implicit())
    throw UsageError(
        "--converged: with the explicit integrator, more substeps also mean a stiffer body; use an "
        "implicit scene (--set solver.integrator=implicit)");
  Convergence convergence;
  convergence.device = device.label();
  convergence.frames = frames;
  convergence.extent = model::extent(model);
  convergence.skins = skins_of(scene, built);
  convergence.reference = reference_of(convergence.skins);

  // Short substeps allow less viscosity. Without any, the distance is the time step's.
  scene::Scene inviscid = scene;
  inviscid.solver.viscosity = 0.0;
  const std::uint64_t solvers = convergence.skins.size() + 1;
  on_frame("stepping up to frame 0", 0, solvers);
  Stepped reference(inviscid, model, convergence.reference, device);
  std::vector<Stepped> stepped;
  for (const SteppedSkin& skin : convergence.skins) {
    on_frame("stepping up to frame 0", stepped.size() + 1, solvers);
    stepped.emplace_back(inviscid, model, skin.steps, device);
  }
  const model::Read what{.positions = model.surface_count() == 0, .surface = model.surface_count() != 0};
  std::vector<double> squares(stepped.size(), 0.0);
  std::size_t values = 0;
  for (std::uint64_t frame = 1; frame <= frames; ++frame) {
    on_frame("measuring against " + std::to_string(convergence.reference.substeps) + " substeps", frame,
             frames);
    const model::Frame exact = reference.step(frame, what);
    values += skin_in(exact).size() / 3;
    for (const float x : skin_in(exact))
      if (!std::isfinite(x)) throw not_finite(frame, "as the reference");
    for (std::size_t k = 0; k < stepped.size(); ++k)
      measure(stepped[k].step(frame, what), exact, model.unit, frame, convergence.skins[k], squares[k]);
  }
  for (std::size_t k = 0; k < stepped.size(); ++k) {
    convergence.skins[k].rms = std::sqrt(squares[k] / static_cast<double>(std::max<std::size_t>(values, 1)));
    convergence.skins[k].seconds = stepped[k].seconds;
  }
  return convergence;
}

std::string json_text(const Convergence& convergence, const std::string& scene_name) {
  using Json = nlohmann::ordered_json;
  Json object{
      {"scene", scene_name},
      {"device", convergence.device},
      {"frames", convergence.frames},
      {"extent_m", convergence.extent},
      {"reference",
       {{"substeps", convergence.reference.substeps}, {"iterations", convergence.reference.iterations}}},
      {"qualities", Json::array()}};
  for (const SteppedSkin& skin : convergence.skins)
    object["qualities"].push_back({{"quality", skin.quality},
                                   {"is_the_scenes", skin.is_scenes},
                                   {"substeps", skin.steps.substeps},
                                   {"iterations", skin.steps.iterations},
                                   {"rms_m", skin.rms},
                                   {"largest_m", skin.largest},
                                   {"frame", skin.frame},
                                   {"vertex", skin.vertex},
                                   {"solver_seconds", skin.seconds}});
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const Convergence& convergence) {
  std::vector<std::vector<std::string>> rows{
      {"quality", "substeps", "iterations", "RMS", "largest", "in frame", "RMS of the extent", "solver"}};
  for (const SteppedSkin& skin : convergence.skins)
    rows.push_back({skin.quality + (skin.is_scenes ? " *" : ""), std::to_string(skin.steps.substeps),
                    std::to_string(skin.steps.iterations), fixed_text(skin.rms * 1e3, 3) + " mm",
                    fixed_text(skin.largest * 1e3, 2) + " mm", std::to_string(skin.frame),
                    number_text(skin.rms / convergence.extent, 2), fixed_text(skin.seconds, 2) + " s"});
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const std::vector<std::string>& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  std::string text = "distance of the skin from " + std::to_string(convergence.reference.substeps) +
                     " substeps of " + std::to_string(convergence.reference.iterations) +
                     " iterations over " + count_text(convergence.frames) + " frames, on " +
                     convergence.device + "\n";
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string space(widths[c] - row[c].size(), ' ');
      text += "  " + (c == 0 ? row[c] + space : space + row[c]);
    }
    text += "\n";
  }
  return text + "* as the scene is baked, but for its viscosity: this is measured without\n";
}

}  // namespace fascicle::cli
