// Bakes without frames or without formats: what is left, what can be resumed, and what is refused.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/export.h"
#include "host/bake/manifest.h"
#include "host/bake/options.h"
#include "host/bake/outputs.h"
#include "host/bake/sealed_json.h"
#include "tests/bake/fake_bakes.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::BakeError;
using bake::BakeOptions;
using bake::BakeResult;

BakeOptions without_frames(const fs::path& folder) {
  BakeOptions options = options_for(folder);
  options.keep_frames = false;
  return options;
}

// A folder's content without the frames and the manifest.
std::vector<std::pair<std::string, std::string>> other_content(const fs::path& folder) {
  auto files = content_of(folder);
  std::erase_if(files, [](const auto& file) {
    return file.first == "frames.fascicle" || file.first == "manifest.json";
  });
  return files;
}

TEST(BakeKeepFrames, FalseLeavesTheSameFormatsAndNoFrames) {
  const TemporaryFolder folder;
  const BakeResult kept = fake_bake_into(options_for(folder / "kept"), short_scene(6));
  const BakeResult result = fake_bake_into(without_frames(folder / "out"), short_scene(6));
  EXPECT_EQ(result.frames_done, 6u);
  EXPECT_EQ(result.last_position_hash, kept.last_position_hash);
  EXPECT_EQ(result.files.size() + 1, kept.files.size());
  EXPECT_FALSE(fs::exists(folder / "out/frames.fascicle"));
  EXPECT_EQ(other_content(folder / "out"), other_content(folder / "kept"));
  nlohmann::json manifest = manifest_in(folder / "out"), whole = manifest_in(folder / "kept");
  EXPECT_EQ(manifest["frames_kept"], false);
  EXPECT_FALSE(whole.contains("frames_kept")) << "manifests of other bakes do not have the key";
  EXPECT_EQ(std::count(manifest["files"].begin(), manifest["files"].end(), "frames.fascicle"), 0);
  EXPECT_EQ(std::count(whole["files"].begin(), whole["files"].end(), "frames.fascicle"), 1);
  for (nlohmann::json* json : {&manifest, &whole})
    for (const char* key : {"checksum", "files", "frames_kept", "timings"}) json->erase(key);
  EXPECT_EQ(manifest, whole);
}

TEST(BakeKeepFrames, FalseResumesToTheSameBytes) {
  const TemporaryFolder folder;
  fake_bake_into(without_frames(folder / "whole"), short_scene(6));
  for (const std::uint64_t last : {0u, 3u}) {
    const fs::path out = folder / ("cut" + std::to_string(last));
    EXPECT_TRUE(bake_until(without_frames(out), short_scene(6), last).interrupted);
    EXPECT_TRUE(fs::exists(out / "frames.fascicle")) << "an incomplete bake needs them to resume";
    EXPECT_FALSE(manifest_in(out).contains("frames_kept"));
    BakeOptions options = without_frames(out);
    options.resume = true;
    EXPECT_EQ(fake_bake_into(options, short_scene(6)).frames_done, 6u);
    EXPECT_EQ(content_of(out), content_of(folder / "whole"));
  }
}

// The option may change until the bake is complete; then it is too late to keep frames.
TEST(BakeKeepFrames, MayChangeWhileItIsNotComplete) {
  const TemporaryFolder folder;
  bake_until(without_frames(folder / "out"), short_scene(6), 3);
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  fake_bake_into(options, short_scene(6));
  fake_bake_into(options_for(folder / "kept"), short_scene(6));
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "kept"));
  options.keep_frames = false;
  fake_bake_into(options, short_scene(6));
  EXPECT_FALSE(fs::exists(folder / "out/frames.fascicle"));
  const auto before = content_of(folder / "out");
  options.keep_frames = true;
  EXPECT_TRUE(
      contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }),
               "frames of this bake were not kept (--keep-frames false); bake again with --overwrite"));
  EXPECT_EQ(content_of(folder / "out"), before);
}

TEST(BakeKeepFrames, ACompleteBakeHasNothingLeftToDo) {
  const TemporaryFolder folder;
  const BakeResult first = fake_bake_into(without_frames(folder / "out"), short_scene(6));
  const auto before = content_of(folder / "out");
  // A stop between writing the manifest and the end leaves the frames.
  write_text(folder / "out/frames.fascicle", "left over");
  BakeOptions options = without_frames(folder / "out");
  options.resume = true;
  const BakeResult again = fake_bake_into(options, short_scene(6));
  EXPECT_EQ(again.frames_done, 6u);
  EXPECT_EQ(again.last_position_hash, first.last_position_hash);
  EXPECT_EQ(again.files, first.files);
  EXPECT_EQ(content_of(folder / "out"), before);
  scene::Scene other = short_scene(6);
  other.fps = 30.0;
  EXPECT_TRUE(contains(message_of<BakeError>([&] { fake_bake_into(options, other); }), "fps was 24"));
  options.resume = false;
  EXPECT_THROW(fake_bake_into(options, short_scene(6)), bake::FolderInUse);
  options.overwrite = true;
  fake_bake_into(options, short_scene(6));
  EXPECT_EQ(content_of(folder / "out"), before);
}

TEST(BakeKeepFrames, ACompleteBakeThatLostAFileIsNotDone) {
  const TemporaryFolder folder;
  BakeOptions options = without_frames(folder / "out");
  for (const char* name : {"surface.pc2", "metrics.csv"}) {
    options.resume = false;
    options.overwrite = true;
    fake_bake_into(options, short_scene(6));
    fs::remove(folder / (std::string("out/") + name));
    options.overwrite = false;
    options.resume = true;
    EXPECT_TRUE(contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }),
                         "bake again with --overwrite"))
        << name;
  }
}

// One that stopped just before it removed its frames still has them, and what is lost is made from them.
TEST(BakeKeepFrames, FramesThatAreLeftMendWhatIsLost) {
  const TemporaryFolder folder;
  fake_bake_into(without_frames(folder / "whole"), short_scene(6));
  fake_bake_into(options_for(folder / "out"), short_scene(6));
  nlohmann::json manifest = manifest_in(folder / "out");
  manifest["frames_kept"] = false;
  auto& files = manifest["files"].get_ref<nlohmann::json::array_t&>();
  std::erase(files, nlohmann::json("frames.fascicle"));
  write_text(folder / "out/manifest.json", bake::sealed_text(manifest));
  fs::remove(folder / "out/surface.pc2");
  BakeOptions options = without_frames(folder / "out");
  options.resume = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(6)).frames_done, 6u);
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "whole"));
}

TEST(BakeKeepFrames, ExportSaysThatThereAreNone) {
  const TemporaryFolder folder;
  fake_bake_into(without_frames(folder / "out"), short_scene(3));
  const auto before = content_of(folder / "out");
  const std::string message = message_of<BakeError>(
      [&] { bake::export_bake({.bake = folder / "out", .folder = {}, .formats = {"mdd"}}); });
  EXPECT_TRUE(contains(message, "were not kept (--keep-frames false); bake again with --overwrite"));
  EXPECT_EQ(content_of(folder / "out"), before);
}

TEST(BakeNoFormat, IsFramesAndMetricsAlone) {
  const TemporaryFolder folder;
  BakeOptions none = options_for(folder / "none"), empty = options_for(folder / "empty");
  none.formats = {"none"};
  empty.formats = {};
  fake_bake_into(none, short_scene(3));
  fake_bake_into(empty, short_scene(3));
  EXPECT_EQ(content_of(folder / "none"), content_of(folder / "empty"));
  EXPECT_TRUE(manifest_in(folder / "none")["formats"].empty());
  EXPECT_TRUE(fs::exists(folder / "none/frames.fascicle"));
  // Either can resume the other.
  none.resume = true;
  none.folder = folder / "empty";
  EXPECT_EQ(fake_bake_into(none, short_scene(3)).frames_done, 3u);
}

TEST(BakeNoFormat, AndNoFramesIsTheMetricsAloneWhereThatIsSaid) {
  const TemporaryFolder folder;
  BakeOptions options = without_frames(folder / "out");
  options.formats = {};
  EXPECT_TRUE(
      contains(message_of<bake::ContradictingOptions>([&] { fake_bake_into(options, short_scene(3)); }),
               "would leave no motion"));
  EXPECT_FALSE(fs::exists(folder / "out"));
  options.formats = {"none"};
  fake_bake_into(options, short_scene(3));
  BakeOptions kept = options_for(folder / "kept");
  kept.formats = {};
  fake_bake_into(kept, short_scene(3));
  EXPECT_EQ(read_text(folder / "out/metrics.csv"), read_text(folder / "kept/metrics.csv"));
  EXPECT_FALSE(fs::exists(folder / "out/frames.fascicle"));
}

TEST(BakeNoFormat, HasNoneBesideIt) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"pc2", "none"};
  EXPECT_TRUE(
      contains(message_of<bake::ContradictingOptions>([&] { fake_bake_into(options, short_scene(3)); }),
               "--format none and --format pc2 exclude each other"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace fascicle::tests
