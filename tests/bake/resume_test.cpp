// A stopped bake resumes to the same bytes wherever it was stopped, and never from damaged files.
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/checkpoint.h"
#include "host/bake/sealed_json.h"
#include "tests/bake/fake_bakes.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::bake;
using bake::BakeError;
using bake::BakeOptions;
using bake::BakeResult;

TEST(BakeResume, AtEveryFrameGivesTheSameBytes) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "whole"), short_scene(9));
  const auto whole = content_of(folder / "whole");
  for (std::uint64_t last = 0; last < 9; ++last) {
    const fs::path out = folder / ("cut" + std::to_string(last));
    const BakeResult first = bake_until(options_for(out), short_scene(9), last);
    EXPECT_TRUE(first.interrupted);
    EXPECT_EQ(first.frames_done, last);
    EXPECT_EQ(manifest_in(out)["status"], "interrupted");
    EXPECT_EQ(manifest_in(out)["frames_done"], last);
    // Only complete files have their final names.
    EXPECT_FALSE(fs::exists(out / "surface.pc2"));
    EXPECT_FALSE(fs::exists(out / "metrics.csv"));
    EXPECT_FALSE(fs::exists(out / "vtu/series.pvd"));
    for (const char* name : {"surface.mdd", "surface.abc", "surface.usda", "surface.glb"})
      EXPECT_FALSE(fs::exists(out / name)) << name;
    BakeOptions options = options_for(out);
    options.resume = true;
    const BakeResult second = fake_bake_into(options, short_scene(9));
    EXPECT_EQ(second.frames_done, 9u);
    EXPECT_EQ(content_of(out), whole) << "stopped after frame " << last;
    EXPECT_EQ(manifest_in(out)["timings"]["runs"], 2);
  }
}

// Muscles clamped before the stop are still in the report of the whole bake.
TEST(BakeResume, RemembersClampedMuscles) {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  bake_until(options_for(out), short_scene(6), 3);
  nlohmann::json manifest = manifest_in(out);
  manifest["clamped_muscles"] = {{"regions", 5}, {"frame", 2}};
  for (const char* key : {"solver_seconds", "writing_seconds", "total_seconds"})
    manifest["timings"][key] = 1000.5;
  write_text(out / "manifest.json", bake::sealed_text(manifest));
  BakeOptions options = options_for(out);
  options.resume = true;
  const BakeResult result = fake_bake_into(options, short_scene(6));
  EXPECT_EQ(result.clamped.regions, 5u);
  EXPECT_EQ(result.clamped.frame, 2u);
  // Timings are sums over all runs.
  for (const char* key : {"solver_seconds", "writing_seconds", "total_seconds"})
    EXPECT_GE(manifest_in(out)["timings"][key], 1000.5) << key;
  EXPECT_EQ(manifest_in(out)["clamped_muscles"]["regions"], 5);
}

// The lead-in before frame 0 is not run again; frame 0 starts from its end state.
TEST(BakeResume, GoesOnAfterALeadIn) {
  const TemporaryFolder folder;
  BendingBar bar = bending_bar(0.2);
  bar.character().clips.push_back({"bent", 0.2, {turn_channel(1, {0.0, 0.2}, {1.0, 1.4})}});
  // The skin is three render vertices, each on a model vertex.
  bar.model.surface_vertex = {0, 1, 2, 3, 1, 2, 3, 4, 2, 3, 4, 5};
  bar.model.surface_weight = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  bar.model.surface_triangle = {0, 1, 2};
  bar.character().surface = {{3, Eigen::Vector3d::Zero()}, {{0, 1, 2}}};
  bar.character().joints.assign(3, {});
  bar.character().weights.assign(3, {1.0});
  bar.scene.motion.preroll = 0.1;
  bar.scene.motion.settle = 0.3;
  const auto bake_bar = [&](BakeOptions options, std::uint64_t last) {
    std::atomic<bool> interrupted = false;
    options.interrupted = &interrupted;
    options.on_frame = [&](std::uint64_t frame, std::uint64_t) { interrupted = frame >= last; };
    const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 2);
    return bake(bar.scene, bar.model, *solver, options);
  };
  const std::uint64_t frames = bake_bar(options_for(folder / "whole"), 1000).frames_done;
  EXPECT_EQ(frames, 12u);
  const auto whole = content_of(folder / "whole");
  for (const std::uint64_t last : {1u, 7u}) {
    const fs::path out = folder / ("cut" + std::to_string(last));
    EXPECT_TRUE(bake_bar(options_for(out), last).interrupted);
    const auto saved = bake::read_checkpoint(out / "checkpoint");
    ASSERT_TRUE(saved);
    const std::uint64_t size = fs::file_size(out / "checkpoint"),
                        estimate = bake::checkpoint_bytes(bar.model);
    EXPECT_LE(size, estimate);
    EXPECT_LE(estimate, size + 4096);  // what it allows for the identity
    for (std::size_t k = 0; k < saved->skinned.size(); ++k) {
      bake::Checkpoint damaged = *saved;
      damaged.state.frame = 1;  // the first that has a frame before it
      damaged.skinned[k].pop_back();
      EXPECT_TRUE(contains(
          message_of<BakeError>([&] { bake::check_checkpoint(damaged, bar.model, frames, "a/checkpoint"); }),
          "a/checkpoint: the checkpoint is damaged (its skinned positions are of another body)"));
    }
    BakeOptions options = options_for(out);
    options.resume = true;
    EXPECT_EQ(bake_bar(options, 1000).frames_done, frames);
    EXPECT_EQ(content_of(out), whole) << "stopped after frame " << last;
  }
}

// checkpoint.h describes the file: a reader written from it alone reaches the end and finds what was saved.
TEST(Checkpoint, IsWhatItsHeaderDescribes) {
  bake::Checkpoint saved;
  saved.identity = {{"scene", "a bar"}, {"fps", "24"}};
  saved.state.frame = 7;
  saved.state.origin = {1.0, -2.0, 0.5};
  float value = 0.0f;
  for (std::vector<float>* values :
       {&saved.state.positions, &saved.state.velocities, &saved.state.rotations, &saved.state.skinned,
        &saved.state.skinned_velocities, &saved.state.positions_before, &saved.state.velocities_before,
        &saved.skinned[0], &saved.skinned[1]})
    for (int k = 0; k < 2 + static_cast<int>(value) % 3; ++k) values->push_back(value += 0.5f);
  saved.state.step_before = 0.0125;
  const std::string bytes = bake::checkpoint_text(saved);

  std::size_t at = 0;
  const auto read = [&](auto& out) {
    ASSERT_LE(at + sizeof out, bytes.size());
    std::memcpy(&out, bytes.data() + at, sizeof out);
    at += sizeof out;
  };
  const auto expect_floats = [&](const std::vector<float>& wanted) {
    std::uint64_t count = 0;
    read(count);
    ASSERT_EQ(count, wanted.size());
    for (const float of_saved : wanted) {
      float found = 0.0f;
      read(found);
      EXPECT_EQ(found, of_saved);
    }
  };
  EXPECT_EQ(bytes.substr(0, 8), "FASCCKPT");
  at = 8;
  std::uint32_t version = 0, identity_bytes = 0;
  read(version);
  read(identity_bytes);
  const std::string header = read_text(fs::path(FASCICLE_SOURCE_DIR) / "host/bake/checkpoint.h");
  EXPECT_TRUE(contains(header, "uint32 version " + std::to_string(version) + ","));
  const nlohmann::json identity = nlohmann::json::parse(bytes.substr(at, identity_bytes));
  EXPECT_EQ(identity, nlohmann::json::parse(R"([["scene", "a bar"], ["fps", "24"]])"));
  at += identity_bytes;
  std::uint64_t frame = 0;
  read(frame);
  EXPECT_EQ(frame, 7u);
  std::array<double, 3> origin{};
  read(origin);
  EXPECT_EQ(origin, saved.state.origin);
  for (const auto* values :
       {&saved.state.positions, &saved.state.velocities, &saved.state.rotations, &saved.state.skinned,
        &saved.state.skinned_velocities, &saved.state.positions_before, &saved.state.velocities_before})
    expect_floats(*values);
  double step = 0.0;
  read(step);
  EXPECT_EQ(step, 0.0125);
  expect_floats(saved.skinned[0]);
  expect_floats(saved.skinned[1]);
  EXPECT_EQ(at + 8, bytes.size()) << "the checksum is the last field";
}

TEST(BakeResume, StartsWhereThereIsNothing) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(2)).frames_done, 2u);
}

TEST(BakeResume, RefusesDamagedFiles) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  const auto refusal_after = [&](const std::string& name, const auto& damage) {
    fs::remove_all(folder / "out");
    options.resume = false;
    bake_until(options, short_scene(6), 4);
    const fs::path path = folder / ("out/" + name);
    std::string text = read_text(path);
    damage(text);
    write_text(path, text);
    options.resume = true;
    return message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); });
  };
  const auto halve = [](std::string& text) { text.resize(text.size() / 2); };
  const auto flip_middle = [](std::string& text) {
    text[text.size() / 2] = static_cast<char>(text[text.size() / 2] ^ 4);
  };
  EXPECT_TRUE(contains(refusal_after("checkpoint", halve), "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("checkpoint", flip_middle), "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("checkpoint", [](std::string& text) { text.clear(); }),
                       "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("frames.fascicle", halve), "complete frames, but the checkpoint has 5"));
  EXPECT_TRUE(contains(refusal_after("frames.fascicle", flip_middle), "is damaged"));
  EXPECT_TRUE(contains(refusal_after("metrics.csv.part", halve), "fewer frames than the checkpoint"));
  // After any of these, a fresh start works.
  options.resume = false;
  options.overwrite = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(6)).frames_done, 6u);
}

TEST(BakeResume, DropsAHalfWrittenFrame) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "whole"), short_scene(6));
  const auto whole = content_of(folder / "whole");
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(6), 3);
  for (const char* name : {"out/frames.fascicle", "out/surface.pc2.part", "out/metrics.csv.part"})
    write_text(folder / name, read_text(folder / name) + "half a frame");
  options.resume = true;
  fake_bake_into(options, short_scene(6));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

// The manifest never counts frames that are about to be rewritten, even if a kill left it ahead of the
// checkpoint.
TEST(BakeResume, CountsNoFrameThatItWritesAgain) {
  const TemporaryFolder folder;
  bake_until(options_for(folder / "earlier"), short_scene(9), 3);
  bake_until(options_for(folder / "cut"), short_scene(9), 6);
  fs::copy_file(folder / "earlier/checkpoint", folder / "cut/checkpoint",
                fs::copy_options::overwrite_existing);
  ASSERT_EQ(manifest_in(folder / "cut")["frames_done"], 6);
  BakeOptions options = options_for(folder / "cut");
  options.resume = true;
  options.checkpoint_frames = 100;
  int looked = 0;
  FakeOptions fake;
  // Before the frame is computed: later its writer may have counted it.
  fake.on_submit = [&](std::uint64_t frame) {
    if (frame != 4) return;
    ++looked;
    const nlohmann::json manifest = manifest_in(folder / "cut");
    EXPECT_EQ(manifest["frames_done"], 3);
    EXPECT_EQ(manifest["position_hashes"].size(), 4u);
    EXPECT_EQ(manifest["status"], "running");
  };
  EXPECT_EQ(fake_bake_into(options, short_scene(9), fake).frames_done, 9u);
  EXPECT_EQ(looked, 1);
}

TEST(BakeResume, SurvivesBeingKilledAtRandomMoments) {
  const TemporaryFolder folder;
  constexpr std::uint64_t frames = 24;
  constexpr unsigned frame_microseconds = 1000;
  const auto before = std::chrono::steady_clock::now();
  fake_bake_into(options_for(folder / "whole"), short_scene(frames));
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
  const auto whole = content_of(folder / "whole");
  std::mt19937 random(1);
  int kills = 0, kills_with_checkpoint = 0;
  for (int round = 0; round < 5; ++round) {
    const fs::path out = folder / ("round" + std::to_string(round));
    // The first lifetime is shorter than the solver's own time, so each round has a kill. Later ones get
    // longer, so each round ends.
    unsigned longest = frames * frame_microseconds;
    for (bool done = false; !done; longest += static_cast<unsigned>(took.count() / 4)) {
      BakeOptions options = options_for(out);
      options.resume = true;
      options.checkpoint_frames = 1 + random() % 7;
      const unsigned life = static_cast<unsigned>(random() % longest);
      const pid_t child = ::fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        int code = 1;
        try {
          FakeOptions fake;
          fake.microseconds = frame_microseconds;
          fake_bake_into(options, short_scene(frames), fake);
          code = 0;
        } catch (const std::exception& error) {
          std::fprintf(stderr, "child: %s\n", error.what());
        }
        ::_exit(code);
      }
      ::usleep(life);
      ::kill(child, SIGKILL);
      int status = 0;
      ASSERT_EQ(::waitpid(child, &status, 0), child);
      if (WIFSIGNALED(status)) {
        ++kills;
        if (fs::exists(out / "checkpoint")) ++kills_with_checkpoint;
        continue;
      }
      ASSERT_EQ(WEXITSTATUS(status), 0) << "a resumed bake failed";
      done = true;
    }
    EXPECT_EQ(content_of(out), whole) << "round " << round;
  }
  EXPECT_GE(kills, 5);
  EXPECT_GT(kills_with_checkpoint, 0);
}

}  // namespace
}  // namespace fascicle::tests
