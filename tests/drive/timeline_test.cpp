// The clip on a bake's time line: jumps, ends, loops and the origin of frames.
#include "host/drive/timeline.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/build/build.h"
#include "host/build/steps.h"
#include "host/drive/drive_source.h"
#include "host/drive/lead_in.h"
#include "host/scene/scene_file.h"
#include "tests/drive/bending_bar.h"
#include "tests/drive/character_walk.h"

namespace fascicle::tests::timeline_test {

namespace {

using Eigen::Vector3d;

std::vector<std::uint64_t> frames_with_cuts(const BendingBar& bar, std::uint64_t frames) {
  drive::DriveSource drives(bar.scene, bar.model);
  std::vector<std::uint64_t> found;
  for (std::uint64_t k = 1; k <= frames; ++k)
    if (!drives.drive(k).cuts.empty()) found.push_back(k);
  return found;
}

// Flies at two of its lengths per frame: that is a speed, and no jump. A jump of a hundred lengths is one.
TEST(Jump, StandsOutFromTheMotionAroundIt) {
  BendingBar bar = bending_bar(1.0);
  bar.scene.motion.acceleration_limit = 1e9;  // so that only jumps make cuts
  const double speed = 2.0 * bar_height * bar.scene.fps;
  bar.character().clips.push_back({"fly", 1.0, {root_channel({{0.0, {0, 0, 0}}, {1.0, {speed, 0, 0}}})}});
  EXPECT_TRUE(frames_with_cuts(bar, 60).empty());
  const Walked flown = run(bar, 60);
  for (std::size_t k = 0; k <= 60; ++k)
    // Floats of positions that move by a tenth of a metre per substep.
    ASSERT_LT(furthest(flown.positions[k], flown.skinned[k]), 1e-4 * bar_height) << k;

  const double half = 0.5 * speed, jump = 100.0 * bar_height;
  bar.character().clips[0].channels = {root_channel({{0.0, {0, 0, 0}},
                                                     {0.5, {half, 0, 0}},
                                                     {0.5 + 1.0 / 60.0, {half + jump, 0, 0}},
                                                     {1.0, {half + jump + half, 0, 0}}})};
  // So near to it, substeps that are merely quick may be its ends.
  EXPECT_EQ(frames_with_cuts(bar, 60), (std::vector<std::uint64_t>{30, 31, 32}));
  const auto jumps = drive::DriveSource(bar.scene, bar.model).jumps();
  ASSERT_EQ(jumps.size(), 1u);
  EXPECT_EQ(jumps[0].frame, 31u);
  EXPECT_NEAR(jumps[0].distance, jump, 1e-9);
  bar.scene.motion.cuts = {0.51};
  EXPECT_TRUE(drive::DriveSource(bar.scene, bar.model).jumps().empty());
  bar.scene.motion.cuts = {};

  // If the scene says what a jump is, speed alone decides.
  bar.character().clips[0].channels = {root_channel({{0.0, {0, 0, 0}}, {1.0, {speed, 0, 0}}})};
  bar.scene.motion.cut_distance = bar_height;
  EXPECT_EQ(frames_with_cuts(bar, 60).size(), 60u);
}

// A hold begins at the clip's last whole frame, or at its end if that comes first: one last substep to the
// end would move the body by up to half a frame at once.
TEST(Hold, BeginsWithoutAStep) {
  for (const double end : {0.9799, 1.0199, 1.0}) {
    BendingBar bar = bending_bar(end);
    bar.scene.fps = 24.0;
    bar.scene.motion.hold = 0.5;
    bar.character().clips.push_back({"go", 2.0, {root_channel({{0.0, {0, 0, 0}}, {2.0, {4, 0, 0}}})}});
    const double extents[] = {bar_height};
    drive::Timeline timeline(bar.scene, bar.character(), extents, 8);
    const std::uint64_t last = scene::cycle_frames(bar.scene) * 8;
    const double substep = 1.0 / (24.0 * 8.0);
    for (std::uint64_t count = 1; count <= last + 8; ++count) {
      const double step = timeline.clip_time(count) - timeline.clip_time(count - 1);
      ASSERT_GE(step, 0.0) << end << " " << count;
      ASSERT_LT(step, 1.0001 * substep) << end << " " << count;
    }
    EXPECT_LE(timeline.clip_time(last + 1), end);
    EXPECT_NEAR(timeline.clip_time(last + 1), end, 0.5 / 24.0);
    EXPECT_EQ(timeline.clip_time(last), timeline.clip_time(last + 8));
  }
}

// The second joint turns in its place, so the joints' origins return and the pose does not.
TEST(Loop, ATurnInPlaceThatDoesNotReturnIsCut) {
  BendingBar bar = bending_bar(1.0);
  bar.scene.motion.acceleration_limit = 1e9;
  bar.scene.motion.loop = 2;
  bar.character().clips.push_back({"turn", 1.0, {turn_channel(1, {0.0, 1.0}, {0.0, 1.0})}});
  EXPECT_EQ(frames_with_cuts(bar, 120), std::vector<std::uint64_t>{61});
  bar.character().clips[0].channels = {turn_channel(1, {0.0, 0.5, 1.0}, {0.0, 1.0, 0.0})};
  EXPECT_TRUE(frames_with_cuts(bar, 120).empty());
}

// A root that lies between two whole units, and ends a hundredth of a millimetre from where it began: the
// frame's origin is then another one, and the flesh must not be left a unit away from its bones.
TEST(Seamless, TheOriginMayRoundOtherwiseAtTheEnd) {
  BendingBar bar = bending_bar(1.0);
  bar.character().clips.push_back(
      {"drift", 1.0, {root_channel({{0.0, {0, 0.4, 0}}, {0.5, {0.05, 0.4, 0}}, {1.0, {0, 0.4 - 1e-5, 0}}})}});
  bar.scene.motion.seamless = true;
  drive::DriveSource drives(bar.scene, bar.model);
  ASSERT_NE(drives.drive(60).origin[1], drives.initial_state().origin[1]);
  const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
  const model::State begun = drives.begun_again([&] {
    solver->load(drives.initial_state());
    for (std::uint64_t k = 1; k <= 60; ++k) {
      solver->submit(drives.drive(k), {});
      (void)solver->collect();
    }
    return solver->save();
  }());
  EXPECT_EQ(begun.origin, drives.initial_state().origin);
  double lag = 0.0;
  for (std::size_t i = 0; i < begun.positions.size(); ++i)
    lag = std::max(lag, std::abs(double{begun.positions[i]} - double{begun.skinned[i]}));
  EXPECT_LT(lag, 0.1 * bar_height);
  EXPECT_GT(lag, 0.0);
}

class PropsNearby : public testing::Test {
 protected:
  PropsNearby() { std::filesystem::create_directories(folder_); }
  ~PropsNearby() override { std::filesystem::remove_all(folder_); }

  // A box of 0.1 m whose centre is at (x, 5, 0) at each time.
  void write_ball(const std::vector<float>& times, const std::vector<float>& x,
                  const std::string& name = "ball.glb") const {
    GltfBuilder ball = boxes({{{-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}}});
    std::size_t node = 0;
    while (!ball.document["nodes"][node].contains("mesh")) ++node;
    std::vector<float> places;
    for (const float at : x) places.insert(places.end(), {at, 5.0f, 0.0f});
    const std::size_t input = ball.add("SCALAR", times), output = ball.add("VEC3", places);
    ball.document["animations"] = {
        {{"name", "fly"},
         {"samplers", {{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}}}}}};
    const std::vector<unsigned char> bytes = ball.glb();
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  scene::Scene scene_of(const std::string& text) const {
    return scene::parse_scene({"test", "test.toml", text, folder_}, {});
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("fascicle_nearby_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  const std::string prop_ = "[character.b]\nfile = \"ball.glb\"\nrigid = true\nresolution = 0.05\n";
};

// Neither a ball that flies past, a hundred of its lengths in a second, nor one that is moved elsewhere at
// once changes how an arm's flesh moves.
TEST_F(PropsNearby, DoNotCarryFlesh) {
  constexpr std::uint64_t frames = 24;
  write_ball({0.0f, 1.0f}, {-10.0f, 10.0f});
  // A file with a clip would have the keys of all clips smoothed.
  const std::string one = arm("character.a", "start = -0.5\n"),
                    end = "[motion]\npreroll = 0.0\ninterpolation = \"as-authored\"\n" + flesh_on_bones;
  const Walk alone =
      walk(one + "[character.b]\nmade = \"arm\"\nat = [9, 0, 0]\nrigid = true\n" + end, frames);
  const Walk past = walk(one + prop_ + end, frames, folder_);
  write_ball({0.0f, 0.2f, 0.21f, 1.0f}, {-10.0f, -10.0f, 30.0f, 30.0f});
  const Walk moved = walk(one + prop_ + end, frames, folder_);
  drive::DriveSource drives(moved.scene, moved.model), flying(past.scene, past.model);
  for (std::uint64_t k = 1; k <= frames; ++k) {
    EXPECT_TRUE(drives.drive(k).cuts.empty()) << k;
    EXPECT_TRUE(flying.drive(k).cuts.empty()) << k;
  }
  const std::size_t vertices = std::get<rig::Character>(alone.scene.geometry).parts.at(0).vertex_count;
  double swung = 0.0;
  for (std::uint64_t k = 0; k <= frames; ++k)
    for (std::size_t i = 0; i < vertices; ++i) {
      // As in Characters.FarApartMoveAsTheyDoAlone.
      constexpr double rounding = 100.0 * 2.4e-7;
      ASSERT_LT((past.surface[k][i] - alone.surface[k][i]).norm(), rounding) << k;
      ASSERT_LT((moved.surface[k][i] - alone.surface[k][i]).norm(), rounding) << k;
      swung = std::max(swung, (alone.surface[k][i] - alone.surface[0][i]).norm());
    }
  EXPECT_GT(swung, 0.01);
}

TEST_F(PropsNearby, LeaveTheOriginOfFramesAtTheFlesh) {
  write_ball({0.0f, 1.0f}, {20000.0f, 20000.0f});
  write_box(folder_ / "box.obj", {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  const std::string end = "[motion]\npreroll = 0.0\n" + flesh_on_bones,
                    bearer = "[character.c]\nfile = \"box.obj\"\nrigid = true\nresolution = 0.05\n";
  for (const std::string& flesh : {arm("character.a"), bearer + arm("character.a", "joint = \"c\"\n")}) {
    const Walk far = walk(flesh + prop_ + end, 1, folder_);
    drive::DriveSource drives(far.scene, far.model);
    EXPECT_LT(std::abs(drives.drive(1).origin[0]), 2.0) << flesh;
  }
}

// Two bodies that stand still and are moved elsewhere at once, one a frame after the other. Each is carried
// over its own jump, and the other's does not matter.
TEST_F(PropsNearby, AreCarriedEachByItself) {
  constexpr std::uint64_t frames = 24;
  const auto jump_at = [](double frame) {
    return std::vector<float>{0.0f, static_cast<float>((frame - 1.0) / 60.0),
                              static_cast<float>(frame / 60.0), 1.0f};
  };
  write_ball(jump_at(13.0), {0.0f, 0.0f, 30.0f, 30.0f}, "a.glb");
  write_ball(jump_at(12.0), {5.0f, 5.0f, 50.0f, 50.0f}, "b.glb");
  const Walk both = walk(
      "[character.a]\nfile = \"a.glb\"\nresolution = 0.02\n"
      "[character.b]\nfile = \"b.glb\"\nresolution = 0.02\n"
      "[motion]\npreroll = 0.0\ninterpolation = \"as-authored\"\n"
      "[layers.flesh]\nalpha = 0.5\ndamping = 6.0\n"
      "[layers.bone]\nkinematic = true\nwhere = { bone_distance = { maximum = 0.02 } }\n"
      "[solver]\nsubsteps = 8\n",
      frames, folder_);
  const auto& parts = std::get<rig::Character>(both.scene.geometry).parts;
  const double ways[] = {30.0, 45.0};
  for (std::size_t part = 0; part < 2; ++part)
    for (std::size_t i = parts.at(part).first_vertex; i < parts[part].first_vertex + parts[part].vertex_count;
         ++i)
      // Floats of positions some tens of metres from the origin, and the rounding of what a jump carries.
      EXPECT_LT((both.surface[frames][i] - both.surface[0][i] - Vector3d(ways[part], 0, 0)).norm(), 1e-3)
          << part << " " << i;
}

// The default layers go by the size of the flesh.
TEST_F(PropsNearby, DoNotMakeFleshStiffer) {
  write_box(folder_ / "floor.obj", {-10, -1, -10}, {10, 0, 10});
  const std::string floor = "[character.b]\nfile = \"floor.obj\"\nresolution = 1.0\n";
  const scene::Scene alone = scene_of(arm("character.a")),
                     beside = scene_of(arm("character.a") + floor + "rigid = true\n");
  ASSERT_EQ(alone.layers.size(), beside.layers.size());
  for (std::size_t k = 0; k < alone.layers.size(); ++k)
    EXPECT_EQ(alone.layers[k].youngs_modulus, beside.layers[k].youngs_modulus) << alone.layers[k].name;
}

// What alpha means depends on the substeps, which go by the edges and size of the flesh.
TEST_F(PropsNearby, DoNotChangeTheSubsteps) {
  const std::string layers =
      "[solver]\nintegrator = \"explicit\"\nsubsteps = \"auto\"\n"
      "[layers.flesh]\nalpha = 0.5\n"
      "[layers.bone]\nkinematic = true\nwhere = { bone_distance = { maximum = 0.03 } }\n";
  const auto substeps = [&](const std::string& more) {
    const scene::Scene scene = scene_of(arm("character.a") + more + layers);
    build::Report report;
    build::BuildOptions options;
    options.mesher = FASCICLE_MESHER;
    const model::Model model = build::build_model(scene, report, options);
    return build::choose_steps(scene, model, report).substeps;
  };
  write_box(folder_ / "floor.obj", {-10, -3, -10}, {10, -2, 10});
  EXPECT_EQ(substeps("[character.b]\nfile = \"floor.obj\"\nrigid = true\nresolution = 1.0\n"), substeps(""));
}

// How well a loop closes is a share of the body's size, not of a bead's beside it.
TEST_F(PropsNearby, DoNotTightenTheToleranceOfALoop) {
  write_box(folder_ / "bead.obj", {0, 2, 0}, {0.001, 2.001, 0.001});
  const auto cycles = [&](const std::string& more) {
    const Walk walked =
        walk(arm("character.a") + more + "[motion]\nseamless = true\n" + flesh_on_bones, 0, folder_);
    drive::DriveSource drives(walked.scene, walked.model);
    const auto solver = cpu_reference::make_cpu_solver(walked.model, {}, 2);
    return drive::lead_in(walked.scene, walked.model, drives, *solver).summary.cycles;
  };
  EXPECT_EQ(cycles("[character.b]\nfile = \"bead.obj\"\nrigid = true\nresolution = 0.001\n"),
            cycles("[character.b]\nmade = \"arm\"\nat = [9, 0, 0]\nrigid = true\n"));
}

}  // namespace

}  // namespace fascicle::tests::timeline_test
