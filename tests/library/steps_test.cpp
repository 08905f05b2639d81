// Level 2: a body stepped by its clip and by external poses.
#include <algorithm>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "include/fascicle/fascicle.hpp"
#include "tests/library/shell.h"

namespace fascicle_tests {
namespace {

// A generated arm of few vertices that curls; one substep per frame, so that the clip's poses determine
// everything.
const fascicle::scene& arm() {
  static const fascicle::scene scene("arm", {.set = {"solver.substeps=1", "motion.preroll=0.0"}, .end = 1.0});
  return scene;
}

const fascicle::model& arm_model() {
  static const fascicle::model model(arm(), {.cache = ""});
  return model;
}

float distance(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  float most = 0.0F;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(Steps, ByTheClipTheyAreTheBakes) {
  const Folder folder;
  const fascicle::bake_result bake =
      fascicle::bake(arm(), {.folder = folder / "out", .device = "cpu", .cache = ""});
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  EXPECT_EQ(solver.device_text(), fascicle::device("cpu").text());
  EXPECT_FALSE(fascicle::solver(arm_model()).device_text().empty()) << "which device \"auto\" chose";
  solver.start_clip();
  EXPECT_EQ(solver.frame().index, 0u);
  for (std::uint64_t frame = 1; frame <= arm().frame_count(); ++frame) solver.step_clip();
  EXPECT_EQ(solver.frame().index, arm().frame_count());
  EXPECT_EQ(solver.position_hash(), bake.position_hash());
}

// The clip's poses, passed one by one, move the body as the clip does. The clip begins at rest, so both start
// alike.
TEST(Steps, TheClipsOwnPosesMoveTheBodyAsTheClipDoes) {
  fascicle::solver by_clip(arm_model(), fascicle::device("cpu")),
      by_poses(arm_model(), fascicle::device("cpu"));
  by_clip.start_clip();
  by_poses.start_pose(by_poses.clip_pose(0));
  const std::vector<float> before = by_poses.positions();
  for (std::uint64_t frame = 1; frame <= arm().frame_count(); ++frame) {
    by_clip.step_clip();
    by_poses.step_pose(by_poses.clip_pose(frame));
  }
  const float moved = distance(before, by_clip.positions());
  EXPECT_GT(moved, 1e-3F) << "the clip does nothing";
  // Only the initial velocity differs: the clip's first frame moves slightly.
  EXPECT_LT(distance(by_clip.positions(), by_poses.positions()), 0.02F * moved);
}

TEST(Steps, APoseThatJumpsCarriesTheFleshAlong) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  const std::vector<double> pose = solver.clip_pose(0);
  std::vector<double> far = pose;
  for (std::size_t j = 0; 16 * j < far.size(); ++j) far[16 * j + 3] += 8.0;
  const auto speed = [](const fascicle_frame& frame) {
    float most = 0.0F;
    for (std::size_t k = 0; k < 3 * frame.vertex_count; ++k)
      most = std::max(most, std::abs(frame.velocities[k]));
    return static_cast<double>(most) * frame.unit;
  };
  solver.start_pose(pose);
  const std::vector<float> before = solver.positions();
  solver.step_pose(far, std::nan(""), true);
  std::vector<float> after = solver.positions();
  for (std::size_t k = 0; k < after.size(); k += 3) after[k] -= 8.0F;
  EXPECT_LT(distance(before, after), 1e-3F);
  EXPECT_LT(speed(solver.frame()), 0.1);
  // The control: without the flag the flesh is thrown, by 8 m in a frame.
  solver.start_pose(pose);
  solver.step_pose(far);
  EXPECT_GT(speed(solver.frame()), 10.0);
}

TEST(Steps, PosesForEachSubstepAndForTheFrameAreBothTaken) {
  const fascicle::scene scene("arm", {.set = {"solver.substeps=4", "motion.preroll=0.0"}, .end = 0.1});
  const fascicle::model model(scene, {.cache = ""});
  ASSERT_EQ(model.substeps(), 4u);
  fascicle::solver one(model, fascicle::device("cpu")), four(model, fascicle::device("cpu"));
  const std::vector<double> from = one.clip_pose(0);
  std::vector<double> to = from, all;
  for (std::size_t j = 0; 16 * j < to.size(); ++j) to[16 * j + 7] += 0.25;
  for (int s = 1; s <= 4; ++s)
    for (std::size_t k = 0; k < to.size(); ++k) all.push_back((1.0 - s / 4.0) * from[k] + s / 4.0 * to[k]);
  one.start_pose(from);
  four.start_pose(from);
  one.step_pose(to);
  four.step_pose(all);
  EXPECT_EQ(one.position_hash(), four.position_hash()) << "poses are interpolated linearly between frames";
  all.resize(2 * to.size());
  EXPECT_THROW(four.step_pose(all), fascicle::error);
}

TEST(Steps, WhatWasSavedGoesOnWithTheSameBits) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu")),
      other(arm_model(), fascicle::device("cpu:scalar"));
  solver.start_clip();
  for (int k = 0; k < 4; ++k) solver.step_clip();
  const std::vector<std::byte> by_clip = solver.save();
  for (int k = 0; k < 4; ++k) solver.step_clip();
  other.load(by_clip);
  EXPECT_EQ(other.frame().index, 4u);
  for (int k = 0; k < 4; ++k) other.step_clip();
  EXPECT_EQ(other.position_hash(), solver.position_hash());

  // With poses, the last pose is saved too: the next frame starts there.
  solver.start_pose(solver.clip_pose(0));
  solver.step_pose(solver.clip_pose(5));
  const std::vector<std::byte> by_poses = solver.save();
  solver.step_pose(solver.clip_pose(9));
  other.load(by_poses);
  other.step_pose(other.clip_pose(9));
  EXPECT_EQ(other.position_hash(), solver.position_hash());
}

TEST(Steps, DamagedAndForeignStatesAreRefused) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  solver.start_pose(solver.clip_pose(0));
  const std::vector<std::byte> good = solver.save();
  const auto refused = [](fascicle::solver& to, std::vector<std::byte> bytes, const char* why) {
    try {
      to.load(bytes);
      ADD_FAILURE() << why;
    } catch (const fascicle::error& error) {
      EXPECT_EQ(error.status(), FASCICLE_BAD_INPUT) << why << ": " << error.what();
    }
  };
  // Truncated at many lengths, and with single bits flipped.
  for (std::size_t length = 1; length < good.size(); length += 1 + good.size() / 50)
    refused(solver, {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}, "cut off");
  // The head with its time, the pose and the checkpoint.
  for (std::size_t k = 0; k < 512; k += 7) {
    std::vector<std::byte> bytes = good;
    bytes[k] ^= std::byte{0x01};
    refused(solver, bytes, "a byte turned");
  }
  for (const std::size_t k : {std::size_t{0}, std::size_t{16}, std::size_t{24}, good.size() - 1}) {
    std::vector<std::byte> bytes = good;
    bytes[k] ^= std::byte{0x40};
    refused(solver, bytes, "a byte turned");
  }
  const fascicle::scene bar = fascicle::scene::parse(small_bar);
  const fascicle::model bar_model(bar);
  fascicle::solver of_bar(bar_model, fascicle::device("cpu"));
  refused(of_bar, good, "another model's");
  refused(solver, of_bar.save(), "another model's");
  solver.load(good);
}

// With correct checksums: the canonical XXH3-128 of the length and the bytes, and the XXH3-64 at the end of
// the checkpoint, which begins at `checkpoint`.
std::vector<std::byte> resealed(std::vector<std::byte> bytes, std::size_t checkpoint) {
  constexpr std::size_t magic = 8, digits = 32, body = magic + digits;
  const std::uint64_t inner =
      XXH3_64bits(bytes.data() + checkpoint, bytes.size() - sizeof inner - checkpoint);
  std::memcpy(bytes.data() + bytes.size() - sizeof inner, &inner, sizeof inner);
  std::vector<std::byte> hashed(sizeof(std::uint64_t));
  const std::uint64_t length = bytes.size() - body;
  std::memcpy(hashed.data(), &length, sizeof length);
  hashed.insert(hashed.end(), bytes.begin() + body, bytes.end());
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(hashed.data(), hashed.size()));
  for (std::size_t k = 0; k < digits; ++k) {
    const unsigned nibble = k % 2 == 0 ? canonical.digest[k / 2] >> 4 : canonical.digest[k / 2] & 15;
    bytes[magic + k] = static_cast<std::byte>("0123456789abcdef"[nibble]);
  }
  return bytes;
}

// What a stranger wrote is refused, or it is a state: the next step then ends, with or without a finite
// result.
TEST(Steps, ForgedStatesAreTakenOrRefused) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu", 1));
  const std::vector<double> pose = solver.clip_pose(0);
  solver.start_pose(pose);
  const std::vector<std::byte> good = solver.save();
  constexpr std::size_t head = 40, pose_begin = head + 32;
  const std::size_t checkpoint = pose_begin + pose.size() * sizeof(double);
  ASSERT_EQ(std::memcmp(good.data() + checkpoint, "FASCCKPT", 8), 0);
  ASSERT_EQ(resealed(good, checkpoint), good) << "the test seals as the library does";

  std::mt19937_64 random(1);
  int taken = 0, refused = 0, bad_input = 0;
  const auto offer = [&](const std::vector<std::byte>& changed, std::size_t at) {
    const std::vector<std::byte> bytes = resealed(changed, checkpoint);
    const fascicle_status loaded = fascicle_solver_load(solver.get(), bytes.data(), bytes.size());
    if (loaded != FASCICLE_OK) {
      ++refused;
      bad_input += loaded == FASCICLE_BAD_INPUT;
      EXPECT_TRUE(loaded == FASCICLE_BAD_INPUT || loaded == FASCICLE_NOT_FINITE)
          << at << ": " << fascicle_last_message();
      return;
    }
    ++taken;
    try {
      solver.step_pose(pose);
    } catch (const fascicle::error& error) {
      EXPECT_TRUE(error.status() == FASCICLE_NOT_FINITE || error.status() == FASCICLE_BAD_ARGUMENT)
          << at << ": " << error.what();
    }
  };
  // Each byte before the first array, and others at random: another bit, all bits, a number that is not one.
  const std::size_t described = std::min(good.size() - 8, checkpoint + 600);
  for (std::size_t k = 0; k < 900; ++k) {
    const std::size_t at = k < described - head ? head + k : head + random() % (good.size() - 8 - head);
    std::vector<std::byte> bytes = good;
    if (k % 3 == 0) {
      bytes[at] ^= static_cast<std::byte>(1U << (random() % 8));
    } else if (k % 3 == 1) {
      bytes[at] = std::byte{0xff};
    } else {
      const double nan = std::nan("");
      const std::size_t begin = std::min(at - at % 8, good.size() - 16);
      std::memcpy(bytes.data() + begin, &nan, sizeof nan);
    }
    offer(bytes, at);
  }
  // A value less in an array, whose length says so.
  std::vector<std::byte> shorter = good;
  const std::uint64_t floats = solver.positions().size();
  const std::vector<std::byte> length(reinterpret_cast<const std::byte*>(&floats),
                                      reinterpret_cast<const std::byte*>(&floats + 1));
  const auto found = std::search(shorter.begin() + static_cast<std::ptrdiff_t>(checkpoint), shorter.end(),
                                 length.begin(), length.end());
  ASSERT_NE(found, shorter.end());
  const std::uint64_t fewer = floats - 1;
  std::memcpy(&*found, &fewer, sizeof fewer);
  shorter.erase(found + 8, found + 12);
  const int before = bad_input;
  offer(shorter, 0);
  EXPECT_EQ(bad_input, before + 1) << fascicle_last_message();
  EXPECT_GT(taken, 20);
  EXPECT_GT(refused, 200);
  solver.load(good);
}

TEST(Steps, WrongSizesAndOrdersAreRefused) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  const auto refused = [](auto call, const char* part) {
    try {
      call();
      ADD_FAILURE() << part;
    } catch (const fascicle::error& error) {
      EXPECT_EQ(error.status(), FASCICLE_BAD_ARGUMENT) << error.what();
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  std::vector<double> pose = solver.clip_pose(0);
  refused([&] { solver.step_clip(); }, "fascicle_solver_start_clip");
  refused([&] { solver.step_pose(pose); }, "fascicle_solver_start_pose");
  refused([&] { solver.start_pose(std::vector<double>(16)); }, "count is 16");
  std::vector<float> few(3);
  refused([&] { solver.positions(few); }, "count is 3");
  refused([&] { solver.surface(few); }, "count is 3");
  EXPECT_THROW(solver.step_pose(std::vector<double>(17)), std::invalid_argument);
  pose[5] = std::nan("");
  refused([&] { solver.start_pose(pose); }, "not finite");
  std::size_t size = 0;
  char byte = 0;
  refused([&] { fascicle::check(fascicle_solver_save(solver.get(), &byte, 1, &size)); }, "capacity is 1");
}

TEST(Steps, DrivesThatAreNotFiniteAreRefused) {
  const fascicle::model bar(fascicle::scene::parse(small_bar), {.cache = ""});
  fascicle::solver solver(bar, fascicle::device("cpu"));
  const float decay = 1.0F;
  const auto refused = [&](const char* part, auto change) {
    fascicle_drive drive = fascicle_drive_default();
    drive.h = 0.01;
    drive.decay = &decay;
    drive.decay_count = 1;
    change(drive);
    EXPECT_EQ(fascicle_solver_step_drive(solver.get(), &drive), FASCICLE_BAD_ARGUMENT) << part;
    EXPECT_NE(std::string(fascicle_last_message()).find(part), std::string::npos) << fascicle_last_message();
  };
  using Drive = fascicle_drive;
  refused("drive.origin is not finite", [](Drive& d) { d.origin[1] = std::nan(""); });
  refused("drive.origin_shift is not finite", [](Drive& d) { d.origin_shift[0] = INFINITY; });
  refused("drive.gravity is not finite", [](Drive& d) { d.gravity[2] = std::nanf(""); });
  const float wrong = -1.0F;
  refused("drive.decay", [&](Drive& d) { d.decay = &wrong; });
  fascicle_drive drive = fascicle_drive_default();
  drive.h = 0.01;
  drive.decay = &decay;
  drive.decay_count = 1;
  EXPECT_EQ(fascicle_solver_step_drive(solver.get(), &drive), FASCICLE_OK) << fascicle_last_message();
}

// Rounding and traps belong to the caller: another program may have changed both.
TEST(Steps, TheCallersRoundingChangesNoBit) {
  const auto hash = [] {
    const fascicle::model bar(fascicle::scene::parse(small_bar), {.cache = ""});
    fascicle::solver solver(bar, fascicle::device("cpu", 2));
    solver.start_clip();
    for (int k = 0; k < 6; ++k) solver.step_clip();
    return solver.position_hash();
  };
  const std::string expected = hash();
  std::fenv_t before;
  std::fegetenv(&before);
  for (const int rounding : {FE_UPWARD, FE_TOWARDZERO}) {
    std::fesetround(rounding);
    const std::string found = hash();
    EXPECT_EQ(std::fegetround(), rounding) << "the caller's";
    std::fesetenv(&before);
    EXPECT_EQ(found, expected);
  }
  feenableexcept(FE_DIVBYZERO | FE_INVALID);
  const std::string found = hash();
  const int enabled = fegetexcept();
  std::fesetenv(&before);
  EXPECT_EQ(found, expected);
  EXPECT_EQ(enabled, FE_DIVBYZERO | FE_INVALID);
}

// A fork has no threads but its own. Waiting for the solver's would never end.
TEST(Steps, AForkLeavesItsParentsSolversAlone) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer does not support threads that a fork of a threaded process starts";
#endif
  fascicle_scene* scene = nullptr;
  fascicle_model* model = nullptr;
  fascicle_device* device = nullptr;
  fascicle_solver* solver = nullptr;
  ASSERT_EQ(fascicle_scene_parse(small_bar, "", nullptr, &scene), FASCICLE_OK);
  ASSERT_EQ(fascicle_model_build(scene, nullptr, &model), FASCICLE_OK);
  fascicle_device_options threads = fascicle_device_options_default();
  threads.threads = 3;
  ASSERT_EQ(fascicle_device_open("cpu", &threads, &device), FASCICLE_OK);
  ASSERT_EQ(fascicle_solver_create(model, device, nullptr, &solver), FASCICLE_OK);
  ASSERT_EQ(fascicle_solver_start_clip(solver, nullptr, nullptr), FASCICLE_OK);
  ASSERT_EQ(fascicle_solver_step_clip(solver), FASCICLE_OK);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the pool's threads sleep
  const pid_t child = fork();
  if (child == 0) {
    alarm(30);
    const bool is_refused = fascicle_solver_step_clip(solver) == FASCICLE_BAD_ARGUMENT &&
                            std::strstr(fascicle_last_message(), "of which this is a fork") != nullptr;
    fascicle_solver* other = nullptr;
    const bool device_is = fascicle_solver_create(model, device, nullptr, &other) == FASCICLE_BAD_ARGUMENT;
    fascicle_solver_destroy(solver);
    fascicle_device_destroy(device);
    fascicle_device* own = nullptr;
    const bool works = fascicle_device_open("cpu", &threads, &own) == FASCICLE_OK &&
                       fascicle_solver_create(model, own, nullptr, &other) == FASCICLE_OK &&
                       fascicle_solver_start_clip(other, nullptr, nullptr) == FASCICLE_OK &&
                       fascicle_solver_step_clip(other) == FASCICLE_OK;
    fascicle_solver_destroy(other);
    fascicle_device_destroy(own);
    _exit(is_refused && device_is && works ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the child was refused, destroyed both and made its own";
  EXPECT_EQ(fascicle_solver_step_clip(solver), FASCICLE_OK) << "the parent goes on";
  fascicle_solver_destroy(solver);
  fascicle_device_destroy(device);
  fascicle_model_destroy(model);
  fascicle_scene_destroy(scene);
}

TEST(Steps, ALeadInIsCancelled) {
  const fascicle::scene scene("arm", {.set = {"motion.preroll=0.5"}, .end = 0.1});
  const fascicle::model model(scene, {.cache = ""});
  fascicle::solver solver(model, fascicle::device("cpu"));
  int calls = 0;
  try {
    solver.start_clip([&](fascicle_phase phase, std::uint64_t, std::uint64_t) {
      EXPECT_EQ(phase, FASCICLE_PHASE_LEAD_IN);
      return ++calls < 3;
    });
    ADD_FAILURE() << "it was not cancelled";
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_CANCELLED);
  }
  EXPECT_EQ(calls, 3);
  EXPECT_THROW(solver.step_clip(), fascicle::error);

  // The same for a bake: nothing is written yet, and it can be resumed.
  const Folder folder;
  fascicle::bake_options options{.folder = folder / "out", .device = "cpu", .cache = ""};
  options.progress = [](fascicle_phase phase, std::uint64_t done, std::uint64_t) {
    return phase != FASCICLE_PHASE_LEAD_IN || done < 2;
  };
  EXPECT_THROW((void)fascicle::bake(scene, options), fascicle::error);
  options.progress = {};
  options.resume = true;
  const fascicle::bake_result bake = fascicle::bake(scene, options);
  solver.start_clip();
  for (std::uint64_t frame = 1; frame <= scene.frame_count(); ++frame) solver.step_clip();
  EXPECT_EQ(solver.position_hash(), bake.position_hash()) << "the lead-in is the same as the bake's";
}

// A wrong pose count is refused before any number is read: the second pose here is not valid.
TEST(Steps, PosesAreCountedBeforeTheyAreRead) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  std::vector<double> poses = solver.clip_pose(0);
  solver.start_pose(poses);
  poses.resize(2 * poses.size(), std::nan(""));
  try {
    solver.step_pose(poses);
    ADD_FAILURE() << "two poses for one substep";
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_BAD_ARGUMENT);
    EXPECT_NE(std::string(error.what()).find("pose.pose_count is 2"), std::string::npos) << error.what();
  }
}

TEST(Steps, PosesColumnByColumnAreRefused) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  const std::vector<double> pose = solver.clip_pose(0);
  std::vector<double> turned = pose;
  turned[16 + 3] += 0.5;
  std::vector<double> by_columns = turned;
  for (std::size_t j = 0; 16 * j < turned.size(); ++j)
    for (std::size_t k = 0; k < 16; ++k) by_columns[16 * j + k] = turned[16 * j + 4 * (k % 4) + k / 4];
  EXPECT_NO_THROW(solver.start_pose(turned));
  try {
    solver.start_pose(by_columns);
    ADD_FAILURE() << "a column-major pose was accepted";
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_BAD_ARGUMENT);
    EXPECT_NE(std::string(error.what()).find("the last row must be 0 0 0 1"), std::string::npos)
        << error.what();
  }
  // Blended or inverted poses have this row only up to rounding.
  std::vector<double> rounded = pose;
  rounded[15] -= 0x1p-50;
  EXPECT_NO_THROW(solver.start_pose(rounded));
}

// After the scene's last frame the clip plays on to its own end; a held clip stays held.
TEST(Steps, AClipPlaysOnBeyondTheScenesEnd) {
  const auto moves_between = [](const char* change, std::uint64_t from, std::uint64_t to) {
    const fascicle::scene scene("arm", {.set = {"solver.substeps=1", change}, .fps = 60.0, .end = 0.5});
    fascicle::solver solver(fascicle::model(scene, {.cache = ""}), fascicle::device("cpu"));
    return solver.clip_pose(from) != solver.clip_pose(to);
  };
  EXPECT_TRUE(moves_between("motion.preroll=0.0", 30, 40));
  EXPECT_FALSE(moves_between("motion.hold=0.1", 30, 40));
  EXPECT_FALSE(moves_between("motion.loop=2", 60, 70));
}

void expect_at_rest(const fascicle::solver& solver, const std::vector<float>& rest) {
  EXPECT_EQ(solver.frame().index, 0u);
  EXPECT_EQ(solver.positions(), rest);
}

TEST(Steps, ACancelledStartLeavesTheSolverAtRest) {
  const fascicle::scene scene("arm", {.set = {"motion.preroll=0.5"}, .end = 0.1});
  const fascicle::model model(scene, {.cache = ""});
  fascicle::solver solver(model, fascicle::device("cpu"));
  const std::vector<float> rest = solver.positions();
  const std::vector<std::byte> saved = solver.save();
  solver.start_pose(solver.clip_pose(3));
  solver.step_pose(solver.clip_pose(6));
  int calls = 0;
  EXPECT_THROW(solver.start_clip([&](auto...) { return ++calls < 9; }), fascicle::error);
  expect_at_rest(solver, rest);
  EXPECT_EQ(solver.save(), saved) << "what is saved is what is shown";
  EXPECT_THROW(solver.step_pose(solver.clip_pose(6)), fascicle::error) << "it follows nothing";
}

// A force fit for a bridge on a bar of 40 nanometres, 1000 s long, while it settles.
TEST(Steps, ALeadInThatDivergesSaysSo) {
  const fascicle::scene scene = fascicle::scene::parse(
      "[scene]\nfps = 0.01\nend = 1000.0\n"
      "[bar]\nsize = [4e-8, 1e-8, 1e-8]\nvertices = [5, 3, 3]\n[layers.flesh]\nalpha = 0.5\n"
      "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n"
      "[force.tear]\nkind = \"point\"\nvector = [1e9, 0, 0]\nstart = -1e5\nend = 1e5\n"
      "where = { above = { axis = \"x\", fraction = 0.8 } }\n[motion]\nsettle = 1000.0\n");
  const fascicle::model model(scene);
  fascicle::solver solver(model, fascicle::device("cpu"));
  const std::vector<float> rest = solver.positions();
  try {
    solver.start_clip();
    ADD_FAILURE() << "it did not diverge, or that went unnoticed";
  } catch (const fascicle::error& error) {
    EXPECT_EQ(error.status(), FASCICLE_NOT_FINITE) << error.what();
  }
  expect_at_rest(solver, rest);
  EXPECT_THROW(solver.step_clip(), fascicle::error);
}

TEST(Steps, TheSurfaceIsInTheWorldInMetres) {
  fascicle::solver solver(arm_model(), fascicle::device("cpu"));
  solver.start_clip();
  const fascicle_frame frame = solver.frame();
  ASSERT_GT(frame.surface_vertex_count, 0u);
  const std::vector<float> surface = solver.surface();
  for (std::size_t k = 0; k < surface.size(); ++k)
    ASSERT_NEAR(surface[k], frame.origin[k % 3] + frame.unit * static_cast<double>(frame.surface[k]), 1e-6);
}

}  // namespace
}  // namespace fascicle_tests
