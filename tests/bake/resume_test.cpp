// A stopped bake resumes to the same bytes, and only if nothing that affects them has changed.
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/bake/checkpoint.h"
#include "host/bake/identity.h"
#include "host/bake/read_frame_cache.h"
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

TEST(BakeResume, StartsWhereThereIsNothing) {
  const TemporaryFolder folder;
  BakeOptions options = options_for(folder / "out");
  options.resume = true;
  EXPECT_EQ(fake_bake_into(options, short_scene(2)).frames_done, 2u);
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
  options.on_frame = [&](std::uint64_t frame, std::uint64_t) {
    if (frame != 4) return;
    ++looked;
    const nlohmann::json manifest = manifest_in(folder / "cut");
    EXPECT_EQ(manifest["frames_done"], 3);
    EXPECT_EQ(manifest["position_hashes"].size(), 4u);
    EXPECT_EQ(manifest["status"], "running");
  };
  EXPECT_EQ(fake_bake_into(options, short_scene(9)).frames_done, 9u);
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
