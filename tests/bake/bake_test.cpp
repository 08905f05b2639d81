// The frame loop: pipelining, resume, what is refused, and what is left behind when a bake ends early.
#include "host/bake/bake.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cpu_reference/cpu_solver.h"
#include "host/bake/checkpoint.h"
#include "host/bake/read_frame_cache.h"
#include "host/model/validate.h"
#include "tests/bake/bending_bar.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::bake;
using bake::BakeError;
using bake::BakeOptions;
using bake::BakeResult;

BakeResult bake_into(const BakeOptions& options, const scene::Scene& scene, FakeOptions fake = {}) {
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model, fake);
  return bake(scene, model, solver, options);
}

// Bakes until frame `last` is written, then stops as on ctrl-C.
BakeResult bake_until(BakeOptions options, const scene::Scene& scene, std::uint64_t last) {
  std::atomic<bool> interrupted = last == 0;
  options.interrupted = &interrupted;
  FakeOptions fake;
  fake.on_submit = [&](std::uint64_t frame) { interrupted = frame >= last; };
  return bake_into(options, scene, fake);
}

nlohmann::json manifest_in(const fs::path& folder) {
  return nlohmann::json::parse(read_text(folder / "manifest.json"));
}

// What a call throws as Error, or a line that no test expects.
template <class Error, class Call>
std::string message_of(Call call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "\"" << part << "\" is not in: " << text;
}

TEST(Bake, WritesEveryFileAndDescribesIt) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.warnings = {"two seams were welded"};
  std::vector<std::uint64_t> shown;
  options.on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
    EXPECT_EQ(frames, 7u);
    shown.push_back(frame);
  };
  const BakeResult result = bake_into(options, short_scene(7));
  EXPECT_EQ(shown, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(result.frames_done, 7u);
  EXPECT_FALSE(result.interrupted);
  // Manifest, checkpoint, model, rest mesh, script, frame cache, metrics, and one for each format.
  EXPECT_EQ(result.files.size(), 7 + bake::format_names().size());
  for (const fs::path& file : result.files) EXPECT_TRUE(fs::exists(file)) << file;

  const nlohmann::json manifest = manifest_in(folder / "out");
  EXPECT_EQ(manifest["status"], "complete");
  EXPECT_EQ(manifest["frames_done"], 7);
  EXPECT_EQ(manifest["frames"], 7);
  EXPECT_EQ(manifest["scene"]["text"], "[solver]\nsubsteps = 2\n");
  EXPECT_EQ(manifest["scene"]["fps"], 24.0);
  EXPECT_EQ(manifest["scene"]["gravity"][1], -9.81);
  EXPECT_EQ(manifest["scene"]["layers"][0]["alpha"], 0.5);
  EXPECT_EQ(manifest["scene"]["layers"][1]["where"][0]["bone_distance"]["maximum"], 0.01);
  EXPECT_EQ(manifest["inputs"][0]["xxh3_64"], "0123456789abcdef");
  EXPECT_EQ(manifest["device"]["float_controls"], "all");
  EXPECT_EQ(manifest["device"]["exact"], true);
  EXPECT_EQ(manifest["model"]["unit"], 0.5);
  EXPECT_EQ(manifest["model"]["rest_origin"][0], 10.0);
  EXPECT_EQ(manifest["warnings"][0], "two seams were welded");
  EXPECT_EQ(manifest["position_hashes"].size(), 8u);
  EXPECT_EQ(manifest["position_hashes"].back(), result.last_position_hash);
  EXPECT_GE(manifest["timings"]["total_seconds"], 0.0);
}

TEST(Bake, HashesArePositionHashes) {
  const TemporaryFolder folder;
  bake_into(options_for(folder / "out"), short_scene(3));
  const bake::FrameCacheReader cache(folder / "out/frames.fascicle");
  ASSERT_EQ(cache.frame_count(), 4u);
  const nlohmann::json hashes = manifest_in(folder / "out")["position_hashes"];
  for (std::uint64_t k = 0; k < 4; ++k)
    EXPECT_EQ(std::stoull(hashes[k].get<std::string>(), nullptr, 16), model::position_hash(cache.read(k)));
  // The frames differ, or equal hashes would say nothing.
  EXPECT_NE(hashes[0], hashes[1]);
  EXPECT_NE(hashes[2], hashes[3]);
}

TEST(Bake, KeepsAFrameInFlight) {
  const TemporaryFolder folder;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake(short_scene(5), model, solver, options_for(folder / "out"));
  EXPECT_EQ(solver.most_in_flight(), 2u);
}

TEST(Bake, ZeroFramesIsTheStartAlone) {
  const TemporaryFolder folder;
  EXPECT_EQ(bake_into(options_for(folder / "out"), short_scene(0)).frames_done, 0u);
  EXPECT_EQ(bake::FrameCacheReader(folder / "out/frames.fascicle").frame_count(), 1u);
  EXPECT_EQ(manifest_in(folder / "out")["status"], "complete");
}

// Where checkpoints fall must not change a byte.
TEST(Bake, CheckpointsChangeNothing) {
  const TemporaryFolder folder;
  bake_into(options_for(folder / "rare"), short_scene(9));
  BakeOptions often = options_for(folder / "often");
  often.checkpoint_frames = 1;
  bake_into(often, short_scene(9));
  EXPECT_EQ(content_of(folder / "rare"), content_of(folder / "often"));
}

TEST(BakeResume, AtEveryFrameGivesTheSameBytes) {
  const TemporaryFolder folder;
  bake_into(options_for(folder / "whole"), short_scene(9));
  const auto whole = content_of(folder / "whole");
  for (std::uint64_t last = 0; last < 9; ++last) {
    const fs::path out = folder / ("cut" + std::to_string(last));
    const BakeResult first = bake_until(options_for(out), short_scene(9), last);
    EXPECT_TRUE(first.interrupted);
    EXPECT_EQ(first.frames_done, last);
    EXPECT_EQ(manifest_in(out)["status"], "interrupted");
    EXPECT_EQ(manifest_in(out)["frames_done"], last);
    // Nothing carries a final name but what is whole.
    EXPECT_FALSE(fs::exists(out / "surface.pc2"));
    EXPECT_FALSE(fs::exists(out / "metrics.csv"));
    EXPECT_FALSE(fs::exists(out / "vtu/series.pvd"));
    for (const char* name : {"surface.mdd", "surface.abc", "surface.usda", "surface.glb"})
      EXPECT_FALSE(fs::exists(out / name)) << name;
    BakeOptions options = options_for(out);
    options.resume = true;
    const BakeResult second = bake_into(options, short_scene(9));
    EXPECT_EQ(second.frames_done, 9u);
    EXPECT_EQ(content_of(out), whole) << "stopped after frame " << last;
    EXPECT_EQ(manifest_in(out)["timings"]["runs"], 2);
  }
}

// Of muscles that a run before the stop drove too far, the whole bake's report still tells.
TEST(BakeResume, RemembersClampedMuscles) {
  const TemporaryFolder folder;
  const fs::path out = folder / "out";
  bake_until(options_for(out), short_scene(6), 3);
  nlohmann::json manifest = manifest_in(out);
  manifest["clamped_muscles"] = {{"regions", 5}, {"frame", 2}};
  write_text(out / "manifest.json", manifest.dump());
  BakeOptions options = options_for(out);
  options.resume = true;
  const BakeResult result = bake_into(options, short_scene(6));
  EXPECT_EQ(result.clamped.regions, 5u);
  EXPECT_EQ(result.clamped.frame, 2u);
  EXPECT_EQ(manifest_in(out)["clamped_muscles"]["regions"], 5);
}

// What leads in before frame 0 is not run again, and its end is the state that frame 0 starts from.
TEST(BakeResume, GoesOnAfterALeadIn) {
  const TemporaryFolder folder;
  BendingBar bar = bending_bar(0.2);
  bar.character().clips.push_back({"bent", 0.2, {turn_channel(1, {0.0, 0.2}, {1.0, 1.4})}});
  // Three riders, each on a vertex, are all its skin.
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
    BakeOptions options = options_for(out);
    options.resume = true;
    EXPECT_EQ(bake_bar(options, 1000).frames_done, frames);
    EXPECT_EQ(content_of(out), whole) << "stopped after frame " << last;
  }
}

TEST(BakeResume, ACompleteBakeStaysAsItIs) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_into(options, short_scene(4));
  const auto before = content_of(folder / "out");
  options.resume = true;
  EXPECT_EQ(bake_into(options, short_scene(4)).frames_done, 4u);
  EXPECT_EQ(content_of(folder / "out"), before);
}

TEST(BakeResume, StartsWhereThereIsNothing) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  EXPECT_EQ(bake_into(options, short_scene(2)).frames_done, 2u);
}

// A bake that stops between the renames at its end has some files under their final names.
TEST(BakeResume, TakesBackFinishedFiles) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_into(options, short_scene(4));
  const auto whole = content_of(folder / "out");
  fs::rename(folder / "out/surface.pc2", folder / "out/surface.pc2.part");
  fs::remove(folder / "out/vtu/series.pvd");
  options.resume = true;
  bake_into(options, short_scene(4));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

TEST(BakeResume, RefusesOtherSettingsAndNamesThem) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(6), 3);
  options.resume = true;
  const auto refusal = [&](const scene::Scene& scene, const BakeOptions& changed) {
    return message_of<BakeError>([&] { bake_into(changed, scene); });
  };
  scene::Scene scene = short_scene(6);
  scene.fps = 30.0;
  EXPECT_TRUE(contains(refusal(scene, options), "fps was 24 and is 30"));
  scene = short_scene(6);
  scene.solver.substeps = 3;
  EXPECT_TRUE(contains(refusal(scene, options), "solver.substeps was 2 and is 3"));
  scene = short_scene(6);
  scene.gravity.y() = 0.0;
  EXPECT_TRUE(contains(refusal(scene, options), "gravity was [0.0,-9.81,0.0] and is [0.0,0.0,0.0]"));
  scene = short_scene(6);
  scene.input_hashes[0].second = "ffffffffffffffff";
  EXPECT_TRUE(contains(refusal(scene, options), "the content of body.mesh was 0123456789abcdef"));
  BakeOptions changed = options;
  changed.formats = {"pc2"};
  EXPECT_TRUE(
      contains(refusal(short_scene(6), changed), "--format was abc,glb,mdd,obj,pc2,usda,vtu and is pc2"));
  changed = options;
  changed.device.exact = false;
  EXPECT_TRUE(contains(refusal(short_scene(6), changed), "device was exact and is fake, none"));
  // Another exact device has the same bits.
  changed = options;
  changed.device.name = "another";
  EXPECT_EQ(bake_into(changed, short_scene(6)).frames_done, 6u);
}

TEST(BakeResume, RefusesAnotherModel) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(6), 3);
  options.resume = true;
  model::Model model = two_tetrahedra();
  model.beta[2] = 0.5f;
  FakeSolver solver(model);
  EXPECT_TRUE(
      contains(message_of<BakeError>([&] { bake(short_scene(6), model, solver, options); }), "model was "));
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
    return message_of<BakeError>([&] { bake_into(options, short_scene(6)); });
  };
  const auto halve = [](std::string& text) { text.resize(text.size() / 2); };
  const auto flip_middle = [](std::string& text) {
    text[text.size() / 2] = static_cast<char>(text[text.size() / 2] ^ 4);
  };
  EXPECT_TRUE(contains(refusal_after("checkpoint", halve), "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("checkpoint", flip_middle), "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("checkpoint", [](std::string& text) { text.clear(); }),
                       "checkpoint is damaged"));
  EXPECT_TRUE(contains(refusal_after("frames.fascicle", halve), "whole frames and the checkpoint 5"));
  EXPECT_TRUE(contains(refusal_after("frames.fascicle", flip_middle), "is damaged"));
  EXPECT_TRUE(contains(refusal_after("surface.pc2.part", halve), "fewer frames than the checkpoint"));
  EXPECT_TRUE(contains(refusal_after("metrics.csv.part", halve), "fewer frames than the checkpoint"));
  // And after any of it a new start works.
  options.resume = false;
  options.overwrite = true;
  EXPECT_EQ(bake_into(options, short_scene(6)).frames_done, 6u);
}

TEST(BakeResume, DropsAHalfWrittenFrame) {
  const TemporaryFolder folder;
  bake_into(options_for(folder / "whole"), short_scene(6));
  const auto whole = content_of(folder / "whole");
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(6), 3);
  for (const char* name : {"out/frames.fascicle", "out/surface.pc2.part", "out/metrics.csv.part"})
    write_text(folder / name, read_text(folder / name) + "half a frame");
  options.resume = true;
  bake_into(options, short_scene(6));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

// Death at any moment: the child is killed, often several times, until a run comes through.
TEST(BakeResume, SurvivesBeingKilledAtRandomMoments) {
  const TemporaryFolder folder;
  constexpr std::uint64_t frames = 24;
  constexpr unsigned frame_microseconds = 1000;
  const auto before = std::chrono::steady_clock::now();
  bake_into(options_for(folder / "whole"), short_scene(frames));
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - before;
  const auto whole = content_of(folder / "whole");
  std::mt19937 random(1);
  int kills = 0, kills_with_checkpoint = 0;
  for (int round = 0; round < 5; ++round) {
    const fs::path out = folder / ("round" + std::to_string(round));
    // The first life is shorter than the solver's own time, so each round has a kill; later ones grow, so
    // each ends.
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
          bake_into(options, short_scene(frames), fake);
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

TEST(BakeNotFinite, NamesFrameAndVertexAndKeepsWhatWasBefore) {
  const TemporaryFolder folder;
  const BakeOptions options = options_for(folder / "out");
  const std::string message = message_of<bake::NotFinite>(
      [&] { bake_into(options, short_scene(9), {.not_finite_at = 5, .microseconds = 0, .on_submit = {}}); });
  // Model vertices 1 and 2 are 4 and 0 in the source.
  EXPECT_TRUE(contains(message, "frame 5"));
  EXPECT_TRUE(contains(message, "vertex 0 of layer fat"));
  EXPECT_TRUE(contains(message, "one of 2"));
  EXPECT_TRUE(contains(message, "substeps"));
  const nlohmann::json manifest = manifest_in(folder / "out");
  EXPECT_EQ(manifest["status"], "not-finite");
  EXPECT_EQ(manifest["frames_done"], 4);
  EXPECT_EQ(manifest["message"], message);
  const bake::FrameCacheReader cache(folder / "out/frames.fascicle");
  ASSERT_EQ(cache.frame_count(), 5u);
  EXPECT_EQ(cache.read(4).index, 4u);
  EXPECT_TRUE(bake::read_checkpoint(folder / "out/checkpoint").has_value());
}

TEST(BakeFolder, IsRefusedWhileItHoldsABake) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_into(options, short_scene(2));
  const auto before = content_of(folder / "out");
  const std::string message = message_of<bake::FolderInUse>([&] { bake_into(options, short_scene(3)); });
  EXPECT_TRUE(contains(message, "--resume"));
  EXPECT_TRUE(contains(message, "--overwrite"));
  EXPECT_EQ(content_of(folder / "out"), before);
  // Also where only the cache tells.
  fs::remove(folder / "out/manifest.json");
  EXPECT_THROW(bake_into(options, short_scene(3)), bake::FolderInUse);
}

TEST(BakeFolder, OverwriteRemovesOnlyWhatABakeMade) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_into(options, short_scene(9));
  for (const char* name : {"out/notes.txt", "out/vtu/mine.vtu", "out/vtu/frame_1.vtu", "out/metrics.csv.bak"})
    write_text(folder / name, "precious");
  // A manifest that lists what no bake makes, here and outside.
  write_text(folder / "outside", "precious");
  nlohmann::json manifest = manifest_in(folder / "out");
  manifest["files"].push_back("notes.txt");
  manifest["files"].push_back("../outside");
  manifest["files"].push_back("../");
  write_text(folder / "out/manifest.json", manifest.dump());
  options.overwrite = true;
  options.formats = {};
  bake_into(options, short_scene(2));
  for (const char* name :
       {"out/notes.txt", "out/vtu/mine.vtu", "out/vtu/frame_1.vtu", "out/metrics.csv.bak", "outside"})
    EXPECT_EQ(read_text(folder / name), "precious");
  EXPECT_FALSE(fs::exists(folder / "out/surface.pc2"));
  EXPECT_FALSE(fs::exists(folder / "out/vtu/frame_000000.vtu"));
  EXPECT_FALSE(fs::exists(folder / "out/vtu/series.pvd"));
  EXPECT_EQ(bake::FrameCacheReader(folder / "out/frames.fascicle").frame_count(), 3u);
}

TEST(BakeFolder, OverwriteGivesWhatANewFolderGives) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(9), 5);
  options.overwrite = true;
  bake_into(options, short_scene(4));
  bake_into(options_for(folder / "fresh"), short_scene(4));
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "fresh"));
}

TEST(BakeFolder, ForeignFilesStayAndAreNotOverwritten) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "out");
  write_text(folder / "out/notes.txt", "precious");
  EXPECT_EQ(bake_into(options_for(folder / "out"), short_scene(2)).frames_done, 2u);
  EXPECT_EQ(read_text(folder / "out/notes.txt"), "precious");
  for (const char* name : {"manifest.json", "metrics.csv", "surface.pc2", "rest.obj", "frames.fascicle",
                           "checkpoint", "model.fascicle", "surface.mdd", "surface.abc", "surface.usda",
                           "surface.usda.normals.part", "surface.glb", "import_blender.py"}) {
    const fs::path other = folder / (std::string("other_") + name);
    fs::create_directories(other);
    write_text(other / name, "{\"precious\": true}");
    for (const bool overwrite : {false, true}) {
      BakeOptions options = options_for(other);
      options.overwrite = overwrite;
      EXPECT_TRUE(contains(message_of<BakeError>([&] { bake_into(options, short_scene(2)); }), name));
      EXPECT_EQ(read_text(other / name), "{\"precious\": true}");
    }
  }
}

TEST(BakeFolder, ThatCannotBeWrittenIsNamed) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  EXPECT_TRUE(contains(
      message_of<BakeError>([&] { bake_into(options_for(folder / "file"), short_scene(2)); }), "file"));
  EXPECT_TRUE(contains(
      message_of<std::system_error>([&] { bake_into(options_for(folder / "file/below"), short_scene(2)); }),
      "file"));
  EXPECT_TRUE(contains(
      message_of<std::system_error>([&] { bake_into(options_for("/proc/fascicle"), short_scene(2)); }),
      "/proc/fascicle"));
}

TEST(BakeFolder, IsHeldByOneBakeAtATime) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  std::string message;
  options.on_frame = [&](std::uint64_t frame, std::uint64_t) {
    if (frame != 2) return;
    BakeOptions second = options_for(folder / "out");
    second.overwrite = true;
    message = message_of<BakeError>([&] { bake_into(second, short_scene(2)); });
  };
  EXPECT_EQ(bake_into(options, short_scene(4)).frames_done, 4u);
  EXPECT_TRUE(contains(message, "another bake is writing there"));
}

// The limit on a file's size stands for the full disk: both make write() fall short.
TEST(BakeFolder, AFullDiskLeavesWholeFramesAndCanBeResumed) {
  const TemporaryFolder folder;
  bake_into(options_for(folder / "whole"), short_scene(120));
  const auto whole = content_of(folder / "whole");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    // Room for a vtu file, the manifest and some 40 frames, not for all 120.
    const rlimit limit{8000, 8000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    BakeOptions options = options_for(folder / "out");
    options.checkpoint_frames = 10;
    const std::string message = message_of<std::system_error>([&] { bake_into(options, short_scene(120)); });
    const bool named = contains(message, "/out/") && contains(message, "File too large");
    if (!named) std::fprintf(stderr, "child: %s\n", message.c_str());
    ::_exit(named ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(bake::FrameCacheReader(folder / "out/frames.fascicle").frame_count(), 30u);
  EXPECT_FALSE(fs::exists(folder / "out/surface.pc2"));
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  bake_into(options, short_scene(120));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

TEST(BakeOptions, AreChecked) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"pc2", "fbx"};
  const std::string message = message_of<BakeError>([&] { bake_into(options, short_scene(2)); });
  EXPECT_TRUE(contains(message, "--format fbx"));
  EXPECT_TRUE(contains(message, "pc2, usda, vtu"));
  EXPECT_FALSE(fs::exists(folder / "out"));
  options = options_for(folder / "out");
  options.resume = options.overwrite = true;
  EXPECT_THROW(bake_into(options, short_scene(2)), BakeError);
}

TEST(BakeOptions, OutputBytesIsCloseToWhatIsWritten) {
  const TemporaryFolder folder;
  const scene::Scene scene = short_scene(50);
  bake_into(options_for(folder / "out"), scene);
  std::uint64_t written = 0;
  for (const auto& item : fs::recursive_directory_iterator(folder / "out"))
    if (item.is_regular_file()) written += item.file_size();
  const std::uint64_t estimate = bake::output_bytes(scene, two_tetrahedra(), bake::format_names());
  // The texts' lengths are guessed, and of this tiny body they are most; of a real one they are little.
  EXPECT_GT(static_cast<double>(estimate), 0.8 * static_cast<double>(written));
  EXPECT_LT(static_cast<double>(estimate), 1.25 * static_cast<double>(written));
}

// Counts the frames that another solver steps.
class CountingSolver final : public model::Solver {
 public:
  CountingSolver(model::Solver& solver, std::uint64_t& frames) : solver_(solver), frames_(frames) {}
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override {
    ++frames_;
    solver_.submit(drive, what, probe);
  }
  model::Frame collect() override { return solver_.collect(); }
  model::State save() const override { return solver_.save(); }
  void load(const model::State& state) override { solver_.load(state); }

 private:
  model::Solver& solver_;
  std::uint64_t& frames_;
};

// What was stepped before frame 0 of the same bake is found again, whatever formats are written; of another
// bake it is not.
TEST(Bake, AKeptStartIsNotSteppedAgainAndGivesTheSameBytes) {
  const TemporaryFolder folder;
  BendingBar bar = bending_bar(0.2);
  bar.scene.motion.preroll = 0.1;
  bar.scene.motion.settle = 0.1;
  std::map<std::string, std::string> kept;
  const auto baked = [&](const char* name, const std::vector<std::string>& formats) {
    BakeOptions options;
    options.folder = folder / name;
    options.formats = formats;
    options.find_start = [&](const std::string& key) {
      const auto found = kept.find(key);
      return found == kept.end() ? std::nullopt : std::optional<std::string>(found->second);
    };
    options.keep_start = [&](const std::string& key, std::string_view bytes) { kept[key] = bytes; };
    const auto solver = cpu_reference::make_cpu_solver(bar.model, {}, 1);
    std::uint64_t frames = 0;
    CountingSolver counting(*solver, frames);
    bake(bar.scene, bar.model, counting, options);
    return frames;
  };
  EXPECT_GT(baked("first", {}), 12u + 6u);  // the clip's frames, the preroll's, and those of settling
  EXPECT_EQ(baked("second", {"pc2"}), 12u);
  EXPECT_EQ(read_text(folder / "second" / "frames.fascicle"),
            read_text(folder / "first" / "frames.fascicle"));
  auto stepped = manifest_in(folder / "first")["lead_in"], found = manifest_in(folder / "second")["lead_in"];
  EXPECT_EQ(stepped["was_kept"], false);
  EXPECT_EQ(found["was_kept"], true);
  found["was_kept"] = false;
  EXPECT_EQ(found, stepped);

  // Damaged bytes, and a start under another's name, are none.
  const std::map<std::string, std::string> good = kept;
  kept.begin()->second[kept.begin()->second.size() / 2] ^= 1;
  EXPECT_GT(baked("third", {}), 12u + 6u);
  bar.scene.motion.preroll = 0.2;
  kept = good;
  EXPECT_GT(baked("fourth", {}), 12u + 12u);
  EXPECT_EQ(kept.size(), 2u);
}

}  // namespace
}  // namespace fascicle::tests
