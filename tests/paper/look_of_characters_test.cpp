// Characters compared with their skinning: the look score is below its limit for what looks right, and above
// it for failures seen in the past, which are recreated by undoing their fixes. Needs ../shared/assets.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/expected_look.h"
#include "host/bake/look.h"
#include "host/drive/drive_source.h"
#include "tests/paper/built_scene.h"
#include "tests/paper/character_run.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

namespace {

// The worst score of any frame; 1 is the limit. Stops early once a score is above `enough`.
double worst_look(const char* file, const scene::SceneOverrides& overrides,
                  double enough = std::numeric_limits<double>::infinity()) {
  bake::LookBody body;
  std::unique_ptr<bake::Look> look;
  double worst = 0.0;
  run_character(file, overrides,
                [&](const model::Model& model, const rig::Character& character, const model::Frame& frame) {
                  if (!look) {
                    body = bake::look_body(model, &character);
                    look = std::make_unique<bake::Look>(model, body, scene::Scene{}.fps);
                  }
                  worst = std::max(worst, look->of(frame).worst().score);
                  return worst <= enough;
                });
  return worst;
}

// A leap of 960 body lengths per second squared.
TEST(LookOfCharacters, AFrogThatLeapsKeepsItsShape) {
  FASCICLE_NEEDS_ASSET(asset("easy_enemies_Frog.glb"));
  EXPECT_LT(worst_look("easy_enemies_Frog.glb", {.clip = "Attack"}), 1.0);
}

// The control: with linear keys and neither acceleration limit nor viscosity, the belly folds. With the
// viscosity alone the look is 1.43.
TEST(LookOfCharactersSoak, AFrogWithoutLimitsFolds) {
  FASCICLE_NEEDS_ASSET(asset("easy_enemies_Frog.glb"));
  EXPECT_GT(worst_look("easy_enemies_Frog.glb",
                       {.set = {"motion.interpolation=as-authored", "motion.acceleration_limit=1e9",
                                "solver.viscosity=0.0"},
                        .clip = "Attack"},
                       2.0),
            2.0);
}

// What is known before a bake: the estimate, and the look of the trial frames.
struct Foreseen {
  double swing = 0.0, tried = 0.0;
};

Foreseen foreseen(const char* file, const char* clip, double softness) {
  const scene::Scene scene = scene::load_scene(asset(file).string(), {.clip = clip, .softness = softness});
  const auto [model, substeps, options] = built(scene);
  drive::DriveSource drives(scene, model, substeps);
  const bake::LookBody body = bake::look_body_of(scene, model).value();
  const bake::ExpectedLook expected = bake::expected_look(scene, model, body, drives).value();
  const auto solver = cpu_reference::make_cpu_solver(model, options);
  const bake::TriedFrames frames = bake::frames_to_try(scene, expected.frame);
  return {expected.score, bake::try_look(scene, model, body, drives, *solver, frames).worst.score};
}

// A setting that the clip does not bear is reported before the bake, and the default is not. By default the
// frog's skin is at worst 0.87 of the limit from skinning (0.77 with half as many substeps); at softness 2 it
// was 1.39, over the limit in 5 frames.
TEST(LookOfCharactersSoak, AFrogTooSoftForItsLeapIsForeseen) {
  FASCICLE_NEEDS_ASSET(asset("easy_enemies_Frog.glb"));
  const Foreseen by_default = foreseen("easy_enemies_Frog.glb", "Attack", 1.0);
  EXPECT_NEAR(by_default.swing, 0.87, 0.5 * 0.87);
  EXPECT_NEAR(by_default.tried, 0.87, 0.1 * 0.87);
  const Foreseen softer = foreseen("easy_enemies_Frog.glb", "Attack", 2.0);
  EXPECT_GT(softer.swing, 1.0);
  EXPECT_GT(softer.tried, 1.0);
}

// The estimate does not see skin that stretches at the hocks, but the trial does: 1.09, over the limit of 1.
TEST(LookOfCharacters, ABullTooSoftForItsGallopIsForeseen) {
  FASCICLE_NEEDS_ASSET(asset("animals_pack_Bull.glb"));
  const Foreseen softer = foreseen("animals_pack_Bull.glb", "Gallop_Jump", 8.0);
  EXPECT_GE(softer.swing, bake::least_tried_score);
  EXPECT_LT(softer.swing, 1.0);
  EXPECT_GT(softer.tried, 1.05);
}

// Its jaws are shut in the bind pose and open in the clip, and no bone runs through the lower one. When the
// lower jaw was free flesh attached to the upper one, the mouth opened half way and the teeth were strained.
TEST(LookOfCharactersSoak, ADinosaursMouthOpens) {
  FASCICLE_NEEDS_ASSET(asset("dinosaurs_pack_Trex.glb"));
  EXPECT_LT(worst_look("dinosaurs_pack_Trex.glb", {.clip = "Attack"}), 1.0);
  EXPECT_GT(worst_look("dinosaurs_pack_Trex.glb",
                       {.set = {"skeleton.simulated=[\"Neck\"]"}, .clip = "Attack"}, 2.0),
            2.0);
}

// Flesh shakes after a heavy man's landing, less with viscosity, while it swings as far: RMS of the second
// difference (mm a frame^2) of the flesh's motion relative to the skinned, and of that motion itself (mm).
TEST(LookOfCharactersSoak, AHeavyMansLandingShakesLessWithViscosity) {
  FASCICLE_NEEDS_ASSET(asset("mh_fat.glb"));
  struct Motion {
    double swings = 0.0, shakes = 0.0;
  };
  const auto motion_with = [](const char* viscosity) {
    std::vector<std::vector<float>> last;  // of the last three frames, relative to the skinned
    double swings = 0.0, shakes = 0.0;
    std::size_t values = 0;
    run_character("mh_fat.glb", {.set = {std::string("solver.viscosity=") + viscosity}, .clip = "jump"},
                  [&](const model::Model& model, const rig::Character&, const model::Frame& frame) {
                    std::vector<float> now = frame.positions;
                    for (std::size_t c = 0; c < now.size(); ++c) now[c] -= frame.skinned[c];
                    last.push_back(std::move(now));
                    if (last.size() < 3) return true;
                    for (std::size_t c = 0; c < last[0].size(); ++c) {
                      const double shake = model.unit * (double{last[2][c]} - 2.0 * last[1][c] + last[0][c]);
                      shakes += shake * shake;
                      swings += std::pow(model.unit * last[1][c], 2);
                    }
                    values += last[0].size() / 3;
                    last.erase(last.begin());
                    return true;
                  });
    return Motion{1e3 * std::sqrt(swings / double(values)), 1e3 * std::sqrt(shakes / double(values))};
  };
  const Motion without = motion_with("0.0"), with = motion_with("0.002");
  RecordProperty("shakes", std::to_string(without.shakes) + " " + std::to_string(with.shakes));
  RecordProperty("swings", std::to_string(without.swings) + " " + std::to_string(with.swings));
  // Measured: 0.68 of the shaking and 0.96 of the swing. The bounds allow half of that gain and half as much
  // loss again.
  EXPECT_LT(with.shakes, 0.84 * without.shakes);
  EXPECT_NEAR(with.swings, without.swings, 0.06 * without.swings);
}

// Its hocks used to crumple at gaps in the bone layer. The control: flesh thirty times as soft swings off its
// bones.
TEST(LookOfCharactersSoak, ABullsLegsStayOnTheirBones) {
  FASCICLE_NEEDS_ASSET(asset("animals_pack_Bull.glb"));
  EXPECT_LT(worst_look("animals_pack_Bull.glb", {.end = 0.5, .clip = "Gallop_Jump"}), 1.0);
  EXPECT_GT(worst_look("animals_pack_Bull.glb", {.end = 0.5, .clip = "Gallop_Jump", .softness = 30.0}, 1.0),
            1.0);
}

}  // namespace
}  // namespace fascicle::tests
