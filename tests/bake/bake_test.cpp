// The frame loop: pipelining, what is refused, and what remains when a bake ends early.
#include "host/bake/bake.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/checkpoint.h"
#include "host/bake/export.h"
#include "host/bake/outputs.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/sealed_json.h"
#include "host/model/validate.h"
#include "tests/bake/fake_bakes.h"
#include "tests/drive/bending_bar.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::bake;
using bake::BakeError;
using bake::BakeOptions;
using bake::BakeResult;

TEST(Bake, WritesEveryFileAndDescribesIt) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.warnings = {"two seams were welded"};
  std::vector<std::uint64_t> shown;
  options.on_frame = [&](std::uint64_t frame, std::uint64_t frames) {
    EXPECT_EQ(frames, 7u);
    shown.push_back(frame);
  };
  const BakeResult result = fake_bake_into(options, short_scene(7));
  EXPECT_EQ(shown, (std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(result.frames_done, 7u);
  EXPECT_FALSE(result.interrupted);
  // Manifest, checkpoint, model, rest mesh, script, frame cache, metrics, and one per format.
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
  const nlohmann::json& layers = manifest["model"]["layers"];
  EXPECT_EQ(layers[0]["mass"], 10.0);
  EXPECT_EQ(layers[0]["vertices"], 4);
  EXPECT_EQ(layers[1]["mass"], 5.0);
  EXPECT_EQ(layers[1]["vertices"], 1);
  EXPECT_EQ(manifest["warnings"][0], "two seams were welded");
  EXPECT_EQ(manifest["position_hashes"].size(), 8u);
  EXPECT_EQ(manifest["position_hashes"].back(), result.last_position_hash);
  EXPECT_GE(manifest["timings"]["total_seconds"], 0.0);
}

TEST(Bake, HashesArePositionHashes) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "out"), short_scene(3));
  const bake::FrameCacheReader cache(folder / "out/frames.fascicle");
  ASSERT_EQ(cache.frame_count(), 4u);
  const nlohmann::json hashes = manifest_in(folder / "out")["position_hashes"];
  for (std::uint64_t k = 0; k < 4; ++k)
    EXPECT_EQ(std::stoull(hashes[k].get<std::string>(), nullptr, 16), model::position_hash(cache.read(k)));
  // If the frames did not differ, equal hashes would prove nothing.
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
  EXPECT_EQ(fake_bake_into(options_for(folder / "out"), short_scene(0)).frames_done, 0u);
  EXPECT_EQ(bake::FrameCacheReader(folder / "out/frames.fascicle").frame_count(), 1u);
  EXPECT_EQ(manifest_in(folder / "out")["status"], "complete");
}

// The timing of checkpoints must not change a byte.
TEST(Bake, CheckpointsChangeNothing) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "rare"), short_scene(9));
  BakeOptions often = options_for(folder / "often");
  often.checkpoint_frames = 1;
  fake_bake_into(often, short_scene(9));
  EXPECT_EQ(content_of(folder / "rare"), content_of(folder / "often"));
}

TEST(BakeNotFinite, NamesFrameAndVertexAndKeepsWhatWasBefore) {
  const TemporaryFolder folder;
  const BakeOptions options = options_for(folder / "out");
  const std::string message = message_of<bake::NotFinite>([&] {
    fake_bake_into(options, short_scene(9), {.not_finite_at = 5, .microseconds = 0, .on_submit = {}});
  });
  // Model vertices 1 and 2 are 4 and 0 in the source.
  EXPECT_TRUE(contains(message, "frame 5"));
  EXPECT_TRUE(contains(message, "vertex 0 of layer fat"));
  EXPECT_TRUE(contains(message, "vertices affected: 2"));
  EXPECT_TRUE(contains(message, "substeps"));
  const nlohmann::json manifest = manifest_in(folder / "out");
  EXPECT_EQ(manifest["status"], "not-finite");
  EXPECT_EQ(manifest["frames_done"], 4);
  EXPECT_EQ(manifest["message"], message);
  const bake::FrameCacheReader cache(folder / "out/frames.fascicle");
  ASSERT_EQ(cache.frame_count(), 5u);
  EXPECT_EQ(cache.read(4).index, 4u);
  EXPECT_TRUE(bake::read_checkpoint(folder / "out/checkpoint").has_value());
  // What the manifest counts is synced, and so has its final name.
  EXPECT_TRUE(fs::exists(folder / "out/obj/frame_000004.obj"));
  EXPECT_FALSE(fs::exists(folder / "out/obj/frame_000004.obj.tmp"));
}

TEST(BakeFolder, IsRefusedWhileItHoldsABake) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(2));
  const auto before = content_of(folder / "out");
  const std::string message = message_of<bake::FolderInUse>([&] { fake_bake_into(options, short_scene(3)); });
  EXPECT_TRUE(contains(message, "--resume"));
  EXPECT_TRUE(contains(message, "--overwrite"));
  EXPECT_EQ(content_of(folder / "out"), before);
  // Even if only the cache is left.
  fs::remove(folder / "out/manifest.json");
  EXPECT_THROW(fake_bake_into(options, short_scene(3)), bake::FolderInUse);
}

TEST(BakeFolder, OverwriteRemovesOnlyWhatABakeMade) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(9));
  for (const char* name : {"out/notes.txt", "out/vtu/mine.vtu", "out/vtu/frame_1.vtu", "out/metrics.csv.bak"})
    write_text(folder / name, "precious");
  // A manifest that lists files no bake makes, inside and outside the folder.
  write_text(folder / "outside", "precious");
  nlohmann::json manifest = manifest_in(folder / "out");
  manifest["files"].push_back("notes.txt");
  manifest["files"].push_back("../outside");
  manifest["files"].push_back("../");
  write_text(folder / "out/manifest.json", bake::sealed_text(manifest));
  options.overwrite = true;
  options.formats = {};
  fake_bake_into(options, short_scene(2));
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
  fake_bake_into(options, short_scene(4));
  fake_bake_into(options_for(folder / "fresh"), short_scene(4));
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "fresh"));
}

TEST(BakeFolder, ForeignFilesStayAndAreNotOverwritten) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "out");
  write_text(folder / "out/notes.txt", "precious");
  EXPECT_EQ(fake_bake_into(options_for(folder / "out"), short_scene(2)).frames_done, 2u);
  EXPECT_EQ(read_text(folder / "out/notes.txt"), "precious");
  for (const char* name : {"manifest.json", "metrics.csv", "surface.pc2", "rest.obj", "frames.fascicle",
                           "checkpoint", "model.fascicle", "surface.mdd", "surface.abc", "surface.usda",
                           "surface.usda.samples.part", "surface.glb", "import_blender.py"}) {
    const fs::path other = folder / (std::string("other_") + name);
    fs::create_directories(other);
    write_text(other / name, "{\"precious\": true}");
    for (const bool overwrite : {false, true}) {
      BakeOptions options = options_for(other);
      options.overwrite = overwrite;
      EXPECT_TRUE(contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(2)); }), name));
      EXPECT_EQ(read_text(other / name), "{\"precious\": true}");
    }
  }
}

TEST(BakeFolder, ThatCannotBeWrittenIsNamed) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  EXPECT_TRUE(contains(
      message_of<BakeError>([&] { fake_bake_into(options_for(folder / "file"), short_scene(2)); }), "file"));
  EXPECT_TRUE(contains(message_of<std::system_error>(
                           [&] { fake_bake_into(options_for(folder / "file/below"), short_scene(2)); }),
                       "file"));
  EXPECT_TRUE(contains(
      message_of<std::system_error>([&] { fake_bake_into(options_for("/proc/fascicle"), short_scene(2)); }),
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
    message = message_of<BakeError>([&] { fake_bake_into(second, short_scene(2)); });
  };
  EXPECT_EQ(fake_bake_into(options, short_scene(4)).frames_done, 4u);
  EXPECT_TRUE(contains(message, "another fascicle is writing there"));
}

// A limit on file size simulates a full disk: with both, write() comes up short.
TEST(BakeFolder, AFullDiskLeavesWholeFramesAndCanBeResumed) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "whole"), short_scene(120));
  const auto whole = content_of(folder / "whole");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    // Room for a vtu file, the manifest and about 18 frames, but not for all 120.
    const rlimit limit{8000, 8000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    BakeOptions options = options_for(folder / "out");
    options.checkpoint_frames = 10;
    const std::string message =
        message_of<std::system_error>([&] { fake_bake_into(options, short_scene(120)); });
    const bool named = contains(message, "/out/") && contains(message, "File too large");
    if (!named) std::fprintf(stderr, "child: %s\n", message.c_str());
    ::_exit(named ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(bake::FrameCacheReader(folder / "out/frames.fascicle").frame_count(), 10u);
  EXPECT_FALSE(fs::exists(folder / "out/surface.pc2"));
  EXPECT_EQ(manifest_in(folder / "out")["status"], "failed");
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  fake_bake_into(options, short_scene(120));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

// Even if the disk has no room for a second manifest next to the first.
TEST(BakeFailed, SaysSoOnADiskThatIsFull) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "whole"), short_scene(120));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    BakeOptions options = options_for(folder / "out");
    options.checkpoint_frames = 60;
    options.checkpoint_seconds = 1e9;
    options.on_frame = [&](std::uint64_t frame, std::uint64_t) {
      if (frame != 100) return;
      // The manifest of 61 frames just fits, and the cache of 100 frames is already larger.
      const rlim_t size = fs::file_size(folder / "out/manifest.json");
      const rlimit limit{size, size};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    };
    const std::string message =
        message_of<std::system_error>([&] { fake_bake_into(options, short_scene(120)); });
    ::_exit(contains(message, "File too large") ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  const nlohmann::json manifest = manifest_in(folder / "out");
  EXPECT_EQ(manifest["status"], "failed");
  EXPECT_TRUE(contains(manifest["message"].get<std::string>(), "File too large"));
  EXPECT_EQ(manifest["frames_done"], 60);
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  fake_bake_into(options, short_scene(120));
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "whole"));
}

void expect_failed_and_resumed(const TemporaryFolder& folder, const std::string& reason,
                               const std::function<void()>& mend) {
  const nlohmann::json manifest = manifest_in(folder / "out");
  EXPECT_EQ(manifest["status"], "failed");
  EXPECT_TRUE(contains(manifest["message"].get<std::string>(), reason));
  EXPECT_EQ(manifest["frames_done"], 4);
  EXPECT_EQ(manifest["position_hashes"].size(), 5u);
  const std::string refusal = message_of<BakeError>([&] {
    bake::export_bake({.bake = folder / "out", .folder = folder / "exported", .formats = {"mdd"}});
  });
  EXPECT_TRUE(contains(refusal, reason));
  EXPECT_TRUE(contains(refusal, "--resume"));
  mend();
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(9)).frames_done, 9u);
  fake_bake_into(options_for(folder / "whole"), short_scene(9));
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "whole"));
}

BakeOptions with_checkpoint_at_4(const fs::path& folder) {
  BakeOptions options = options_for(folder);
  options.checkpoint_frames = 4;
  options.checkpoint_seconds = 1e9;
  return options;
}

TEST(BakeFailed, SaysThatTheDeviceWasLost) {
  const TemporaryFolder folder;
  FakeOptions fake;
  fake.on_submit = [&](std::uint64_t frame) {
    if (frame == 1) {
      EXPECT_EQ(manifest_in(folder / "out")["status"], "running");
    }
    if (frame == 7) throw std::runtime_error("vkQueueSubmit: VK_ERROR_DEVICE_LOST");
  };
  const std::string message = message_of<std::runtime_error>(
      [&] { fake_bake_into(with_checkpoint_at_4(folder / "out"), short_scene(9), fake); });
  EXPECT_EQ(message, "vkQueueSubmit: VK_ERROR_DEVICE_LOST");
  expect_failed_and_resumed(folder, message, [] {});
}

TEST(BakeFailed, SaysWhatASinkCouldNotWrite) {
  const TemporaryFolder folder;
  BakeOptions options = with_checkpoint_at_4(folder / "out");
  const fs::path in_the_way = folder / "out/obj/frame_000006.obj";
  options.on_frame = [&](std::uint64_t frame, std::uint64_t) {
    if (frame == 2) fs::create_directories(in_the_way / "full");
  };
  const std::string message = message_of<std::system_error>([&] { fake_bake_into(options, short_scene(9)); });
  EXPECT_TRUE(contains(message, "frame_000006.obj"));
  expect_failed_and_resumed(folder, message, [&] { fs::remove_all(in_the_way); });
}

TEST(BakeFailed, AResumedBakeSaysSoToo) {
  const TemporaryFolder folder;
  bake_until(with_checkpoint_at_4(folder / "out"), short_scene(9), 4);
  BakeOptions options = with_checkpoint_at_4(folder / "out");
  options.resume = true;
  FakeOptions fake;
  fake.on_submit = [](std::uint64_t) { throw std::runtime_error("vkQueueSubmit: VK_ERROR_DEVICE_LOST"); };
  const std::string message =
      message_of<std::runtime_error>([&] { fake_bake_into(options, short_scene(9), fake); });
  EXPECT_EQ(message, "vkQueueSubmit: VK_ERROR_DEVICE_LOST");
  expect_failed_and_resumed(folder, message, [] {});
}

// The manifest of a different bake is not touched.
TEST(BakeFailed, LeavesOthersManifestsAlone) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "out"), short_scene(2));
  const auto before = content_of(folder / "out");
  EXPECT_THROW(fake_bake_into(options_for(folder / "out"), short_scene(3)), bake::FolderInUse);
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  scene::Scene other = short_scene(2);
  other.solver.substeps = 3;
  EXPECT_THROW(fake_bake_into(options, other), BakeError);
  EXPECT_EQ(content_of(folder / "out"), before);
}

TEST(BakeOptions, AreChecked) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"pc2", "fbx"};
  const std::string message = message_of<BakeError>([&] { fake_bake_into(options, short_scene(2)); });
  EXPECT_TRUE(contains(message, "--format fbx"));
  EXPECT_TRUE(contains(message, "pc2, usda, vtp, vtu"));
  EXPECT_FALSE(fs::exists(folder / "out"));
  options = options_for(folder / "out");
  options.resume = options.overwrite = true;
  EXPECT_THROW(fake_bake_into(options, short_scene(2)), BakeError);
}

TEST(BakeOptions, OutputBytesIsCloseToWhatIsWritten) {
  const TemporaryFolder folder;
  const scene::Scene scene = short_scene(50);
  fake_bake_into(options_for(folder / "out"), scene);
  std::uint64_t written = 0;
  for (const auto& item : fs::recursive_directory_iterator(folder / "out"))
    if (item.is_regular_file()) written += item.file_size();
  const std::uint64_t estimate = bake::output_bytes(scene, two_tetrahedra(), bake::format_names());
  // Lengths of text are guessed. They are most of this tiny body but little of a real one.
  EXPECT_GT(static_cast<double>(estimate), 0.8 * static_cast<double>(written));
  EXPECT_LT(static_cast<double>(estimate), 1.25 * static_cast<double>(written));
}

}  // namespace
}  // namespace fascicle::tests
