// What the studio records, saves and bakes, and the bakes that it plays.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/text.h"
#include "host/pipeline/bake_scene.h"
#include "tests/studio/running_studio.h"

namespace fascicle::tests {
namespace {

// A saved scene bakes to the bits of the recorded run, in the studio and through the pipeline of `fascicle
// bake`.
TEST_F(SessionTest, ARecordedRunIsTheBakeOfWhatIsSaved) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say(
      {{"type", "set"},
       {"changes",
        {{"layers.body.frequency", 4.0}, {"layers.body.beta", 0.5}, {"layers.body.fibre", {1, 0, 0}}}}});
  client->wait_for("applied");
  client->say({{"type", "record"}});
  std::map<std::uint32_t, std::uint64_t> shown;
  Json recorded;
  while (const auto message = client->next()) {
    if (message->is_text) {
      const Json json = Json::parse(message->bytes);
      if (json.at("type") != "recorded") continue;
      recorded = json;
      break;
    }
    if (message->bytes[0] != 1) continue;
    const DecodedFrame frame = decode_frame(message->bytes);
    if ((frame.flags & 1u) != 0) shown[frame.frame] = frame.position_hash;
  }
  ASSERT_EQ(recorded.at("hashes").size(), 31u);
  // Every frame was shown; the last may not have arrived yet.
  EXPECT_GE(shown.size(), 30u);
  for (const auto& [frame, hash] : shown) EXPECT_EQ(recorded.at("hashes")[frame], base::hash_text(hash));

  client->say({{"type", "save"}, {"file", "mine.toml"}});
  const Json saved = client->wait_for("saved");
  EXPECT_EQ(saved.at("kept_comments"), true);
  const std::string text = read(folder_ / "session" / "mine.toml");
  EXPECT_NE(text.find("# A bar that hangs from a wall."), std::string::npos);
  EXPECT_NE(text.find("frequency = 4.0   # Hz: the bar's own"), std::string::npos) << text;

  client->say({{"type", "bake"}, {"folder", "out"}, {"formats", {"pc2"}}});
  const Json baked = client->wait_for("baked");
  EXPECT_EQ(baked.at("position_hash"), recorded.at("position_hash"));
  const auto manifest = bake::read_manifest(folder_ / "session" / "out");
  ASSERT_TRUE(manifest);
  EXPECT_EQ(manifest->status, "complete");
  EXPECT_EQ(Json(manifest->position_hashes), recorded.at("hashes"));
  EXPECT_NE(baked.at("files").dump().find(".pc2"), std::string::npos);

  pipeline::BakeRequest request;
  request.output.folder = folder_ / "independent";
  request.output.formats = {"none"};
  request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
  const auto prepared =
      pipeline::prepare_bake(scene::load_scene((folder_ / "session" / "mine.toml").string()), request, {});
  EXPECT_EQ(pipeline::run_bake(*prepared, request, {}).last_position_hash, recorded.at("position_hash"));
  // A control: other keys give other bits.
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 4.5}}}});
  client->wait_for("applied");
  client->say({{"type", "record"}});
  EXPECT_NE(client->wait_for("recorded").at("position_hash"), recorded.at("position_hash"));
}

// Saving rewrites relative file names for the folder of the saved scene.
TEST_F(SessionTest, ASavedSceneFindsItsFiles) {
  fs::create_directories(folder_ / "scenes" / "meshes");
  base::write_whole(
      folder_ / "scenes" / "meshes" / "body.mesh",
      "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n0.1 0 0 0\n0 0.1 0 0\n0 0 0.1 0\n"
      "0.1 0.1 0.1 0\nTetrahedra\n2\n1 2 3 4 0\n2 3 4 5 0\nEnd\n");
  scene_ = folder_ / "scenes" / "two.toml";
  base::write_whole(scene_,
                    "[scene]\nend = 0.1\n[mesh]\nfile = \"meshes/body.mesh\" # two of them\n"
                    "[layers.body]\nalpha = 0.5\n"
                    "[pin.floor]\nwhere = { below = { axis = \"y\", fraction = 0.0 } }\n");
  // The session's folder is a link to one at another depth.
  fs::create_directories(folder_ / "scratch" / "disk");
  fs::create_directory_symlink(folder_ / "scratch" / "disk", folder_ / "session");
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"layers.body.alpha", 0.25}}}});
  client->wait_for("applied");
  client->say({{"type", "record"}});
  const Json recorded = client->wait_for("recorded");
  client->say({{"type", "bake"}});
  EXPECT_EQ(client->wait_for("saved").at("file"), (folder_ / "session" / "two.toml").string());
  EXPECT_EQ(client->wait_for("baked").at("position_hash"), recorded.at("position_hash"));
  EXPECT_NE(read(folder_ / "session" / "two.toml").find("\"../../scenes/meshes/body.mesh\" # two of them"),
            std::string::npos);
}

TEST_F(SessionTest, ABuiltInSceneIsSavedAndBaked) {
  const Running studio("bar-beta-1", folder_ / "session", folder_ / "cache");
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"scene.end", 0.1}}}});
  client->wait_for("applied");
  client->say({{"type", "bake"}});
  client->wait_for("saved");
  EXPECT_EQ(client->wait_for("baked").at("frames"), 6);
  EXPECT_EQ(scene::load_scene((folder_ / "session" / "bar-beta-1.toml").string()).end, 0.1);
}

TEST_F(SessionTest, FoldersAndFilesOfOthersAreNotOverwritten) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  base::write_whole(folder_ / "session" / "mine.toml", "# somebody's\n");
  client->say({{"type", "save"}, {"file", "mine.toml"}});
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("did not write it"),
            std::string::npos);
  EXPECT_EQ(read(folder_ / "session" / "mine.toml"), "# somebody's\n");
  client->say({{"type", "bake"}});
  client->wait_for("baked");
  client->say({{"type", "bake"}});
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("holds a bake"),
            std::string::npos);
  client->say({{"type", "bake"}, {"overwrite", true}});
  client->wait_for("baked");
  EXPECT_THROW(Running(scene_.string(), folder_ / "session", folder_ / "cache"), bake::FolderInUse);
}

// A link in the folder may lead out of it.
TEST_F(SessionTest, NoBakeFollowsALink) {
  fs::create_directories(folder_ / "elsewhere");
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "session" / "out");
  for (const bool overwrites : {false, true}) {
    client->say({{"type", "bake"}, {"folder", "out"}, {"overwrite", overwrites}});
    EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("symbolic link"),
              std::string::npos);
  }
  // While the bake waits for a recorded run, the link appears.
  client->say({{"type", "set"}, {"changes", {{"scene.end", 100.0}}}});
  client->wait_for("applied");
  client->say({{"type", "record"}});
  client->say({{"type", "bake"}, {"folder", "late"}});
  client->wait_for("saved");
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "session" / "late");
  client->say({{"type", "cancel"}});
  client->say({{"type", "pause"}});
  Json end = client->wait_for("failed");
  EXPECT_NE(end.at("error").get<std::string>().find("symbolic link"), std::string::npos) << end;
  EXPECT_TRUE(fs::is_empty(folder_ / "elsewhere"));
}

// Requests of the hand wait while the player is busy, and only so many may wait.
TEST_F(SessionTest, TheHandWaitsForABakeWithinLimits) {
  base::write_whole(scene_, std::string(bar_text) + "[motion]\nhold = 600.0\n");
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  Json grab{
      {"type", "hand"}, {"action", "grab"}, {"vertex", 80}, {"of", "vertices"}, {"place", {0.4, 0.1, 0.1}}};
  client->say({{"type", "bake"}});
  client->wait_for("baking");
  for (int k = 0; k < 1100; ++k) {
    client->say(grab);
    client->say({{"type", "hand"}, {"action", "release"}});
  }
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("too many requests"),
            std::string::npos);
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("not holding"), std::string::npos)
      << "a grab that was refused holds nothing";
  client->say({{"type", "cancel"}});
  client->wait_for("cancelled");
  // The flesh can be held again as soon as what waited is over.
  const auto is_taken = [&] {
    client->say(grab);
    while (const auto message = client->next()) {
      if (!message->is_text) continue;
      const Json json = Json::parse(message->bytes);
      if (json.value("id", 0) == 1) return json.at("type") == "done";
    }
    return false;
  };
  grab["id"] = 1;
  bool is_held = false;
  for (int k = 0; k < 100 && !is_held; ++k) {
    is_held = is_taken();
    if (!is_held) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_TRUE(is_held);
  Json held = client->wait_for("hand");
  while (held.at("is_held") != true) held = client->wait_for("hand");
  EXPECT_GT(held.at("vertices"), 0);
}

TEST_F(SessionTest, ARecordedRunTakesTheHandAway) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say(
      {{"type", "hand"}, {"action", "grab"}, {"vertex", 80}, {"of", "vertices"}, {"place", {0.4, 0.1, 0.1}}});
  EXPECT_EQ(client->wait_for("hand").at("is_held"), true);
  client->say({{"type", "record"}});
  EXPECT_EQ(client->wait_for("hand").at("is_held"), false);
}

TEST_F(SessionTest, ABakeCanBeCancelled) {
  base::write_whole(scene_, std::string(bar_text) + "[motion]\nhold = 600.0\n");
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "bake"}});
  for (;;) {
    const Json baking = client->wait_for("baking");
    if (baking.is_null() || baking.at("phase") == "frames") break;
  }
  client->say({{"type", "cancel"}});
  EXPECT_EQ(client->wait_for("cancelled").at("what"), "bake");
  EXPECT_EQ(bake::read_manifest(folder_ / "session" / "bake")->status, "interrupted");
}

double tip_height(const DecodedFrame& frame, const std::vector<float>& rest) {
  double sum = 0.0, count = 0.0;
  float most = rest[0];
  for (std::size_t k = 0; k < rest.size(); k += 3) most = std::max(most, rest[k]);
  for (std::size_t k = 0; k < rest.size(); k += 3)
    if (rest[k] > most - 1e-4f) {
      sum += frame.blocks.at(4)[k + 1];
      count += 1.0;
    }
  return sum / count;
}

// Cancelling applies to what was requested before it, and to nothing later.
TEST_F(SessionTest, CancelIsOfWhatWasAskedBefore) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"scene.end", 20.0}}}});
  client->wait_for("applied");
  client->say({{"type", "record"}});
  client->say({{"type", "cancel"}});
  client->say({{"type", "record"}});
  EXPECT_EQ(client->wait_for("cancelled").at("what"), "record");
  EXPECT_EQ(client->wait_for("recorded").at("frames"), 1200);
}

// Changes during a bake wait; only the last one is applied.
TEST_F(SessionTest, ChangesDuringABakeComeAfterIt) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"scene.end", 600.0}}}});
  client->wait_for("applied");
  client->say({{"type", "bake"}});
  client->wait_for("baking");
  client->say({{"type", "bake"}});
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("under way"), std::string::npos);
  std::uint32_t last = 0;
  for (int k = 0; k < 40; ++k) {
    client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 3.0 + 0.05 * k}}}});
    last = client->wait_for("changed").at("revision");
  }
  client->say({{"type", "cancel"}});
  client->wait_for("cancelled");
  Json applied = client->wait_for("applied");
  while (applied.at("revision") != last) applied = client->wait_for("applied");
}

// Ctrl-C may arrive at any time.
TEST_F(SessionTest, EndsInTheMiddleOfARunAndOfABake) {
  for (const char* work : {"record", "bake"}) {
    std::optional<Running> studio(std::in_place, scene_.string(), folder_ / "session", folder_ / "cache");
    const auto client = studio->open();
    start_of(*client);
    client->say({{"type", "set"}, {"changes", {{"scene.end", 60.0 + work[0]}}}});
    client->wait_for("applied");
    client->say({{"type", work}});
    Json state = client->wait_for("player");
    while (state.at("state") != "recording" && state.at("state") != "baking")
      state = client->wait_for("player");
    studio.reset();
  }
}

// A changed bar comes to rest in the running loop where a bake of it does that settles first.
TEST_F(SessionTest, ASoftenedBarComesToRestWhereABakeOfItDoes) {
  const Running studio = open();
  const auto client = studio.open();
  const std::vector<float> rest = start_of(*client).arrays.at("rest").floats;
  client->say({{"type", "show"}, {"blocks", {"vertices"}}});
  client->say({{"type", "speed"}, {"factor", 4}});
  const auto settled = [&](std::uint32_t revision) {
    return tip_height(decode_frame(client->wait_for_frame([&](const std::string& bytes) {
                        const DecodedFrame frame = decode_frame(bytes);
                        return frame.revision == revision && frame.seconds > 0.0f && frame.speed < 1e-4f &&
                               frame.blocks.count(4) == 1;
                      })),
                      rest);
  };
  const double before = settled(1);
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 4.0}}}});
  const double after = settled(client->wait_for("changed").at("revision"));
  const auto of_bake = [&](const char* frequency) {
    scene::SceneOverrides overrides;
    overrides.set = {std::string("layers.body.frequency=") + frequency};
    overrides.settle = 5.0;
    pipeline::BakeRequest request;
    request.output.folder = folder_ / ("bake-" + std::string(frequency));
    request.output.formats = {"none"};
    request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
    const auto prepared = pipeline::prepare_bake(scene::load_scene(scene_.string(), overrides), request, {});
    pipeline::run_bake(*prepared, request, {});
    const model::Frame frame = bake::FrameCacheReader(request.output.folder / bake::cache_name).read(30);
    DecodedFrame decoded;
    for (std::size_t k = 0; k < frame.positions.size(); ++k)
      decoded.blocks[4].push_back(frame.origin[k % 3] +
                                  prepared->built.model.unit * double{frame.positions[k]});
    return tip_height(decoded, rest);
  };
  // Both move at 1 mm/s or less, at about 4 Hz: 0.04 mm. Quantised to 0.01 mm.
  EXPECT_NEAR(before, of_bake("6.0"), 2e-4);
  EXPECT_NEAR(after, of_bake("4.0"), 2e-4);
  EXPECT_LT(after, before - 3e-3);
}

TEST_F(SessionTest, ABakesFramesArePlayedAndNotTouched) {
  pipeline::BakeRequest request;
  request.output.folder = folder_ / "bake";
  request.output.formats = {"none"};
  request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
  const auto prepared = pipeline::prepare_bake(scene::load_scene(scene_.string()), request, {});
  pipeline::run_bake(*prepared, request, {});
  const auto manifest = bake::read_manifest(folder_ / "bake");
  const Running studio(folder_ / "bake");
  const auto client = studio.open();
  const Start start = start_of(*client);
  EXPECT_EQ(start.messages.at("hello").at("kind"), "bake");
  EXPECT_EQ(start.messages.at("hello").at("can_touch"), false);
  EXPECT_EQ(start.messages.count("keys"), 0u);
  client->say({{"type", "pause"}});
  for (const std::uint32_t frame : {0u, 17u, 30u}) {
    client->say({{"type", "seek"}, {"frame", frame}});
    const DecodedFrame shown = decode_frame(
        client->wait_for_frame([&](const std::string& bytes) { return decode_frame(bytes).frame == frame; }));
    EXPECT_EQ(base::hash_text(shown.position_hash), manifest->position_hashes[frame]);
  }
  for (const char* type : {"undo", "redo", "record", "bake", "save"}) {
    client->say({{"type", type}});
    EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("bake"), std::string::npos);
  }
  client->say({{"type", "set"}, {"changes", {{"layers.body.beta", 0.5}}}});
  client->wait_for("refused");
  client->say({{"type", "hand"}, {"action", "grab"}, {"vertex", 0}, {"place", {0, 0, 0}}});
  client->wait_for("refused");
}

}  // namespace
}  // namespace fascicle::tests
