// Handles: frames before and after the range, which keeps its times and numbers.
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/bake/export.h"
#include "host/drive/timeline.h"
#include "host/scene/scene_file.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

scene::Scene arm_scene(const std::string& motion, const scene::SceneOverrides& overrides = {}) {
  return scene::parse_scene(
      {"test",
       "test.toml",
       "[scene]\nfps = 24\nstart = 0.25\nend = 0.75\n[character]\nmade = \"arm\"\n" + motion,
       {}},
      overrides);
}

drive::Timeline timeline_of(const scene::Scene& scene) {
  const double extents[] = {1.0};
  return drive::Timeline(scene, std::get<rig::Character>(scene.geometry), extents, scene.solver.substeps);
}

TEST(Handles, PosesOfTheRangeAreThoseWithout) {
  constexpr std::uint64_t handles = 9;
  for (const char* motion : {"", "[motion]\nhold = 0.5\n"}) {
    const scene::Scene plain = arm_scene(motion), with = arm_scene(motion, {.handles = handles});
    const std::uint64_t frames = scene::frame_count(plain);
    ASSERT_EQ(scene::frame_count(with), frames + 2 * handles) << motion;
    drive::Timeline before = timeline_of(plain), after = timeline_of(with);
    ASSERT_EQ(plain.solver.substeps, with.solver.substeps);
    const std::uint64_t substeps = plain.solver.substeps;
    for (std::uint64_t k = 0; k <= frames; ++k) {
      // The start is a sum of two times: rounding of doubles near 1.
      EXPECT_NEAR(after.clip_time((k + handles) * substeps), before.clip_time(k * substeps), 1e-15);
      const drive::Pose &a = before.pose(k * substeps), &b = after.pose((k + handles) * substeps);
      for (std::size_t j = 0; j < a.size(); ++j)
        EXPECT_LT((a[j] - b[j]).norm(), 1e-13) << motion << "frame " << k << ", joint " << j;
    }
    // Of the nine frames before the start, six are in the clip and three before it begins.
    EXPECT_NEAR(after.clip_time(0), 0.25 - 9.0 / 24.0, 1e-15);
    const drive::Pose first = after.pose(0), third = after.pose(3 * substeps),
                      later = after.pose((handles + 6) * substeps);
    double still = 0.0, moved = 0.0;
    for (std::size_t j = 0; j < first.size(); ++j) {
      still += (third[j] - first[j]).norm();
      moved += (later[j] - first[j]).norm();
    }
    EXPECT_EQ(still, 0.0);
    EXPECT_GT(moved, 1e-6);
  }
}

TEST(Handles, AHeldPoseIsHeldLonger) {
  const scene::Scene scene = arm_scene("[motion]\nhold = 0.5\nhandles = 12\n");
  EXPECT_EQ(scene.end, 0.75);
  EXPECT_EQ(scene.motion.hold, 1.0);
  EXPECT_EQ(scene.start, -0.25);
}

TEST(Handles, DoNotStandBesideCycles) {
  for (const std::string other : {"loop = 2", "seamless = true"}) {
    try {
      arm_scene("[motion]\n" + other + "\nhandles = 2\n");
      ADD_FAILURE() << other;
    } catch (const scene::SceneError& error) {
      EXPECT_NE(std::string(error.what()).find("motion.handles: conflicts with seamless and loop"),
                std::string::npos)
          << error.what();
    }
  }
}

TEST(Handles, AreNumberedAroundTheRange) {
  const TemporaryFolder folder;
  scene::Scene scene = short_scene(8);
  scene.motion.handles = 2;
  bake::BakeOptions options = options_for(folder / "out");
  options.formats = {"obj"};
  options.first_number = 1001;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake::bake(scene, model, solver, options);
  const auto first_and_last = [&](const char* out, int first, int last) {
    const auto file = [&](int number) {
      const std::string digits = std::to_string(number);
      return folder /
             (std::string(out) + "/obj/frame_" + std::string(6 - digits.size(), '0') + digits + ".obj");
    };
    EXPECT_TRUE(fs::exists(file(first)));
    EXPECT_FALSE(fs::exists(file(first - 1)));
    EXPECT_TRUE(fs::exists(file(last)));
    EXPECT_FALSE(fs::exists(file(last + 1)));
  };
  first_and_last("out", 999, 1007);
  const nlohmann::json output = nlohmann::json::parse(read_text(folder / "out/manifest.json"))["output"];
  EXPECT_EQ(output["first_frame"], 999);
  EXPECT_EQ(output["handles"], 2);
  EXPECT_EQ(output["range"], (std::vector<int>{1001, 1005}));
  bake::export_bake({.bake = folder / "out", .folder = folder / "same", .formats = {"obj"}});
  first_and_last("same", 999, 1007);
  bake::export_bake(
      {.bake = folder / "out", .folder = folder / "other", .formats = {"obj"}, .first_number = 101});
  first_and_last("other", 99, 107);
  EXPECT_THROW(bake::export_bake(
                   {.bake = folder / "out", .folder = folder / "bad", .formats = {"obj"}, .first_number = 1}),
               bake::BakeError);
}

}  // namespace
}  // namespace fascicle::tests
