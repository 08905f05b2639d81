// The page of fascicle view in a real Chromium: web/tests/view.mjs uses it, and this test judges what it
// reports.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/nodding_body.h"
#include "tests/cli/program.h"
#include "tests/support/web.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A folder that keeps screenshots for people to look at.
fs::path shots(const std::string& name) {
  const fs::path folder = fs::path(FASCICLE_BINARY_DIR) / "screenshots" / name;
  fs::create_directories(folder);
  return folder;
}

json page_of(const std::string& scene, const std::string& folder, const std::vector<std::string>& more) {
  std::vector<std::string> bake{"bake", scene, "-o", folder + "/bake", "--device", "cpu"};
  bake.insert(bake.end(), more.begin(), more.end());
  const Outcome baked = fascicle(bake);
  EXPECT_EQ(baked.status, 0) << baked.err;
  const Outcome viewed = fascicle({"view", folder + "/bake", "-o", folder + "/page.html"});
  EXPECT_EQ(viewed.status, 0) << viewed.err;
  const std::string command = std::string("node '") + FASCICLE_SOURCE_DIR +
                              "/tests/readers/decode_page.mjs' '" + folder + "/page.html' > '" + folder +
                              "/decoded'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  return json::parse(read_text(folder + "/decoded"), nullptr, false);
}

json used_page(const std::string& script, const std::string& folder, const fs::path& pictures,
               const std::string& arguments) {
  const std::string log = folder + "/log";
  EXPECT_EQ(run_web("timeout 1200 node tests/" + script + " '" + folder + "/page.html' '" +
                        pictures.string() + "' " + arguments,
                    log),
            0)
      << read_text(log);
  return json::parse(read_text(pictures / "report.json"), nullptr, false);
}

double share(const json& seen, const char* of) {
  return seen[of].get<double>() / seen["pixels"].get<double>();
}

// The share of the body's pixels with a hue between two angles.
double of_hue(const json& seen, int from, int to) {
  double sum = 0.0;
  for (int hue = from; hue != to; hue = (hue + 10) % 360)
    sum += seen["hues"][static_cast<std::size_t>(hue / 10)].get<double>();
  return sum / seen["body"].get<double>();
}

TEST(ViewPage, InChromium) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  const json decoded = page_of("arm", folder.path().string(), {"--end", "1"});
  ASSERT_TRUE(decoded.is_object());
  const auto lag = decoded["lag"].get<std::vector<double>>();
  const auto least = std::min_element(lag.begin(), lag.end()) - lag.begin();
  const auto most = std::max_element(lag.begin(), lag.end()) - lag.begin();
  const json seen = used_page("view.mjs", folder.path().string(), shots("view"),
                              std::to_string(least) + " " + std::to_string(most));
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["state"], "ready");
  EXPECT_EQ(seen["said"], json::array()) << "the console is silent";
  ASSERT_EQ(seen["asked"].size(), 1u) << seen["asked"].dump();
  EXPECT_TRUE(seen["asked"][0].get<std::string>().starts_with("file://"));

  EXPECT_TRUE(seen["plays"]);
  EXPECT_TRUE(seen["stays"]) << "the keyboard stops it";
  const double last = decoded["frames"].get<double>() - 1;
  EXPECT_NEAR(seen["scrubbed"].get<double>(), 0.5 * last, 2.0);
  EXPECT_NEAR(seen["scrubbed_on_curves"].get<double>(), 0.25 * last, 2.0);

  // From the front the body has its true ratio of width to height, except for perspective: the camera is
  // about five times as far away as the body is deep.
  const json& pictures = seen["pictures"];
  const auto box = pictures["front"]["box"].get<std::vector<double>>();
  const json& first = decoded["first_box"];
  const double wide = first["most"][0].get<double>() - first["least"][0].get<double>(),
               high = first["most"][1].get<double>() - first["least"][1].get<double>();
  EXPECT_NEAR((box[2] - box[0]) / (box[3] - box[1]) / (wide / high), 1.0, 0.2);
  EXPECT_GT(share(pictures["front"], "body"), 0.02);
  EXPECT_LT(share(pictures["front"], "body"), 0.6);

  // Ghost and flesh differ where flesh lags, side by side too.
  EXPECT_GT(seen["ghost_differs"].get<double>(), 0.004 * pictures["flesh"]["body"].get<double>());
  EXPECT_GT(pictures["ghost"]["blue"], pictures["flesh"]["blue"]);
  EXPECT_GT(share(pictures["left"], "body"), 0.01);
  EXPECT_GT(share(pictures["right"], "body"), 0.01);
  EXPECT_GT(seen["sides_differ"].get<double>(), 0.002 * pictures["left"]["body"].get<double>());
  // The outside of the arm shows muscle, red, and fat, yellow; the plain skin shows neither.
  EXPECT_GT(of_hue(pictures["layers"], 350, 10), 0.2);
  EXPECT_GT(of_hue(pictures["layers"], 40, 50), 0.2);
  EXPECT_GT(of_hue(pictures["flesh"], 10, 30), 0.9);
  // Large lag is green and yellow, the smallest is dark violet.
  EXPECT_GT(pictures["most_lag"]["bright"].get<double>(), 0.01 * pictures["most_lag"]["body"].get<double>());
  EXPECT_LT(pictures["least_lag"]["bright"].get<double>(),
            0.5 * pictures["most_lag"]["bright"].get<double>());

  for (const auto& [key, did] : seen["keys"].items()) EXPECT_TRUE(did.get<bool>()) << "key " << key;
  EXPECT_EQ(seen["keys"].size(), seen["shown_keys"]) << "the help has keys that were not tried";
  EXPECT_TRUE(seen["help_closed"]);
  for (const auto& [what, violations] : seen["axe"].items())
    EXPECT_EQ(violations, json::array()) << "axe-core, " << what;
  const auto reached = seen["reached"].get<std::vector<std::string>>();
  for (const char* control :
       {"theme", "help-open", "picture", "colouring", "comparison", "three-quarter", "back", "follow",
        "edges", "floor", "first", "play", "forward", "last", "scrub", "loop", "speed"})
    EXPECT_TRUE(std::find(reached.begin(), reached.end(), control) != reached.end())
        << control << " is not reached by Tab";
  EXPECT_LE(seen["overflows"]["across"], 0);
  EXPECT_LE(seen["overflows"]["down"], 0);
  EXPECT_EQ(seen["overflows"]["outside"], json::array());
}

// A layered body without a character: every layer at the surface shows its colour, and the ghost is its rest
// shape.
TEST(ViewPage, OfBodiesThatAreNoCharacters) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  const json decoded = page_of("bar-layers-iii", folder.path().string(), {"--end", "0.5"});
  ASSERT_TRUE(decoded.is_object());
  const json seen = used_page("bodies.mjs", folder.path().string(), shots("view-bar"), "");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["state"], "ready");
  EXPECT_EQ(seen["said"], json::array());
  EXPECT_EQ(seen["ghost"], "the rest shape");
  // By the legend's colours, each layer covers part of the body.
  for (const auto& [layer, part] : seen["layers"].items()) EXPECT_GT(part.get<double>(), 0.03) << layer;
  EXPECT_GE(seen["layers"].size(), 2u);
}

// A floor of 20 m in the character's file would leave less than a hundredth of what is drawn to the body.
TEST(ViewPage, FitsTheBodyAndNotItsFloor) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "body.gltf", nodding_body(12, 10, 10.0));
  const json decoded =
      page_of(folder / "body.gltf", folder.path().string(), {"--end", "0.1", "--resolution", "300"});
  ASSERT_TRUE(decoded.is_object());
  const json seen = used_page("bodies.mjs", folder.path().string(), shots("view-floor"), "");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["state"], "ready");
  EXPECT_GT(seen["layers"]["fat"].get<double>(), 0.1) << seen["layers"];
}

// A cube that slides down a slope, with a camera that follows it, in a browser that loses its GPU.
TEST(ViewPage, OfABodyThatTravels) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  write_text(folder / "slide.toml",
             "[scene]\nfps = 23.976\nend = 1.5\n[bar]\nsize = [0.3, 0.3, 0.3]\nvertices = [3, 3, 3]\n"
             "[layers.flesh]\nyoungs_modulus = 50e3\ndamping = 3.0\ndensity = 1000.0\n"
             "[solver]\nintegrator = \"implicit\"\nsubsteps = \"auto\"\n"
             "[collider.slope]\nshape = \"plane\"\ncenter = [0.0, -0.3, 0.0]\nnormal = [0.0, 1.0, 0.5]\n"
             "friction = 0.0\n");
  const json decoded = page_of(folder / "slide.toml", folder.path().string(), {});
  ASSERT_TRUE(decoded.is_object());
  const json seen = used_page("upsets.mjs", folder.path().string(), shots("view-upsets"), "");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["state"], "ready");
  EXPECT_TRUE(contains(seen["subtitle"].get<std::string>(), "37 frames at 23.976 fps")) << seen["subtitle"];
  // 36 / 23.976
  EXPECT_TRUE(contains(seen["facts"].get<std::string>(), "Duration1.502 s")) << seen["facts"];
  // After the loss the same picture comes back; an empty stage would differ by all that is shown.
  EXPECT_GT(seen["background"].get<double>(), 0.05);
  EXPECT_LT(seen["differs_after_loss"].get<double>(), 0.002);
  // The camera follows the cube down. At the end of the slope its page has a floor below it, lines and
  // shadow.
  EXPECT_TRUE(seen["follows"]);
  EXPECT_GT(seen["floor_at_last"].get<double>(), 0.01);
  // Every control is on the screen of a phone, or scrolled to within what is, and the picture has room.
  EXPECT_EQ(seen["sizes"].size(), 3u);
  for (const auto& [size, page] : seen["sizes"].items()) {
    EXPECT_LE(page["across"], 0) << size;
    EXPECT_LE(page["down"], 0) << size;
    EXPECT_GT(page["scrub"], 0.8) << size;
    EXPECT_GE(page["picture"][0], 150) << size;
    EXPECT_GE(page["picture"][1], 60) << size;
    EXPECT_GE(page["aside"], 60) << size;
    EXPECT_TRUE(page["scrolls"]) << size;
    EXPECT_LE(page["under_footer"], 0) << size;
    EXPECT_EQ(page["outside"], json::array()) << size;
  }
  // three.js logs both events, and nobody warns.
  for (const json& text : seen["said"]) EXPECT_TRUE(text.get<std::string>().starts_with("log: ")) << text;
}

// The control: a truncated page reports it, and shows no body.
TEST(ViewPage, OfDamagedDataSaysSo) {
  FASCICLE_NEEDS_CHROMIUM;
  const TemporaryFolder folder;
  const json decoded = page_of("bar-layers-iii", folder.path().string(), {"--end", "0.1"});
  ASSERT_TRUE(decoded.is_object());
  std::string page = read_text(folder / "page.html");
  const std::size_t motion = page.find("\"motion\":\"") + 10;
  page.erase(motion + 400, page.find('"', motion) - motion - 400);
  write_text(folder / "page.html", page);
  const json seen = used_page("bodies.mjs", folder.path().string(), shots("view-damaged"), "");
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["state"], "failed");
  EXPECT_TRUE(contains(seen["failure"].get<std::string>(), "too early")) << seen["failure"];
}

}  // namespace
}  // namespace fascicle::tests
