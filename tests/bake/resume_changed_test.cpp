// What may change before a stopped bake goes on: output, as if it had been asked for from the beginning, but
// nothing that affects the frames.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/identity.h"
#include "tests/bake/fake_bakes.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::bake;
using bake::BakeError;
using bake::BakeOptions;
using bake::BakeResult;

// A bake whose device failed goes on with its frames only where the next device makes the same bits.
TEST(Identity, OfDevicesIsTheSameForTheSameBits) {
  bake::DeviceDescription gpu, cpu;
  gpu.name = "A";
  gpu.driver = "1";
  cpu.name = "B";
  EXPECT_EQ(bake::identity_of(gpu), bake::identity_of(cpu));
  bake::DeviceDescription inexact = gpu, other = gpu, newer = gpu;
  inexact.exact = other.exact = newer.exact = false;
  other.name = "C";
  newer.driver = "2";
  EXPECT_EQ(bake::identity_of(inexact), bake::identity_of(bake::DeviceDescription(inexact)));
  for (const bake::DeviceDescription& device : {gpu, cpu, other, newer})
    EXPECT_NE(bake::identity_of(inexact), bake::identity_of(device));
}

// A stranger's checkpoint may hold any text.
TEST(Identity, OfFilesIsShownInOneLine) {
  const bake::Identity now{{"scene", "a"}};
  const bake::Identity before{{"scene", "b\n\x1b[2J"}, {std::string(200, 'n') + "\n", ""}};
  const std::string text = bake::text_of(bake::differences(before, now));
  EXPECT_NE(text.find("scene was b"), std::string::npos) << text;
  EXPECT_TRUE(std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < ' '; })) << text;
  EXPECT_LT(text.size(), 400U) << text;
}

// It may also hold as many entries as it likes.
TEST(Identity, OfFilesWithManyEntriesIsShownInPart) {
  bake::Identity before;
  const std::string dots(1000, '.');
  for (int k = 0; k < 100000; ++k) before.emplace_back("the key k" + std::to_string(k) + dots, "1");
  const std::string text = bake::text_of(bake::differences(before, {{"model", "2"}, {"device", "exact"}}));
  EXPECT_TRUE(contains(text, "device was absent and is exact")) << text;
  EXPECT_FALSE(contains(text, "model")) << "follows from the keys";
  EXPECT_TRUE(contains(text, "; and 99981 more")) << text;
  EXPECT_LT(text.size(), 10000U) << text;
}

TEST(BakeResume, RefusesOtherSettingsAndNamesThem) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  bake_until(options, short_scene(6), 3);
  options.resume = true;
  const auto refusal = [&](const scene::Scene& scene, const BakeOptions& changed) {
    return message_of<BakeError>([&] { fake_bake_into(changed, scene); });
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
  scene = short_scene(6);
  scene.input_hashes.emplace_back("other/body.mesh", "ffffffffffffffff");
  EXPECT_TRUE(contains(refusal(scene, options), "the content of body.mesh (2) was absent"))
      << "a file of the same name in another folder";
  BakeOptions changed = options;
  changed.formats = {"pc2"};
  EXPECT_TRUE(
      contains(refusal(short_scene(6), changed), "--format was abc,glb,mdd,obj,pc2,usda,vtp,vtu and is pc2"));
  BakeOptions without = options_for(folder / "without");
  without.formats = {"obj"};
  bake_until(without, short_scene(6), 3);
  without.formats = {"obj", "vtu"};
  without.resume = true;
  EXPECT_TRUE(contains(refusal(short_scene(6), without), "--format was obj and is obj,vtp,vtu"))
      << "its velocities were not kept";
  changed = options;
  changed.first_number = 7;
  EXPECT_TRUE(contains(refusal(short_scene(6), changed), "--first-frame was absent and is 7"));
  scene = short_scene(6);
  scene.motion.hold = 0.1;
  EXPECT_TRUE(contains(refusal(scene, options), "motion was "));
  EXPECT_TRUE(contains(refusal(short_scene(2), options), "end was 0.75 and is 0.58"))
      << "the end is before frames already done";
  changed = options;
  changed.device.exact = false;
  EXPECT_TRUE(contains(refusal(short_scene(6), changed), "device was exact and is fake, none"));
  // Another exact device gives the same bits.
  changed = options;
  changed.device.name = "another";
  EXPECT_EQ(fake_bake_into(changed, short_scene(6)).frames_done, 6u);
}

// As long as frames stay the same, output may change: the result is as if the final settings had been used
// from the start.
struct Changed {
  const char* name;
  std::uint64_t stopped_at, frames_before, frames;
  std::vector<std::string> formats_before;
  std::uint64_t stride = 1;
  std::vector<std::string> formats = {};  // for both bakes; empty: all
};

// Leaves the folder as after a kill between the checkpoint that lists new files and the first of these files.
// A folder with the name of a file makes the bake fail there.
void killed_before_files(const BakeOptions& options, const scene::Scene& scene) {
  const fs::path model_file = options.folder / "model.fascicle";
  const fs::path aside = options.folder / "aside";
  fs::rename(model_file, aside);
  fs::create_directory(model_file);
  EXPECT_ANY_THROW(fake_bake_into(options, scene));
  fs::remove(model_file);
  fs::rename(aside, model_file);
}

class BakeResumeChanged : public testing::TestWithParam<Changed> {};

TEST_P(BakeResumeChanged, GivesTheBytesOfABakeAskedForSoFromTheBeginning) {
  const Changed& change = GetParam();
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "whole"), before = options_for(folder / "out");
  if (!change.formats.empty()) options.formats = before.formats = change.formats;
  options.glb.stride = change.stride;
  fake_bake_into(options, short_scene(change.frames));
  if (!change.formats_before.empty()) before.formats = change.formats_before;
  bake_until(before, short_scene(change.frames_before), change.stopped_at);
  options.folder = folder / "out";
  options.resume = true;
  // Killed before the new files are started, then stopped afterwards.
  killed_before_files(options, short_scene(change.frames));
  bake_until(options, short_scene(change.frames), std::min(change.stopped_at, change.frames));
  const BakeResult result = fake_bake_into(options, short_scene(change.frames));
  EXPECT_EQ(result.frames_done, change.frames);
  EXPECT_EQ(content_of(folder / "out"), content_of(folder / "whole"));
  const auto manifest = manifest_in(folder / "out"), whole = manifest_in(folder / "whole");
  for (const char* entry : {"status", "frames", "frames_done", "files", "formats", "position_hashes"})
    EXPECT_EQ(manifest[entry], whole[entry]) << entry;
}

INSTANTIATE_TEST_SUITE_P(Changes, BakeResumeChanged,
                         testing::Values(Changed{"ALaterEnd", 3, 6, 9, {}},
                                         Changed{"ALaterEndOfAWholeBake", 6, 6, 9, {}},
                                         Changed{"AnEarlierEnd", 3, 9, 6, {}},
                                         Changed{"AnEarlierEndWhereItStopped", 6, 9, 6, {}},
                                         Changed{"MoreFormats", 4, 6, 6, {"pc2", "obj", "vtu"}},
                                         Changed{"MoreFormatsOfAWholeBake", 6, 6, 6, {"pc2", "vtu"}},
                                         Changed{"AnotherGlb", 4, 6, 6, {}, 2},
                                         Changed{"NoFormatToBeginAnew", 3, 6, 9, {}, 1, {"vtu"}},
                                         Changed{"All", 5, 6, 8, {"mdd", "vtu"}, 3}),
                         [](const auto& change) { return std::string(change.param.name); });

TEST(BakeResume, TakesOtherCommentsAndRefusesOtherKeys) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  const std::string text = "[scene]\nfps = 24\n[bar]\nsize = [1.0, 1.0, 1.0]\n";
  scene::Scene scene = short_scene(6);
  scene.text = text;
  bake_until(options, scene, 3);
  options.resume = true;
  scene.text = "# what I saw of it\n" + text + "# and more\n";
  bake_until(options, scene, 4);
  scene.text = text + "jitter = 0.1\n";
  EXPECT_TRUE(contains(message_of<BakeError>([&] { fake_bake_into(options, scene); }),
                       "the key bar.jitter was absent and is 0.1;"));
  // Consequences of a key are not listed again, and long values are shortened.
  std::string many = "1.0";
  for (int k = 0; k < 99; ++k) many += ", 1.0";
  scene.text = "[scene]\nfps = 30\n[bar]\nsize = [1.0, 1.0, " + many + "]\n";
  scene.fps = 30.0;
  const std::string message = message_of<BakeError>([&] { fake_bake_into(options, scene); });
  EXPECT_TRUE(contains(message, "the key scene.fps was 24 and is 30")) << message;
  EXPECT_FALSE(contains(message, "; fps was")) << message;
  EXPECT_TRUE(contains(message, "the key bar.size was [1.0, 1.0, 1.0] and is [1.0, 1.0, 1.0, ")) << message;
  EXPECT_LT(message.size(), 600u) << message;
}

// Until the new files are complete, no format can be dropped.
TEST(BakeResume, FormatsThatAreBegunAnewCannotBeLeftOut) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"obj"};
  bake_until(options, short_scene(6), 3);
  options.resume = true;
  options.formats = {"obj", "pc2"};
  killed_before_files(options, short_scene(6));
  options.formats = {"obj"};
  EXPECT_TRUE(contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }),
                       "--format was obj,pc2 and is obj"));
}

// This includes a scene without an end, which takes the clip's.
TEST(BakeResume, AnEndMayBeStatedWhereNoneWas) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  scene::Scene scene = short_scene(6);
  scene.text = "[scene]\nfps = 24\n";
  bake_until(options, scene, 3);
  options.resume = true;
  scene.text = "[scene]\nfps = 24\nend = 0.75\n";
  EXPECT_EQ(fake_bake_into(options, scene).frames_done, 6u);
}

// A muscle's hinge is where the motion bends most, so it depends on the end.
TEST(BakeResume, TheEndOfABodyWithMusclesStays) {
  scene::Scene scene = short_scene(6);
  const bake::Difference end{"end", "0.75", "1"};
  EXPECT_TRUE(leaves_frames(end, scene, 3));
  scene.muscles.emplace_back();
  EXPECT_FALSE(leaves_frames(end, scene, 3));
}

// A file's hash does not say what another version of the converter reads from it.
TEST(BakeResume, ConvertedMotionBelongsToTheIdentity) {
  scene::Scene scene = short_scene(6);
  rig::Character character;
  character.skeleton.emplace_back().name = "hip";
  character.clips.push_back({.name = "walk",
                             .duration = 1.0,
                             .channels = {{.joint = 0, .times = {0.0, 1.0}, .values = {0, 0, 0, 1, 0, 0}}}});
  scene.geometry = character;
  const auto changed = [&](const char* file, const auto& change) {
    scene.input_hashes = {{file, "0123456789abcdef"}};
    scene::Scene other = scene;
    change(std::get<rig::Character>(other.geometry));
    const BakeOptions options = options_for("out");
    std::string names;
    for (const bake::Difference& one :
         bake::differences(bake::identity_of(scene, 1, options), bake::identity_of(other, 1, options)))
      names += one.name + ";";
    return names;
  };
  const auto key = [](rig::Character& of) { of.clips[0].channels[0].values[3] = 2.0; };
  const auto rest = [](rig::Character& of) { of.skeleton[0].rest_local(0, 3) = 1.0; };
  EXPECT_EQ(changed("man.fbx", [](rig::Character&) {}), "");
  EXPECT_EQ(changed("man.fbx", key), "the converted motion;");
  EXPECT_EQ(changed("man.fbx", rest), "the converted motion;");
  EXPECT_EQ(changed("man.glb", key), "") << "here the hash of the file says it";
}

// A file that no bake made is never overwritten, whenever its format is added.
TEST(BakeResume, MoreFormatsRefuseForeignFiles) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"obj"};
  bake_until(options, short_scene(6), 3);
  write_text(folder / "out/surface.pc2", "mine");
  options.resume = true;
  options.formats = {"obj", "pc2"};
  EXPECT_TRUE(
      contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }), "no bake made it"));
  EXPECT_EQ(read_text(folder / "out/surface.pc2"), "mine");
}

// What would be refused is refused before the earlier bake is removed.
TEST(BakeResume, OverwritingRefusesForeignFilesFirst) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.formats = {"obj"};
  fake_bake_into(options, short_scene(6));
  options.overwrite = true;
  options.formats = {"obj", "pc2"};
  write_text(folder / "out/surface.pc2", "mine");
  auto before = content_of(folder / "out");
  EXPECT_TRUE(
      contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }), "no bake made it"));
  EXPECT_EQ(content_of(folder / "out"), before);
  fs::remove(folder / "out/surface.pc2");
  fs::remove(folder / "out/metrics.csv");
  fs::create_directory(folder / "out/metrics.csv");
  before = content_of(folder / "out");
  EXPECT_TRUE(
      contains(message_of<BakeError>([&] { fake_bake_into(options, short_scene(6)); }), "is a folder"));
  EXPECT_EQ(content_of(folder / "out"), before);
  fs::remove(folder / "out/metrics.csv");
  EXPECT_EQ(fake_bake_into(options, short_scene(6)).frames_done, 6u);
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

}  // namespace
}  // namespace fascicle::tests
