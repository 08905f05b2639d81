// Substeps and iterations of "auto", and the predicted errors of explicit ones.
#include "host/build/steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/model/implicit.h"
#include "host/scene/scene.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using model::Model;

struct Chosen {
  build::Steps steps;
  std::vector<build::Warning> warnings;  // of the choice of steps only
  Model model;
};

Chosen chosen(const scene::Scene& scene) {
  build::Report report;
  Chosen all;
  all.model = build::build_model(scene, report);
  report.warnings.clear();
  all.steps = build::choose_steps(scene, all.model, report);
  all.warnings = report.warnings;
  return all;
}

scene::Scene auto_scene(double E, double fps = 60.0) {
  scene::Scene scene = elastic_scene(E);
  scene.solver.auto_substeps = true;
  scene.fps = fps;
  return scene;
}

// The largest K H^2 / m of any free vertex.
double stiffness_of_step(const Chosen& c, double fps) {
  double largest = 0.0;
  for (std::uint32_t i = 0; i < c.model.vertex_count; ++i)
    if (!c.model.is_kinematic(i)) largest = std::max(largest, c.model.stiffness[i]);
  const double H = 2.0 / (3.0 * fps * c.steps.substeps);
  return largest * H * H;
}

TEST(Steps, AsManyASecondAtEveryFrameRate) {
  for (const double fps : {2.0, 10.0, 24.0, 30.0, 60.0, 120.0, 1000.0}) {
    scene::Scene scene = auto_scene(1e3, fps);
    for (const auto& [quality, a_second] :
         {std::pair(scene::Quality::draft, 240.0), std::pair(scene::Quality::normal, 480.0),
          std::pair(scene::Quality::final, 1440.0)}) {
      scene.solver.quality = quality;
      const Chosen c = chosen(scene);
      EXPECT_GE(c.steps.substeps * fps, a_second - 1e-6) << fps;
      EXPECT_LT((c.steps.substeps - 1) * fps, a_second) << fps;
      EXPECT_TRUE(c.warnings.empty());
      EXPECT_EQ(c.steps.reason, std::string("quality \"") + name_of(quality) + "\"");
    }
  }
}

// Iterations are the fewest that resolve the stiffness and soon reach their maximum; then substeps grow.
TEST(Steps, IterationsFollowTheStiffness) {
  std::uint32_t before = 0;
  for (const double E : {1e3, 1e4, 1e5, 1e6, 1e7, 1e8}) {
    const Chosen c = chosen(auto_scene(E));
    const double stiffness = stiffness_of_step(c, 60.0);
    const auto resolves = [&](std::uint32_t n) {
      return std::pow(model::resolved_stiffness(n), 2.0) >= stiffness;
    };
    EXPECT_TRUE(resolves(c.steps.iterations) || c.steps.iterations == build::most_auto_iterations) << E;
    EXPECT_FALSE(c.steps.iterations > 2 && resolves(c.steps.iterations - 1)) << E;
    EXPECT_LE(c.steps.iterations, build::most_auto_iterations);
    EXPECT_GE(c.steps.iterations * c.steps.substeps, before) << E;
    EXPECT_LE(c.steps.error.residual, 1.0 / 20.0 + 1e-9) << E;
    EXPECT_TRUE(c.warnings.empty());
    before = c.steps.iterations * c.steps.substeps;
  }
  const Chosen endless = chosen(auto_scene(1e13));
  EXPECT_EQ(endless.steps.substeps, build::most_auto_substeps);
  ASSERT_EQ(endless.warnings.size(), 1u);
  EXPECT_NE(endless.warnings[0].text.find("so stiff"), std::string::npos);
}

TEST(Steps, ALowestModeIsStepped) {
  scene::Scene scene = auto_scene(2e7);
  for (const scene::Quality quality :
       {scene::Quality::draft, scene::Quality::normal, scene::Quality::final}) {
    scene.solver.quality = quality;
    const Chosen c = chosen(scene);
    const double phase = 2.0 * M_PI * c.model.layers[0].frequency / (60.0 * c.steps.substeps);
    ASSERT_GT(phase, 0.0);
    EXPECT_LE(phase, build::longest_phase(quality) * (1.0 + 1e-9));
  }
}

// Only a substep's length of a viscosity acts, and a warning says so of what was stated. Characters do not
// state theirs.
TEST(Steps, MoreViscosityThanASubstepIsToldOf) {
  scene::Scene scene = auto_scene(1e3);
  for (const auto& [viscosity, told] :
       {std::pair(0.0005, 0u), std::pair(1.0 / 480.0, 0u), std::pair(0.004, 1u)}) {
    scene.solver.viscosity = viscosity;
    scene.solver.has_stated_viscosity = true;
    const Chosen c = chosen(scene);
    ASSERT_EQ(c.steps.substeps, 8u);
    ASSERT_EQ(c.warnings.size(), told) << viscosity;
    if (told > 0) {
      EXPECT_EQ(c.warnings[0].text,
                "solver.viscosity: 4 ms is longer than a substep, so only the 2.08 ms of a substep act; use "
                "damping for the rest, or fewer substeps");
    }
  }
  scene.solver.quality = scene::Quality::final;
  scene.solver.viscosity = scene::viscosity_of_character;
  scene.solver.has_stated_viscosity = false;
  EXPECT_TRUE(chosen(scene).warnings.empty());
}

// A viscous step is longer in effect, so a body without a skeleton gets the iterations for that.
TEST(Steps, AViscousStepTakesMoreIterations) {
  scene::Scene scene = auto_scene(3e5);
  const Chosen plain = chosen(scene);
  scene.solver.viscosity = 1.0 / 480.0;
  const Chosen viscous = chosen(scene);
  ASSERT_EQ(viscous.steps.substeps, plain.steps.substeps);
  EXPECT_GT(viscous.steps.iterations, plain.steps.iterations);
  EXPECT_LE(viscous.steps.error.residual, model::resolved_residual);
  // The control: those of the plain step leave more.
  scene.solver.iterations = plain.steps.iterations;
  EXPECT_GT(chosen(scene).steps.error.residual, viscous.steps.error.residual);
}

// A scene's own number of iterations is kept; if it is too low, a warning says so.
TEST(Steps, TooFewIterationsAreToldOf) {
  scene::Scene scene = auto_scene(2e6);
  scene.solver.auto_substeps = false;
  scene.solver.substeps = 4;
  const std::uint32_t needed = chosen(scene).steps.iterations;
  ASSERT_GT(needed, 3u);
  double residual = 0.0;
  for (std::uint32_t n = needed + 1; n >= 2; --n) {
    scene.solver.iterations = n;
    const Chosen c = chosen(scene);
    EXPECT_EQ(c.steps.iterations, n);
    EXPECT_EQ(c.steps.substeps, 4u);
    EXPECT_EQ(c.warnings.size(), c.steps.error.residual > model::resolved_residual ? 1u : 0u) << n;
    EXPECT_FALSE(n >= needed && !c.warnings.empty()) << n;
    EXPECT_FALSE(n <= needed / 2 && c.warnings.empty()) << n;
    EXPECT_GT(c.steps.error.residual, residual);
    residual = c.steps.error.residual;
    for (const build::Warning& warning : c.warnings)
      EXPECT_NE(warning.text.find("\"auto\" uses " + std::to_string(needed)), std::string::npos)
          << warning.text;
  }
}

// A volume term uses up a share of each iteration, so it needs more of them.
TEST(Steps, AVolumeTermTakesMoreIterations) {
  scene::Scene scene = auto_scene(1e6);
  const std::uint32_t without = chosen(scene).steps.iterations;
  scene.layers[0].volume = 1.0;
  const build::Steps with = chosen(scene).steps;
  EXPECT_GT(with.iterations, without);
  EXPECT_LE(with.error.residual, model::resolved_residual);
}

TEST(Steps, TooFewSubstepsAreToldOf) {
  scene::Scene scene = auto_scene(2e7);
  scene.layers[0].frequency = 10.0;
  scene.layers[0].youngs_modulus.reset();
  scene.solver.auto_substeps = false;
  scene.solver.substeps = 1;
  const Chosen few = chosen(scene);
  ASSERT_EQ(few.warnings.size(), 1u);
  EXPECT_NE(few.warnings[0].text.find("10 Hz"), std::string::npos) << few.warnings[0].text;
  scene.solver.substeps = 7;  // 2 pi 10/(0.16 x 60) = 6.5
  EXPECT_TRUE(chosen(scene).warnings.empty());
}

// The predicted error of an oscillation, compared with BDF2 itself on v' = -w^2 x, x' = v.
TEST(Steps, ASwingIsAsMuchSlowerAsForetold) {
  scene::Scene scene = auto_scene(2e7);
  scene.layers[0].frequency = 5.0;
  scene.layers[0].youngs_modulus.reset();
  scene.solver.auto_substeps = false;
  for (const std::uint32_t substeps : {2u, 4u}) {
    scene.solver.substeps = substeps;
    const build::StepError error = chosen(scene).steps.error;
    const double phase = 2.0 * M_PI * 5.0 / (60.0 * substeps);
    // The root near 1 of (3/2 - i p) z^2 - 2 z + 1/2 = 0, for z' = i w z.
    const std::complex<double> a(1.5, -phase), root = (2.0 + std::sqrt(4.0 - 2.0 * a)) / (2.0 * a);
    // Both predictions are leading terms; the next ones are smaller by p^2, at most 0.07.
    EXPECT_NEAR(error.slower, 1.0 - std::arg(root) / phase, 0.15 * error.slower);
    EXPECT_NEAR(error.lost, 1.0 - std::pow(std::abs(root), 2.0 * M_PI / phase), 0.2 * error.lost);
  }
}

// An explicit "auto" keeps h / spacing: half the frame rate or half the spacing takes twice the substeps.
TEST(Steps, ExplicitSubstepsFollowFrameRateAndSpacing) {
  std::size_t warnings = 0;
  const auto substeps = [&warnings](const std::array<std::uint32_t, 3>& vertices, double fps) {
    scene::Scene scene = bar_scene();
    scene.geometry = scene::Bar{.vertices = vertices};
    scene.solver.auto_substeps = true;
    scene.fps = fps;
    const Chosen c = chosen(scene);
    warnings = c.warnings.size();
    return c.steps.substeps;
  };
  const std::uint32_t coarse = substeps({11, 3, 3}, 30.0);
  EXPECT_GT(coarse, 4u);
  // Rounded up; and in a finer bar a smaller part of the edges is on the surface.
  EXPECT_NEAR(substeps({11, 3, 3}, 15.0), 2.0 * coarse, 1.0);
  EXPECT_NEAR(substeps({21, 5, 5}, 30.0), 2.0 * coarse, 1.0);
  EXPECT_EQ(substeps({11, 3, 3}, 1000.0), 4u);
  EXPECT_EQ(warnings, 0u);
  EXPECT_EQ(substeps({11, 3, 3}, 0.5), build::most_explicit_auto_substeps);
  EXPECT_EQ(warnings, 1u);
}

}  // namespace
}  // namespace fascicle::tests
