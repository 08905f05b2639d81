// Whether a bake leaves contact out where it would tear the skin. An arm of the bear is pushed through its
// chest, which no bear can do, or against it.
#include "host/bake/torn_contact.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/bake.h"
#include "host/bake/checkpoint.h"
#include "host/bake/look_report.h"
#include "host/base/helper_program.h"
#include "host/drive/drive_source.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/build_scene.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

constexpr double end = 0.4;  // s

// The left arm moves towards the right by `way`, m, in 0.3 s, and stays there; or it is there from the start,
// and half a second of preroll brings it there.
enum class Begins { apart, there };
scene::Scene bear_with_arm_moved(double way, bool unless_torn = true, Begins begins = Begins::apart) {
  scene::SceneOverrides overrides;
  overrides.set = {"character.resolution=0.1",
                   "motion.preroll=0.0",
                   "motion.settle=0.0",
                   "scene.start=0.0",
                   "scene.end=" + std::to_string(end),
                   "scene.fps=60.0",
                   "contact.self=true",
                   std::string("contact.unless_torn=") + (unless_torn ? "true" : "false")};
  scene::Scene scene = scene::load_scene("crouch", overrides);
  auto& bear = std::get<rig::Character>(scene.geometry);
  const auto arm = std::find_if(bear.skeleton.begin(), bear.skeleton.end(),
                                [](const rig::Joint& joint) { return joint.name == "upper_arm_L"; });
  if (arm == bear.skeleton.end()) throw std::runtime_error("the bear has no such joint");
  rig::Channel moved;
  moved.joint = static_cast<std::uint32_t>(arm - bear.skeleton.begin());
  moved.path = rig::ChannelPath::translation;
  for (const double t : {0.0, 0.3, end}) {
    moved.times.push_back(t);
    const double x = arm->rest_local(0, 3) - way * (begins == Begins::there ? 1.0 : std::min(t / 0.3, 1.0));
    moved.values.insert(moved.values.end(), {x, arm->rest_local(1, 3), arm->rest_local(2, 3)});
  }
  bear.clips = {{"push", end, {moved}}};
  scene.clip = "push";
  return scene;
}

pipeline::BakeRequest request_in(const fs::path& folder) {
  pipeline::BakeRequest request;
  request.output.folder = folder;
  request.build.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  request.devices = pipeline::parse_device_order("cpu");
  return request;
}

// The model, whose contact is on, and what its clip does.
struct Driven {
  explicit Driven(double way) : scene(bear_with_arm_moved(way)) {
    build::BuildOptions options = request_in({}).build;
    built = pipeline::build_scene(scene, options, {});
    drive::DriveSource drives(scene, built.model, built.steps.substeps);
    flesh = bake::driven_flesh(scene, built.model, drives);
  }
  scene::Scene scene;
  pipeline::Built built;
  std::vector<bake::DrivenFlesh> flesh;
};

TEST(TornContact, TheDeepestPoseIsFound) {
  // The arm is about as wide as the limit is deep, and touches the chest after a few centimetres.
  EXPECT_TRUE(Driven(0.05).flesh.empty());
  const Driven deep(0.5);
  ASSERT_EQ(deep.flesh.size(), 1u);
  EXPECT_GT(deep.flesh[0].depth, bake::deepest_for_contact * model::extent(deep.built.model));
  EXPECT_LT(deep.flesh[0].depth, 0.5);
  // The arm stops in frame 18, one of the poses that are looked at.
  EXPECT_EQ(deep.flesh[0].frame, 18u);
  // By then it has moved at 1.7 m/s; the trial begins before it is in.
  EXPECT_LE(deep.flesh[0].first, 6u);
  const bake::TriedFrames frames = bake::frames_to_try(deep.scene, deep.flesh[0]);
  EXPECT_LE(frames.first, deep.flesh[0].first);
  EXPECT_GE(frames.last, 18u);
  EXPECT_LE(frames.last, scene::cycle_frames(deep.scene));
}

TEST(TornContact, IsLeftOutOnlyIfThatIsBetter) {
  const auto looks = [](double score) {
    bake::TriedLook tried;
    tried.worst.score = score;
    return tried;
  };
  EXPECT_TRUE(bake::tears(looks(1.2), looks(0.9)));
  EXPECT_FALSE(bake::tears(looks(0.9), looks(0.2))) << "nothing is wrong with contact";
  EXPECT_TRUE(bake::tears(looks(5.0), looks(2.0)));
  EXPECT_FALSE(bake::tears(looks(5.0), looks(3.0))) << "something else is wrong too";
  bake::TriedLook burst = looks(0.0);
  burst.is_finite = false;
  EXPECT_TRUE(bake::tears(burst, looks(0.5)));
  EXPECT_FALSE(bake::tears(looks(5.0), burst)) << "a burst body has no look";
}

std::vector<std::string> warnings_of(scene::Scene scene, const pipeline::BakeRequest& request,
                                     bool& keeps_contact) {
  const auto prepared = pipeline::prepare_bake(std::move(scene), request, {});
  keeps_contact = prepared->built.model.has_contact();
  return prepared->warnings;
}

bool is_said(const std::vector<std::string>& warnings) {
  return std::any_of(warnings.begin(), warnings.end(), [](const std::string& text) {
    return text.find("contact of the body with itself is left out") != std::string::npos;
  });
}

// Pressed against the chest, deeper than the limit, the arm's contact looks right, so it stays. So it does if
// the clip begins like that: the preroll has parted the flesh.
TEST(TornContact, StaysWhereItLooksRight) {
  constexpr double way = 0.25;
  ASSERT_FALSE(Driven(way).flesh.empty()) << "it is not even tried";
  const base::TemporaryFolder folder;
  for (const Begins begins : {Begins::apart, Begins::there}) {
    bool keeps_contact = false;
    EXPECT_FALSE(is_said(warnings_of(bear_with_arm_moved(way, true, begins),
                                     request_in(folder.path() / "bake"), keeps_contact)));
    EXPECT_TRUE(keeps_contact);
  }
}

TEST(TornContact, StaysWhereTheSceneSaysSo) {
  const base::TemporaryFolder folder;
  bool keeps_contact = false;
  EXPECT_FALSE(is_said(
      warnings_of(bear_with_arm_moved(0.5, false), request_in(folder.path() / "bake"), keeps_contact)));
  EXPECT_TRUE(keeps_contact);
}

// A bake that is interrupted and resumed has one kind of contact throughout, and the hash of one that was
// not.
TEST(TornContact, ABakeLeavesItOutAndSaysSo) {
  const base::TemporaryFolder folder;
  pipeline::BakeRequest request = request_in(folder.path() / "bake");
  std::atomic<bool> interrupted = false;
  request.interrupted = &interrupted;
  int frames_before = 0;
  request.on_lead_in = [&] { ++frames_before; };
  request.on_frame = [&](std::uint64_t frame, std::uint64_t) { interrupted = frame == 3; };
  {
    const auto prepared = pipeline::prepare_bake(bear_with_arm_moved(0.5), request, {});
    EXPECT_FALSE(prepared->built.model.has_contact());
    EXPECT_TRUE(is_said(prepared->warnings));
    EXPECT_NE(prepared->contact_left_out.find("_L\""), std::string::npos) << "no joint of the arm is named";
    ASSERT_TRUE(prepared->tried.has_value());
    EXPECT_LE(prepared->tried->last, 18u);
    EXPECT_GT(frames_before, 0) << "a trial can be watched, and cancelled";
    EXPECT_TRUE(pipeline::run_bake(*prepared, request, {}).interrupted);
  }
  const auto checkpoint = bake::read_checkpoint(request.output.folder / bake::checkpoint_name);
  ASSERT_TRUE(checkpoint.has_value());
  EXPECT_NE(bake::contact_left_out(checkpoint->identity).value_or(""), "");

  interrupted = false;
  frames_before = 0;
  request.output.resume = true;
  const auto prepared = pipeline::prepare_bake(bear_with_arm_moved(0.5), request, {});
  EXPECT_EQ(frames_before, 0) << "it was tried again";
  EXPECT_FALSE(prepared->built.model.has_contact());
  EXPECT_TRUE(is_said(prepared->warnings)) << "the manifest is written anew";
  request.on_frame = {};
  const bake::BakeResult resumed = pipeline::run_bake(*prepared, request, {});
  EXPECT_FALSE(resumed.interrupted);

  pipeline::BakeRequest other = request_in(folder.path() / "other");
  const auto undisturbed = pipeline::prepare_bake(bear_with_arm_moved(0.5), other, {});
  EXPECT_EQ(undisturbed->warnings, prepared->warnings);
  EXPECT_EQ(pipeline::run_bake(*undisturbed, other, {}).last_position_hash, resumed.last_position_hash);
}

// What an interrupted trial would have found is unknown: the bake keeps nothing that relies on it.
TEST(TornContact, AnInterruptedTrialDecidesNothing) {
  const base::TemporaryFolder folder;
  pipeline::BakeRequest request = request_in(folder.path() / "bake");
  std::atomic<bool> interrupted = true;
  request.interrupted = &interrupted;
  const auto prepared = pipeline::prepare_bake(bear_with_arm_moved(0.5), request, {});
  EXPECT_TRUE(prepared->is_undecided);
  EXPECT_TRUE(pipeline::run_bake(*prepared, request, {}).interrupted);
  EXPECT_FALSE(fs::exists(request.output.folder));
}

}  // namespace
}  // namespace fascicle::tests
