// Resuming a bake that is complete, or that has files which `fascicle export` added later.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "host/bake/export.h"
#include "host/bake/folder.h"
#include "host/bake/manifest.h"
#include "host/bake/verify.h"
#include "tests/bake/fake_bakes.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::BakeOptions;
using bake::BakeResult;

// A file that is written again, or renamed and renamed back, gets another number or another time of change.
std::map<std::string, std::pair<ino_t, long long>> marks_of(const fs::path& folder) {
  std::map<std::string, std::pair<ino_t, long long>> marks;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    struct stat status {};
    EXPECT_EQ(::lstat(entry.path().c_str(), &status), 0) << entry.path();
    const long long changed = 1'000'000'000LL * status.st_ctim.tv_sec + status.st_ctim.tv_nsec;
    marks[entry.path().lexically_relative(folder).string()] = {status.st_ino, changed};
  }
  return marks;
}

bool lists(const fs::path& folder, const std::string& name) {
  const std::vector<std::string> files = manifest_in(folder)["files"];
  return std::find(files.begin(), files.end(), name) != files.end();
}

TEST(BakeResume, ACompleteBakeIsNotTouched) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  const BakeResult whole = fake_bake_into(options, short_scene(4));
  const auto before = marks_of(folder / "out");
  options.resume = true;
  const BakeResult result = fake_bake_into(options, short_scene(4));
  EXPECT_EQ(marks_of(folder / "out"), before);
  EXPECT_FALSE(result.interrupted);
  EXPECT_EQ(result.frames_done, 4u);
  EXPECT_EQ(result.last_position_hash, whole.last_position_hash);
  EXPECT_EQ(result.files, whole.files);
  ASSERT_EQ(result.report.notes.size(), 1u);
  EXPECT_TRUE(contains(result.report.notes[0], "was complete"));

  // A bake with more frames is one that the comparison notices.
  fake_bake_into(options, short_scene(5));
  EXPECT_NE(marks_of(folder / "out"), before);
}

TEST(BakeResume, ACompleteBakeIsNotTouchedByASignal) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  const auto before = marks_of(folder / "out");
  const std::atomic<bool> interrupted{true};
  options.resume = true;
  options.interrupted = &interrupted;
  const BakeResult result = fake_bake_into(options, short_scene(4));
  EXPECT_FALSE(result.interrupted) << "nothing is left to resume";
  EXPECT_EQ(result.frames_done, 4u);
  EXPECT_EQ(marks_of(folder / "out"), before);
  EXPECT_EQ(manifest_in(folder / "out")["status"], "complete");
}

// A bake that stops between the final renames has some files under their final names.
TEST(BakeResume, TakesBackFinishedFiles) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  const auto whole = content_of(folder / "out");
  fs::rename(folder / "out/surface.pc2", folder / "out/surface.pc2.part");
  fs::remove(folder / "out/vtu/series.pvd");
  options.resume = true;
  fake_bake_into(options, short_scene(4));
  EXPECT_EQ(content_of(folder / "out"), whole);
}

TEST(BakeResume, KeepsWhatWasExported) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"obj"};
  fake_bake_into(options, short_scene(4));
  bake::export_bake({.bake = folder / "out", .formats = {"mdd"}});
  const std::string exported = read_text(folder / "out/surface.mdd");
  options.resume = true;
  options.formats = {"obj", "pc2"};
  fake_bake_into(options, short_scene(4));
  EXPECT_EQ(read_text(folder / "out/surface.mdd"), exported);
  EXPECT_TRUE(lists(folder / "out", "surface.mdd"));
  EXPECT_TRUE(lists(folder / "out", "surface.pc2"));

  // The same format asked of the bake itself is one file, and is listed once.
  options.formats = {"mdd", "obj", "pc2"};
  fake_bake_into(options, short_scene(4));
  EXPECT_EQ(read_text(folder / "out/surface.mdd"), exported);
  const std::vector<std::string> files = manifest_in(folder / "out")["files"];
  EXPECT_EQ(std::count(files.begin(), files.end(), "surface.mdd"), 1);
}

TEST(BakeResume, RemovesWhatWasExportedFromFewerFrames) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"pc2"};
  fake_bake_into(options, short_scene(4));
  bake::export_bake({.bake = folder / "out", .formats = {"mdd", "obj"}});
  write_text(folder / "out/mine.txt", "mine");
  options.resume = true;
  const BakeResult result = fake_bake_into(options, short_scene(6));
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_TRUE(contains(result.report.warnings[0], "(surface.mdd, obj/); export it again"));
  EXPECT_FALSE(fs::exists(folder / "out/surface.mdd"));
  EXPECT_FALSE(fs::exists(folder / "out/obj"));
  EXPECT_FALSE(lists(folder / "out", "surface.mdd"));
  EXPECT_TRUE(fs::exists(folder / "out/mine.txt"));
  EXPECT_TRUE(bake::verify_bake({.bake = folder / "out"}).is_good());
  EXPECT_EQ(bake::export_bake({.bake = folder / "out", .formats = {"mdd", "obj"}}).frames, 6u);
}

// The next bake mends the list, so that the folder is whole again.
TEST(BakeResume, ForgetsAnExportThatIsGone) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"pc2"};
  fake_bake_into(options, short_scene(4));
  bake::export_bake({.bake = folder / "out", .formats = {"mdd"}});
  fs::remove(folder / "out/surface.mdd");
  EXPECT_FALSE(bake::verify_bake({.bake = folder / "out"}).is_good());
  options.resume = true;
  fake_bake_into(options, short_scene(4));
  EXPECT_FALSE(lists(folder / "out", "surface.mdd"));
  EXPECT_TRUE(bake::verify_bake({.bake = folder / "out"}).is_good());
}

// Files for other programs have no checksums, but a complete bake has all of them.
TEST(BakeResume, OutputsThatAreNotWholeAreWrittenAgain) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  const auto whole = content_of(folder / "out");
  options.resume = true;
  for (const std::string name : {"surface.glb", "surface.usda", "vtu/series.pvd"})
    for (const bool is_empty : {false, true}) {
      fs::remove(folder / ("out/" + name));
      if (is_empty) write_text(folder / ("out/" + name), "");
      EXPECT_FALSE(bake::verify_bake({.bake = folder / "out"}).is_good()) << name;
      fake_bake_into(options, short_scene(4));
      EXPECT_EQ(content_of(folder / "out"), whole) << name;
    }
}

TEST(BakeResume, OutputsThatLostFramesAreWrittenAgain) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  const auto whole = content_of(folder / "out");
  options.resume = true;
  const auto expect_mended = [&](const std::string& name) {
    EXPECT_FALSE(bake::verify_bake({.bake = folder / "out"}).is_good()) << name;
    const BakeResult result = fake_bake_into(options, short_scene(4));
    EXPECT_EQ(content_of(folder / "out"), whole) << name;
    ASSERT_EQ(result.report.notes.size(), 1u) << name;
    EXPECT_TRUE(contains(result.report.notes[0], "written again from the frames"));
    EXPECT_TRUE(contains(result.report.notes[0], name));
  };
  for (const std::string name : {"surface.pc2", "surface.mdd"}) {
    fs::resize_file(folder / ("out/" + name), 100);
    expect_mended(name);
    fs::remove(folder / ("out/" + name));
    expect_mended(name);
  }
  fs::remove(folder / "out/obj/frame_000002.obj");
  expect_mended("frame_000002.obj");
  fs::resize_file(folder / "out/obj/frame_000003.obj", 0);
  expect_mended("frame_000003.obj");
}

// While a lost output is written again, the checkpoint says so: half of it is never taken for whole.
TEST(BakeResume, AnOutputThatIsWrittenAgainMayBeInterrupted) {
  const TemporaryFolder folder;
  fake_bake_into(options_for(folder / "whole"), short_scene(4));
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(4), 3);
  fs::remove(folder / "out/surface.pc2.part");
  const std::atomic<bool> interrupted{true};
  options.resume = true;
  options.interrupted = &interrupted;
  EXPECT_TRUE(fake_bake_into(options, short_scene(4)).interrupted);
  EXPECT_EQ(manifest_in(folder / "out")["status"], "interrupted");
  options.interrupted = nullptr;
  EXPECT_EQ(fake_bake_into(options, short_scene(4)).frames_done, 4u);
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "whole"));
}

// Frames, metrics and vtu cannot be made from the frames. Nothing else in the folder changes.
TEST(BakeResume, WhatCannotBeWrittenAgainIsMissed) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  options.resume = true;
  for (const std::string name : {"metrics.csv", "vtu/frame_000002.vtu", "frames.fascicle", "checkpoint"}) {
    fs::rename(folder / ("out/" + name), folder / "away");
    const auto before = marks_of(folder / "out");
    const std::string message = message_of<bake::BakeError>([&] { fake_bake_into(options, short_scene(4)); });
    EXPECT_TRUE(contains(message, name));
    EXPECT_EQ(marks_of(folder / "out"), before) << name;
    fs::rename(folder / "away", folder / ("out/" + name));
  }
  const auto expect_refused_unchanged = [&](const std::string& reason) {
    const auto before = marks_of(folder / "out");
    EXPECT_TRUE(
        contains(message_of<bake::BakeError>([&] { fake_bake_into(options, short_scene(4)); }), reason));
    EXPECT_EQ(marks_of(folder / "out"), before);
  };
  const std::string metrics = read_text(folder / "out/metrics.csv");
  write_text(folder / "out/metrics.csv", metrics.substr(0, metrics.rfind('\n', metrics.size() - 2) + 1));
  expect_refused_unchanged("holds fewer frames than the checkpoint");
  write_text(folder / "out/metrics.csv", metrics);
  std::string frames = read_text(folder / "out/frames.fascicle");
  frames[frames.size() / 2] = static_cast<char>(frames[frames.size() / 2] ^ 4);
  write_text(folder / "out/frames.fascicle", frames);
  expect_refused_unchanged("frame 2 is damaged");
}

// Overwriting removes the checkpoint first. Nothing is left to resume then, and the bake starts again.
TEST(BakeResume, AfterAnOverwritingThatWasInterruptedItStartsAgain) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  fake_bake_into(options, short_scene(4));
  const auto whole = content_of(folder / "out");
  fs::remove(folder / "out/surface.pc2");
  fs::create_directory(folder / "out/surface.pc2");
  EXPECT_THROW(bake::clear_bake(folder / "out"), bake::BakeError);
  fs::remove(folder / "out/surface.pc2");
  EXPECT_FALSE(fs::exists(folder / "out/checkpoint"));
  options.resume = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(4)).frames_done, 4u);
  EXPECT_EQ(content_of(folder / "out"), whole);
}

// Without its checkpoint nothing says what a bake was of.
TEST(BakeResume, ABakeWithoutItsCheckpointIsNotReplaced) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  scene::Scene other = short_scene(3);
  other.fps = 30.0;
  for (const bool is_complete : {true, false}) {
    fs::remove_all(folder / "out");
    options.resume = false;
    if (is_complete)
      fake_bake_into(options, short_scene(4));
    else
      bake_until(options, short_scene(4), 2);
    fs::remove(folder / "out/checkpoint");
    const auto before = marks_of(folder / "out");
    options.resume = true;
    for (const scene::Scene& scene : {short_scene(4), other})
      EXPECT_TRUE(contains(message_of<bake::BakeError>([&] { fake_bake_into(options, scene); }),
                           "checkpoint: the bake to resume has lost this file"));
    EXPECT_EQ(marks_of(folder / "out"), before);
  }
}

}  // namespace
}  // namespace fascicle::tests
