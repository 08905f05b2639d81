// Skin and fat ("computing sagging faces ... needs additional constraint between skin and fat"): a cheek of
// soft fat on bone, under skin that is attached around it. If the skin slides, the fat sags under it;
// otherwise the skin holds the fat next to it.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/drive/drive_source.h"
#include "host/model/validate.h"
#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

struct Sag {
  double skin = 0.0, fat = 0.0;  // m, downwards: the cheek's middle and the fat below it
  double gap = 0.0;              // distance between the two across the cheek, relative to rest
};

Sag cheek_sag(const std::string& integrator, bool sliding, const std::vector<std::string>& more = {}) {
  scene::SceneOverrides overrides;
  overrides.set = {"scene.end=2", std::string("layers.skin.sliding=") + (sliding ? "true" : "false")};
  if (integrator == "implicit") {
    overrides.set.insert(overrides.set.end(), {"layers.fat.material=fat", "layers.skin.material=skin",
                                               "solver.integrator=implicit", "solver.substeps=6"});
  }
  overrides.set.insert(overrides.set.end(), more.begin(), more.end());
  const scene::Scene scene = scene::load_scene("cheek", overrides);
  build::Report report;
  const model::Model model = build::build_model(scene, report);
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.front().text;
  const build::Steps steps = build::choose_steps(scene, model, report);
  drive::DriveSource drives(scene, model, steps.substeps);
  model::SolverOptions options;
  if (model.is_implicit())
    options = {.integrator = model::Integrator::implicit_step,
               .iterations = steps.iterations,
               .viscosity = scene.solver.viscosity};
  const auto solver = cpu_reference::make_cpu_solver(model, options, 0);
  const auto middle = [&](const std::vector<float>& positions, const char* probe) {
    for (const model::ProbeSet& set : model.probes)
      if (set.name == probe) {
        const std::size_t i = set.vertices.at(0);
        return std::vector<double>{double{positions[3 * i]} * model.unit,
                                   double{positions[3 * i + 1]} * model.unit};
      }
    return std::vector<double>{};
  };
  const std::vector<double> skin = middle(model.rest, "skin"), fat = middle(model.rest, "fat");
  model::Frame frame;
  for (std::uint64_t k = 1; k <= scene::frame_count(scene); ++k) {
    solver->submit(drives.drive(k), {.positions = true});
    frame = solver->collect();
  }
  const std::vector<double> skin_now = middle(frame.positions, "skin"),
                            fat_now = middle(frame.positions, "fat");
  return {skin[1] - skin_now[1], fat[1] - fat_now[1], (skin_now[0] - fat_now[0]) / (skin[0] - fat[0])};
}

// The fat slides by at least a fifth of the gap, and the gap stays: what remains is the fat's weight on the
// ties and the curvature of the fat below.
void expect_fat_slides_under_skin(const std::string& integrator) {
  const Sag sliding = cheek_sag(integrator, true), fast = cheek_sag(integrator, false);
  EXPECT_GT(fast.fat, 0.0);
  EXPECT_LT(std::abs(fast.fat - fast.skin), 0.2 * fast.skin);
  EXPECT_GT(sliding.fat - sliding.skin, 5.0 * std::abs(fast.fat - fast.skin));
  EXPECT_GT(sliding.fat, fast.fat);
  EXPECT_LT(sliding.skin, fast.skin);
  EXPECT_GT(sliding.fat - sliding.skin, 0.2 * 0.015);
  EXPECT_NEAR(sliding.gap, 1.0, 0.02);
}

TEST(SlidingSkin, FatSagsUnderIt) {
  expect_fat_slides_under_skin("explicit");
}

TEST(SlidingSkin, FatSagsUnderItWithTissuesModuli) {
  expect_fat_slides_under_skin("implicit");
}

}  // namespace

}  // namespace fascicle::tests
