// The comparison bake next to the playing one, and the scene's solids: what pages receive of them, and that
// no other folder can be opened.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/text.h"
#include "host/made/made_character.h"
#include "host/pipeline/bake_scene.h"
#include "host/scene/paint_file.h"
#include "tests/studio/running_studio.h"

namespace fascicle::tests {
namespace {

// Block bits of a frame.
constexpr std::uint32_t vertex_block = 4, solid_block = 64;

void bake_into(const fs::path& folder, const fs::path& scene, const std::vector<std::string>& set = {}) {
  scene::SceneOverrides overrides;
  overrides.set = set;
  pipeline::BakeRequest request;
  request.output.folder = folder;
  request.output.formats = {"none"};
  request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
  request.build.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  const auto prepared = pipeline::prepare_bake(scene::load_scene(scene.string(), overrides), request, {});
  pipeline::run_bake(*prepared, request, {});
}

// Waits for this frame together with a comparison bake.
DecodedFrame both_at(Client& client, std::uint32_t number) {
  return decode_frame(client.wait_for_frame([&](const std::string& bytes) {
    const DecodedFrame frame = decode_frame(bytes);
    return frame.frame == number && !frame.beside.empty();
  }));
}

class BesideTest : public SessionTest {};

TEST_F(BesideTest, TwoBakesRunInOneTimeLine) {
  bake_into(folder_ / "first", scene_);
  bake_into(folder_ / "soft", scene_, {"layers.body.frequency=3.0"});
  bake_into(folder_ / "slow", scene_, {"scene.fps=30", "scene.end=0.3"});
  const Running studio(folder_ / "first", {folder_ / "soft", folder_ / "slow"});
  const auto client = studio.open();
  const Start start = start_of(*client);
  const Json& beside = start.messages.at("beside");
  const std::string soft = (folder_ / "soft").string(), slow = (folder_ / "slow").string();
  EXPECT_EQ(beside.at("choices"), Json({soft, slow}));
  EXPECT_EQ(beside.at("bake").at("name"), soft) << "the first is selected from the start";
  for (const Json& name : beside.at("bake").at("arrays"))
    EXPECT_EQ(start.arrays.count(name.get<std::string>()), 1u) << name;
  EXPECT_EQ(start.arrays.at("beside.tetrahedron").numbers, start.arrays.at("tetrahedron").numbers);

  client->say({{"type", "pause"}});
  client->say({{"type", "show"}, {"blocks", {"vertices"}}, {"beside", {"vertices"}}});
  const auto hashes = [&](const std::string& folder) { return bake::read_manifest(folder)->position_hashes; };
  for (const std::uint32_t number : {30u, 7u}) {
    client->say({{"type", "seek"}, {"frame", number}});
    const DecodedFrame frame = both_at(*client, number);
    EXPECT_EQ(base::hash_text(frame.position_hash), hashes((folder_ / "first").string())[number]);
    ASSERT_EQ(frame.beside.size(), 1u);
    EXPECT_EQ(base::hash_text(frame.beside[0].position_hash), hashes(soft)[number]);
    EXPECT_EQ(frame.beside[0].blocks.at(vertex_block).size(), frame.blocks.at(vertex_block).size());
    EXPECT_NE(frame.beside[0].blocks.at(vertex_block), frame.blocks.at(vertex_block));
    // The bake stores no velocities, so this comes from its metrics.
    EXPECT_TRUE(std::isfinite(frame.energy));
    EXPECT_GT(frame.beside[0].energy, 0.0f);
  }

  // Half the frame rate and a shorter clip: shows the frame at the same time, and then the last one.
  client->say({{"type", "beside"}, {"name", slow}});
  EXPECT_EQ(client->wait_for("beside").at("bake").at("name"), slow);
  for (const auto& [played, expected] : {std::pair(12u, 6u), std::pair(25u, 9u)}) {
    client->say({{"type", "seek"}, {"frame", played}});
    const DecodedFrame frame = both_at(*client, played);
    EXPECT_EQ(frame.beside[0].frame, expected);
    EXPECT_EQ(base::hash_text(frame.beside[0].position_hash), hashes(slow)[expected]);
  }
  client->say({{"type", "beside"}, {"name", ""}});
  EXPECT_TRUE(client->wait_for("beside").at("bake").is_null());
  client->say({{"type", "seek"}, {"frame", 3}});
  const std::string alone =
      client->wait_for_frame([](const std::string& bytes) { return decode_frame(bytes).frame == 3; });
  EXPECT_TRUE(decode_frame(alone).beside.empty());
}

// A page may send any name, but can open only the given bakes and the session's own.
TEST_F(BesideTest, NoOtherFolderIsReached) {
  bake_into(folder_ / "given", scene_);
  bake_into(folder_ / "foreign", scene_);
  fs::create_directories(folder_ / "session");
  fs::create_directory_symlink(folder_ / "foreign", folder_ / "session" / "link");
  fs::create_directories(folder_ / "session" / "odd" / bake::manifest_name);  // a folder instead of a file
  fs::create_directories(folder_ / "session" / "odd" / bake::cache_name);
  const Running studio(scene_.string(), folder_ / "session", folder_ / "cache", {folder_ / "given"});
  const auto client = studio.open();
  const Start start = start_of(*client);
  const std::string given = (folder_ / "given").string();
  EXPECT_EQ(start.messages.at("beside").at("choices"), Json({given}));
  for (const std::string& name :
       {(folder_ / "foreign").string(), (folder_ / "session" / "link").string(), std::string("link"),
        (folder_ / "given" / ".." / "foreign").string(), given + "/../foreign", std::string("/etc"),
        std::string("."), std::string(".."), std::string(1000, 'x')}) {
    client->say({{"type", "beside"}, {"name", name}});
    EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("not a bake of this session"),
              std::string::npos)
        << name;
  }
  // The control: an existing name.
  client->say({{"type", "beside"}, {"name", given}, {"id", 5}});
  EXPECT_EQ(client->wait_for("beside").at("bake").at("name"), given);
}

// A running scene next to a bake of it, which is then baked again.
TEST_F(BesideTest, ARunningSceneStandsBesideItsOwnBakes) {
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  EXPECT_TRUE(start.messages.at("beside").at("choices").empty());
  client->say({{"type", "bake"}, {"folder", "one"}});
  const std::string one = (folder_ / "session" / "one").string();
  EXPECT_EQ(client->wait_for("beside").at("choices"), Json({one}));
  const Json baked = client->wait_for("baked");
  client->say({{"type", "beside"}, {"name", one}});
  client->say({{"type", "record"}});
  EXPECT_EQ(client->wait_for("recorded").at("position_hash"), baked.at("position_hash"));
  client->say({{"type", "pause"}});
  for (const std::uint32_t number : {30u, 11u}) {
    client->say({{"type", "seek"}, {"frame", number}});
    const DecodedFrame frame = both_at(*client, number);
    // The same keys give the same flesh.
    EXPECT_EQ(frame.position_hash, frame.beside[0].position_hash);
  }
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 3.0}}}});
  client->wait_for("applied");
  client->say({{"type", "bake"}, {"folder", "one"}, {"overwrite", true}});
  EXPECT_TRUE(client->wait_for("beside").at("bake").is_null()) << "a bake that is rewritten is closed";
  EXPECT_EQ(client->wait_for("beside").at("bake").at("name"), one);
  const Json again = client->wait_for("baked");
  EXPECT_NE(again.at("position_hash"), baked.at("position_hash"));
  client->say({{"type", "seek"}, {"frame", 30}});
  const DecodedFrame last = both_at(*client, 30);
  EXPECT_EQ(base::hash_text(last.beside[0].position_hash), again.at("position_hash").get<std::string>());
}

// An unreadable bake is reported, and the previous one stays.
TEST_F(BesideTest, ADamagedBakeIsRefused) {
  bake_into(folder_ / "whole", scene_);
  bake_into(folder_ / "cut", scene_);
  fs::resize_file(folder_ / "cut" / bake::cache_name, bake::cache_header_bytes + 8);
  const std::string whole = (folder_ / "whole").string();
  const Running studio(folder_ / "whole", {folder_ / "whole", folder_ / "cut"});
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "beside"}, {"name", (folder_ / "cut").string()}});
  const Json failed = client->wait_for("failed");
  EXPECT_EQ(failed.at("what"), "beside");
  EXPECT_NE(failed.at("error").get<std::string>().find("cut"), std::string::npos);
  const auto second = studio.open();
  EXPECT_EQ(start_of(*second).messages.at("beside").at("bake").at("name"), whole);
  EXPECT_THROW(Running(folder_ / "whole", {folder_ / "cut"}), std::runtime_error);
}

// A bake that is rewritten is shown again afterwards, however the rewrite ends.
TEST_F(BesideTest, ABakeThatEndsEarlyStandsBesideAgain) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "bake"}, {"folder", "one"}});
  client->wait_for("baked");
  const std::string one = (folder_ / "session" / "one").string();
  client->say({{"type", "beside"}, {"name", one}});
  EXPECT_EQ(client->wait_for("beside").at("bake").at("name"), one);
  client->say({{"type", "set"}, {"changes", {{"scene.end", 600.0}}}});
  client->wait_for("applied");
  client->say({{"type", "bake"}, {"folder", "one"}, {"overwrite", true}});
  EXPECT_TRUE(client->wait_for("beside").at("bake").is_null());
  for (Json baking = Json::object();
       baking.value("phase", "") != "frames" || baking.value("frame", 0) == 0;) {
    baking = client->wait_for("baking");
    ASSERT_FALSE(baking.is_null());
  }
  client->say({{"type", "cancel"}});
  EXPECT_EQ(client->wait_for("beside").at("bake").at("name"), one);
  EXPECT_EQ(client->wait_for("cancelled").at("what"), "bake");
}

// Without its scene a bake has no skinning, so its lag is unknown. 0 would mean that flesh follows the
// skeleton exactly.
TEST_F(BesideTest, WithoutItsSceneABakesLagIsNotKnown) {
  scene_ = folder_ / "arm.toml";
  base::write_whole(scene_,
                    "[scene]\nend = 0.1\n[character]\nmade = \"arm\"\nresolution = 0.04\n"
                    "paint = \"arm.paint.json\"\n");
  const mesh::SurfaceMesh surface = made::make_character("arm").surface;
  const std::string paint =
      scene::paint_text({rig::surface_hash(surface), surface.vertices.size(), {{"_LAYER", {5}, {1.0f}}}});
  base::write_whole(folder_ / "arm.paint.json", paint);
  bake_into(folder_ / "bake", scene_);
  const auto look = [&](bool is_known) {
    const Running studio(folder_ / "bake", {folder_ / "bake"});
    const auto client = studio.open();
    const Start start = start_of(*client);
    const Json& bake = start.messages.at("beside").at("bake");
    EXPECT_EQ(bake.value("why_no_lag", "").empty(), is_known) << bake.value("why_no_lag", "");
    EXPECT_EQ(start.messages.at("warnings").dump().find("lag") == std::string::npos, is_known);
    client->say({{"type", "pause"}});
    client->say({{"type", "seek"}, {"frame", 2}});
    const DecodedFrame frame = both_at(*client, 2);
    for (const DecodedFrame& each : {frame, frame.beside.at(0)}) {
      EXPECT_EQ(std::isfinite(each.lag), is_known);
      EXPECT_EQ(std::isfinite(each.largest_lag), is_known);
    }
  };
  look(true);
  base::write_whole(folder_ / "arm.paint.json", paint + "\n");  // changed since the bake
  look(false);
  fs::remove(folder_ / "arm.paint.json");
  look(false);
}

constexpr const char* press_text = R"([collider.below]
shape = "plane"
center = [0.0, -0.5, 0.0]
thickness = 0.01

[collider.press]
shape = "box"
center = [0.2, 0.4, 0.05]
size = [0.3, 0.1, 0.2]
radius = 0.02
rotation = [0.0, 0.0, 90.0]
times = [0.0, 0.5]
offsets = [[0.0, 0.0, 0.0], [0.0, -0.1, 0.0]]
)";

TEST_F(BesideTest, SolidsAreWhereTheSceneMovesThem) {
  base::write_whole(scene_, std::string(bar_text) + press_text);
  bake_into(folder_ / "bake", scene_);
  const auto check = [&](const Running& studio) {
    const auto client = studio.open();
    const Start start = start_of(*client);
    const Json& described = start.messages.at("body").at("solids");
    ASSERT_EQ(described.size(), 2u);
    EXPECT_EQ(described[0].at("name"), "below");
    EXPECT_EQ(described[0].at("shape"), "plane");
    EXPECT_EQ(described[0].at("radius"), 0.01);
    EXPECT_EQ(described[0].at("up"), Json({0.0, 1.0, 0.0}));
    EXPECT_EQ(described[1].at("shape"), "box");
    // Half its edges, minus the rounding radius.
    const double half[] = {0.13, 0.03, 0.08};
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(described[1].at("half_size")[a].get<double>(), half[a], 1e-12);
    client->say({{"type", "pause"}});
    client->say({{"type", "show"}, {"blocks", {"solids"}}});
    for (const std::uint32_t number : {0u, 15u, 30u}) {
      client->say({{"type", "seek"}, {"frame", number}});
      const DecodedFrame frame = decode_frame(client->wait_for_frame([&](const std::string& bytes) {
        const DecodedFrame one = decode_frame(bytes);
        return one.frame == number && one.blocks.count(solid_block) == 1;
      }));
      const std::vector<double>& points = frame.blocks.at(solid_block);
      ASSERT_EQ(points.size(), 24u);
      // By hand: the box moves down at constant speed by 0.1 m in the clip's 30 frames, and is on its side.
      const double height = 0.4 - 0.1 * number / 30.0;
      const std::vector<double> expected{0.0,        -0.5, 0.0,  /**/ 1, -0.5, 0,      0,      0.5,
                                         0,          0,    -0.5, 1,      0.2,  height, 0.05,   /**/ 0.2,
                                         height + 1, 0.05, -0.8, height, 0.05, 0.2,    height, 1.05};
      for (std::size_t k = 0; k < points.size(); ++k) {
        // The other two axes of a plane are arbitrary.
        if (k >= 3 && k < 12 && k / 3 != 2) continue;
        // Half a quantisation step, and float rounding at this size.
        EXPECT_NEAR(points[k], expected[k], 0.5 * frame.steps.at(solid_block)[k % 3] + 1e-6)
            << number << " " << k;
      }
    }
  };
  check(open());
  check(Running(folder_ / "bake"));
}

TEST_F(BesideTest, WithoutSolidsThereAreNone) {
  const Running studio = open();
  const auto client = studio.open();
  EXPECT_TRUE(start_of(*client).messages.at("body").at("solids").empty());
  client->say({{"type", "show"}, {"blocks", {"vertices", "solids"}}});
  const DecodedFrame frame = decode_frame(client->wait_for_frame(
      [](const std::string& bytes) { return decode_frame(bytes).blocks.count(vertex_block) == 1; }));
  EXPECT_EQ(frame.blocks.count(solid_block), 0u);
}

}  // namespace
}  // namespace fascicle::tests
