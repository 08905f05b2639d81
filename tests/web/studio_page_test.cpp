// The studio in a real Chromium: web/tests/studio.mjs starts the program and uses its page, and this test
// judges what it reports.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"
#include "tests/support/web.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json used_studio(const std::string& name, const std::string& script, const std::string& scene) {
  const fs::path folder = fs::path(FASCICLE_BINARY_DIR) / "screenshots" / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  const TemporaryFolder logs;
  EXPECT_EQ(run_web("timeout 1200 node tests/" + script + " '" + FASCICLE_PROGRAM + "' '" + folder.string() +
                        "' " + scene,
                    logs / "log"),
            0)
      << read_text(logs / "log");
  return fs::exists(folder / "report.json") ? json::parse(read_text(folder / "report.json"), nullptr, false)
                                            : json();
}

// A bar that comes to rest within its clip: how low it hangs at the end depends on its stiffness.
constexpr const char* resting_bar = R"([scene]
fps = 60
end = 1.5

[bar]
size = [0.4, 0.1, 0.1]
vertices = [9, 3, 3]

[layers.body]
frequency = 3.0
damping = 14.0

[pin.wall]
where = { below = { axis = "x", fraction = 0.0 } }
)";

TEST(StudioPage, IsTouchedSavedAndBaked) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "bar.toml", resting_bar);
  const json seen = used_studio("studio", "studio.mjs", "'" + folder / "bar.toml" + "'");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["said"], json::array()) << "the console is silent";
  EXPECT_TRUE(seen["moves"]);
  for (const json& path : seen["asked"])
    EXPECT_TRUE(path == "/" || path == "/studio.js" || path == "/studio.css") << path;

  // Twice as soft, the bar's free end hangs several rows of pixels lower.
  EXPECT_NEAR(seen["softness"].get<double>(), 2.0, 0.05);
  EXPECT_GT(seen["bottoms"][1].get<int>(), seen["bottoms"][0].get<int>() + 4) << seen["bottoms"];
  EXPECT_NE(seen["hashes"][0], seen["hashes"][1]);
  EXPECT_NE(seen["undone"], seen["softness"]);

  // The saved file bakes to what was shown: from the page, and by the program.
  EXPECT_EQ(seen["baked"], seen["hashes"][1]);
  EXPECT_EQ(seen["other"], json({true, true}))
      << "a page that did not begin the bake: Stop, and it goes at the end";
  const fs::path session = fs::path(FASCICLE_BINARY_DIR) / "screenshots/studio/session";
  ASSERT_TRUE(fs::exists(session / "soft.toml"));
  const Outcome baked =
      fascicle({"bake", (session / "soft.toml").string(), "-o", folder / "again", "--device", "cpu"});
  ASSERT_EQ(baked.status, 0) << baked.err;
  EXPECT_TRUE(contains(baked.out, seen["hashes"][1].get<std::string>())) << baked.out;

  for (const auto& [key, did] : seen["keys"].items()) EXPECT_TRUE(did.get<bool>()) << "key " << key;
  for (const auto& [what, violations] : seen["axe"].items())
    EXPECT_EQ(violations, json::array()) << "axe-core, " << what;
  EXPECT_GE(seen["found"], 1) << "the search finds gravity";

  EXPECT_TRUE(contains(seen["lost"].get<std::string>(), "Connection lost"));
  EXPECT_EQ(seen["restored"], seen["softness"]) << "nothing is lost when the program dies";
  EXPECT_EQ(seen["ended"], 0);
}

// The brush: by mouse and keyboard, undone, saved next to the scene, and baked to what was recorded.
TEST(StudioPage, PaintsACharacter) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "arm.toml", "[scene]\nend = 0.2\n[character]\nmade = \"arm\"\nresolution = 0.03\n");
  const json seen = used_studio("studio-paint", "studio_paint.mjs", "'" + folder / "arm.toml" + "'");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["said"], json::array()) << "the console is silent";
  EXPECT_TRUE(seen["brush"]);
  const json& painted = seen["painted"];
  EXPECT_EQ(painted["start"], 0);
  EXPECT_GT(painted["stroke"], 3);
  EXPECT_EQ(seen["bone_pixels"][0], 0);
  EXPECT_GT(seen["bone_pixels"][1], 50) << "the colours show it";
  EXPECT_TRUE(seen["larger"]);
  EXPECT_TRUE(seen["smaller"]);
  EXPECT_GT(painted["dab"], 0);
  EXPECT_GT(painted["fibres"], 3);
  EXPECT_TRUE(contains(seen["times"].get<std::string>(), "× 0.4")) << seen["times"];
  EXPECT_GT(painted["stiffness"], 0);
  EXPECT_EQ(painted["stiffness_undone"], 0);
  EXPECT_EQ(painted["undone"], 0);
  EXPECT_EQ(painted["redone"], painted["fibres"]);
  EXPECT_EQ(painted["restored"], painted["fibres"]) << "nothing is lost when the program dies";
  for (const auto& [what, violations] : seen["axe"].items())
    EXPECT_EQ(violations, json::array()) << "axe-core, " << what;

  ASSERT_EQ(seen["bone"].size(), 3u);
  EXPECT_NE(seen["bone"][0], seen["bone"][1]);
  EXPECT_TRUE(contains(seen["bone"][1].get<std::string>(), "no bone")) << seen["bone"];
  EXPECT_EQ(seen["bone"][0], seen["bone"][2]);
  EXPECT_TRUE(contains(seen["clicked"].get<std::string>(), " bone")) << seen["clicked"];

  EXPECT_NE(seen["before"], seen["recorded"]) << "the control: paint acts";
  EXPECT_EQ(seen["baked"], seen["recorded"]);
  const fs::path session = fs::path(FASCICLE_BINARY_DIR) / "screenshots/studio-paint/session";
  ASSERT_TRUE(fs::exists(session / "painted.paint.json"));
  const Outcome baked =
      fascicle({"bake", (session / "painted.toml").string(), "-o", folder / "again", "--device", "cpu"});
  ASSERT_EQ(baked.status, 0) << baked.err;
  EXPECT_TRUE(contains(baked.out, seen["recorded"].get<std::string>())) << baked.out;
  EXPECT_EQ(seen["ended"], 0);
}

// Two bakes of a character in one timeline: side by side, as a ghost, and by distance; and a picture that
// sharpens once still.
TEST(StudioPage, ShowsTwoBakesSideBySide) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  for (const auto& [name, softness] : {std::pair("arm", "1"), std::pair("soft", "30")}) {
    const Outcome made = fascicle({"bake", "arm", "-o", folder / name, "--softness", softness, "--end", "1.2",
                                   "--format", "none", "--device", "cpu"});
    ASSERT_EQ(made.status, 0) << made.err;
  }
  const json seen = used_studio("studio-beside", "studio_beside.mjs",
                                "'" + folder / "arm" + "' --beside '" + folder / "soft" + "'");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["said"], json::array()) << "the console is silent";
  for (const json& path : seen["asked"])
    EXPECT_TRUE(path == "/" || path == "/studio.js" || path == "/studio.css") << path;
  EXPECT_EQ(seen["comparison"], "sides");
  EXPECT_EQ(seen["against"], folder / "soft");
  EXPECT_EQ(seen["tags"], json({"soft", "Current: arm"}));

  EXPECT_LT(seen["moving_ratio"].get<double>(), 1.9)
      << "the control: this machine is too slow for all pixels";
  EXPECT_NEAR(seen["still_ratio"].get<double>(), 2.0, 0.01);

  EXPECT_EQ(seen["names"], json({"Lag, mean", "Lag, peak", "Energy", "Volume"}))
      << "a bake has no solver's speed";
  for (const json& value : seen["values"])
    EXPECT_TRUE(contains(value.get<std::string>(), " | ")) << value << ": both bakes";
  EXPECT_TRUE(contains(seen["curves"].get<std::string>(), "Lag, mean from 0 to ")) << seen["curves"];

  EXPECT_TRUE(seen["difference_can"]);
  EXPECT_EQ(seen["difference"][0], 0) << "the comparison bake has its own colours";
  EXPECT_GT(seen["difference"][1], 20);
  EXPECT_EQ(seen["no_difference"], json({0, 0}));
  EXPECT_EQ(seen["ghost"][0], 0);
  EXPECT_GT(seen["ghost"][1], 100);
  EXPECT_EQ(seen["ghost_tag"], "Magenta: soft");
  EXPECT_EQ(seen["without"]["tag"], "Blue: skinning alone");
  EXPECT_EQ(seen["without"]["option"], false);
  EXPECT_EQ(seen["again"], folder / "soft");
  EXPECT_TRUE(seen["clicked"]);
  for (const auto& [what, violations] : seen["axe"].items())
    EXPECT_EQ(violations, json::array()) << "axe-core, " << what;
  EXPECT_EQ(seen["ended"], 0);
}

// A bar that falls on a floor and stays there.
TEST(StudioPage, DrawsSolidsAndWhatTouchesThem) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "fall.toml",
             "[scene]\nfps = 60\nend = 1.0\n[bar]\nsize = [0.2, 0.1, 0.1]\nvertices = [5, 3, 3]\n"
             "[layers.body]\nyoungs_modulus = 20e3\ndamping = 12.0\n"
             "[collider.floor]\nshape = \"plane\"\ncenter = [0.0, -0.1, 0.0]\n"
             "[collider.post]\nshape = \"capsule\"\nfrom = [0.35, 0.0, 0.0]\nto = [0.35, 0.2, 0.0]\n"
             "radius = 0.04\n");
  const json seen = used_studio("studio-solids", "studio_solids.mjs", "'" + folder / "fall.toml" + "'");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["said"], json::array()) << "the console is silent";
  EXPECT_TRUE(seen["can"]);
  EXPECT_EQ(seen["title"], "floor: plane, post: capsule");
  EXPECT_EQ(seen["above"], 0);
  // The lower side of the bar: 5 x 3 vertices.
  EXPECT_EQ(seen["lying"], 15);
  EXPECT_TRUE(seen["tug"]);
  EXPECT_GT(seen["beside"]["solid"], 200);
  EXPECT_EQ(seen["beside"]["touch"], 0) << "only flesh is marked as touching";
  EXPECT_TRUE(seen["unchecked"]);
  EXPECT_GT(seen["shown"]["solid"].get<int>(), seen["hidden"]["solid"].get<int>() + 1000);
  EXPECT_GT(seen["shown"]["touch"].get<int>(), seen["hidden"]["touch"].get<int>() + 20);
  EXPECT_EQ(seen["names"], json({"Energy", "Volume", "Solver speed"}))
      << "a bar has no skinning to lag behind";
  EXPECT_EQ(seen["axe"], json::array());
  EXPECT_EQ(seen["ended"], 0);
}

// A script that fails or is killed at its time limit leaves no studio running.
TEST(StudioPage, EndsWithTheScriptThatStartedIt) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "bar.toml", resting_bar);
  const json seen = used_studio("studio-ends", "studio_ends.mjs", "'" + folder / "bar.toml" + "'");
  ASSERT_TRUE(seen.is_object());
  for (const char* how : {"fails", "killed"}) EXPECT_EQ(seen[how]["is_there"], false) << how;
  EXPECT_EQ(seen["killed"]["was_there"], true) << "the control";
}

// A character, and a bake's folder, which is opened read-only.
TEST(StudioPage, OpensCharactersAndBakes) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  const Outcome made = fascicle({"bake", "arm", "-o", folder / "arm", "--end", "0.2", "--device", "cpu"});
  ASSERT_EQ(made.status, 0) << made.err;
  for (const auto& [input, can_touch] :
       {std::pair(folder / "arm/character.glb", true), std::pair(folder / "arm", false)}) {
    SCOPED_TRACE(input);
    const json seen =
        used_studio(can_touch ? "studio-character" : "studio-bake", "studio_opens.mjs", "'" + input + "'");
    ASSERT_TRUE(seen.is_object());
    EXPECT_EQ(seen["said"], json::array());
    EXPECT_TRUE(seen["moves"]);
    EXPECT_EQ(seen["can_touch"], can_touch);
    EXPECT_GT(seen["body"].get<double>(), 0.01) << "share of the picture";
    EXPECT_EQ(seen["axe"], json::array());
    EXPECT_EQ(seen["ended"], 0);
  }
}

}  // namespace
}  // namespace fascicle::tests
