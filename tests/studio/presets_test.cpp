// Presets keep the look of our characters: every frame stays within the limits that a bake warns of
// (host/bake/look.h): stretch of the skin, inverted triangles, jumps, crossings.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/bake/look.h"
#include "host/scene/scene.h"
#include "host/studio/live_motion.h"
#include "host/studio/scene_keys.h"
#include "host/studio/workshop.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// Results of a run through the clip.
struct SeenRun {
  double worst = 0.0;  // score; 1 is the limit
  std::string cause;
  std::uint64_t frame = 0;
  double lag = 0.0;  // m: the largest RMS distance from skinning in any frame
};

SeenRun run_through(const std::shared_ptr<studio::RunningBody>& body) {
  const auto look_body = bake::look_body_of(body->scene(), body->model());
  EXPECT_TRUE(look_body.has_value());
  bake::Look look(body->model(), *look_body, body->scene().fps);
  SeenRun seen;
  studio::LiveMotion motion(body);
  motion.record([] { return false; },
                [&](const studio::ShownFrame& shown) {
                  seen.lag = std::max(seen.lag, double{shown.numbers.lag});
                  const bake::LookScores scores = look.of(*shown.frame);
                  if (!(scores.worst().score > seen.worst)) return;
                  seen.worst = scores.worst().score;
                  seen.cause = name_of(scores.cause());
                  seen.frame = shown.numbers.frame;
                });
  return seen;
}

void expect_presets_leave_the_look_whole(const std::string& name) {
  const scene::Scene scene = scene::load_scene(name);
  const pipeline::ChosenDevice device =
      pipeline::ChosenDevice::cpu(0, cpu_reference::Simd::automatic, "a test");
  build::BuildOptions options;
  options.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  studio::Workshop workshop({scene.name, scene.source, {}}, options, device);
  const auto body = workshop.make(scene.text, {}, 1, {});
  workshop.warm();
  const SeenRun plain = run_through(body);
  const auto tables = scene::edited_tables(scene.text, scene.source);
  for (const studio::Preset& preset : studio::presets_of(*body, tables)) {
    const bool is_to_be_seen = preset.name == "cartoon" || preset.name == "more-jiggle";
    // The crouching bear, in physical units and with contact, is slow, so it runs only the visible presets.
    if (!preset.why_not.empty() || (!is_to_be_seen && name == "crouch")) continue;
    const std::string text = scene::change_text(scene.text, scene.source, preset.changes).text;
    const SeenRun seen = run_through(workshop.make(text, {}, 2, {}));
    const std::string what = name + ", " + preset.name + ": " + std::to_string(seen.worst) + " by " +
                             seen.cause + " in frame " + std::to_string(seen.frame) + "; lag " +
                             std::to_string(seen.lag) + " m; without " + std::to_string(plain.worst) + ", " +
                             std::to_string(plain.lag);
    testing::Test::RecordProperty(preset.name, what);
    // If the scene itself exceeds a limit, the preset must not be worse.
    EXPECT_LE(seen.worst, std::max(1.0, plain.worst)) << what;
    // These presets must be visible: at least a twentieth more lag. The arm's flesh bulges and hardly lags.
    if (is_to_be_seen && name != "arm") {
      EXPECT_GT(seen.lag, 1.05 * plain.lag) << what;
    }
  }
}

TEST(Presets, LeaveTheJumpingBearsLookWhole) {
  expect_presets_leave_the_look_whole("jump");
}

TEST(Presets, LeaveTheArmsLookWhole) {
  expect_presets_leave_the_look_whole("arm");
}

TEST(PresetsSoak, LeaveTheCrouchingBearsLookWhole) {
  expect_presets_leave_the_look_whole("crouch");
}

}  // namespace
}  // namespace fascicle::tests
