// fascicle view: a separate decoder shows that the page contains the bake; its output, and what it refuses.
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/sealed_json.h"
#include "host/page/bake_page.h"
#include "tests/cli/changed_glb.h"
#include "tests/cli/nodding_body.h"
#include "tests/cli/program.h"
#include "tests/support/assets.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool have_node() {
  return std::system("node --version > /dev/null 2>&1") == 0;
}

// The output of the decoder in tests/readers, which needs node but no npm packages; not an object if it
// fails.
json decoded_page(const std::string& page, const std::string& cache) {
  const TemporaryFolder folder;
  const std::string command = std::string("node '") + FASCICLE_SOURCE_DIR +
                              "/tests/readers/decode_page.mjs' '" + page + "' '" + cache + "' > '" +
                              folder / "out" + "' 2> '" + folder / "err" + "'";
  if (std::system(command.c_str()) != 0) return json(read_text(folder / "err"));
  return json::parse(read_text(folder / "out"), nullptr, false);
}

void bake_of(const std::string& scene, const std::string& out, const std::vector<std::string>& more) {
  std::vector<std::string> command{"bake", scene, "-o", out, "--device", "cpu"};
  command.insert(command.end(), more.begin(), more.end());
  const Outcome outcome = fascicle(command);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
}

TEST(View, EveryVertexOfEveryFrameIsWithinWhatIsStated) {
  FASCICLE_NEEDS(have_node(), "FASCICLE_REQUIRE_READERS", "node on the PATH");
  std::vector<std::string> scenes{"arm", "bar-layers-iii"};
  if (fs::exists(asset("CesiumMan.glb")))
    scenes.push_back(asset("CesiumMan.glb").string());
  else
    EXPECT_FALSE(assets_are_required());
  for (const std::string& scene : scenes) {
    SCOPED_TRACE(scene);
    const TemporaryFolder folder;
    // Self-contact takes most of the man's bake and does not matter here.
    const bool is_arm = scene == "arm";
    bake_of(scene, folder / "bake",
            {"--end", is_arm ? "1" : "0.3", "--format", "pc2", "--set", "contact.self=false"});
    const Outcome outcome = fascicle({"view", folder / "bake", "-o", folder / "page.html", "--json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json said = json::parse(outcome.out);
    EXPECT_EQ(said["bytes"], fs::file_size(folder / "page.html"));
    const json found = decoded_page(folder / "page.html", folder / "bake/surface.pc2");
    ASSERT_TRUE(found.is_object()) << found;
    EXPECT_EQ(found["frames"], found["cache_frames"]);
    EXPECT_EQ(said["frames"], found["frames"]);
    EXPECT_EQ(said["vertices"], found["cache_vertices"]);
    EXPECT_EQ(found["left_over"], 0);
    EXPECT_EQ(said["error"], found["stated"]);
    // The grid's step is a double; its multiples are off by less than a billionth of it.
    EXPECT_LE(found["largest"].get<double>(), found["stated"].get<double>() * (1 + 1e-6));
    // The bound must not be far too generous, or a page without motion could meet it.
    EXPECT_GT(found["largest"].get<double>(), 0.5 * found["stated"].get<double>());
    EXPECT_LE(found["stated"].get<double>(), 2e-4);
    if (is_arm) {
      EXPECT_GT(*std::max_element(found["lag"].begin(), found["lag"].end()), 1e-3);
    }
  }
}

// The control: a page with one changed byte is detected.
TEST(View, ADamagedPageIsSeen) {
  FASCICLE_NEEDS(have_node(), "FASCICLE_REQUIRE_READERS", "node on the PATH");
  const TemporaryFolder folder;
  bake_of("bar-layers-iii", folder / "bake", {"--end", "0.1", "--format", "pc2"});
  ASSERT_EQ(fascicle({"view", folder / "bake", "-o", folder / "page.html"}).status, 0);
  std::string page = read_text(folder / "page.html");
  const std::size_t motion = page.find("\"motion\":\"");
  ASSERT_NE(motion, std::string::npos);
  char& digit = page[motion + (page.find('"', motion + 10) - motion) * 3 / 4];
  digit = digit == 'A' ? 'B' : 'A';
  write_text(folder / "page.html", page);
  const json found = decoded_page(folder / "page.html", folder / "bake/surface.pc2");
  // Either decoding ends too early or too late, or positions differ.
  const bool is_seen =
      !found.is_object() || found["largest"].get<double>() > 2 * found["stated"].get<double>();
  EXPECT_TRUE(is_seen) << found;
}

TEST(View, TheErrorIsAsAskedFor) {
  const TemporaryFolder folder;
  bake_of("arm", folder / "bake", {"--end", "0.2"});
  const auto view = [&](const std::string& error) {
    const Outcome outcome = fascicle(
        {"view", folder / "bake", "-o", folder / "page.html", "--overwrite", "--json", "--error", error});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return json::parse(outcome.out);
  };
  const json fine = view("0.01"), coarse = view("1");
  EXPECT_NEAR(fine["error"].get<double>(), 1e-5, 1e-9);
  EXPECT_NEAR(coarse["error"].get<double>(), 1e-3, 1e-7);
  EXPECT_LT(coarse["bytes"].get<double>(), fine["bytes"].get<double>());
  // A nanometre exceeds the page's number range; this is an error rather than silently rounded up.
  const Outcome refused =
      fascicle({"view", folder / "bake", "-o", folder / "page.html", "--overwrite", "--error", "1e-6"});
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_TRUE(contains(refused.err, "less than a page can reach")) << refused.err;
}

// The requirement: 90 frames of 13,000 vertices below 6 MB, including three.js.
TEST(View, NinetyFramesOfThirteenThousandVerticesAreBelowSixMegabytes) {
  const TemporaryFolder folder;
  write_text(folder / "body.gltf", nodding_body(130, 100));
  bake_of(folder / "body.gltf", folder / "bake",
          {"--end", "1.5", "--fps", "60", "--resolution", "2000", "--set", "contact.self=false"});
  const Outcome outcome = fascicle({"view", folder / "bake", "-o", folder / "page.html", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json said = json::parse(outcome.out);
  EXPECT_GE(said["vertices"], 13000);
  EXPECT_GE(said["frames"], 90);
  EXPECT_LE(said["error"].get<double>(), 1.5e-4);
  EXPECT_LT(said["bytes"].get<double>(), 6e6);
  RecordProperty("bytes", said["bytes"].dump());
}

TEST(View, NamesTheFloorThatItsCameraLeavesOut) {
  const TemporaryFolder folder;
  write_text(folder / "body.gltf", nodding_body(12, 10, 10.0));
  bake_of(folder / "body.gltf", folder / "bake", {"--end", "0.1", "--resolution", "300"});
  const Outcome outcome = fascicle({"view", folder / "bake", "-o", folder / "page.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string page = read_text(folder / "page.html"), head = "id=\"bake\">";
  const std::size_t begin = page.find(head) + head.size();
  const json bake = json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  EXPECT_EQ(bake["surroundings"].size(), 21u * 21u);
  EXPECT_EQ(bake["places"], 12 * 10 + 2 + 21 * 21);
}

TEST(View, BadUsageAndBadInputAreToldApart) {
  const TemporaryFolder folder;
  bake_of("bar-layers-iii", folder / "bake", {"--end", "0.1"});
  const std::string page = folder / "page.html";
  EXPECT_EQ(fascicle({"view", folder / "bake"}).status, 2);
  EXPECT_EQ(fascicle({"view", folder / "bake", "-o", folder / "page.png"}).status, 2);
  EXPECT_EQ(fascicle({"view", folder / "bake", "-o", page, "--error", "0"}).status, 2);
  EXPECT_EQ(fascicle({"view", folder / "nowhere", "-o", page}).status, 3);
  EXPECT_EQ(fascicle({"view", folder / "bake", "-o", folder / "nowhere/page.html"}).status, 3);
  EXPECT_FALSE(fs::exists(page));
  const Outcome first = fascicle({"view", folder / "bake", "-o", page});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_TRUE(contains(first.out, "no vertex is further than")) << first.out;
  const std::string before = read_text(page);
  const Outcome again = fascicle({"view", folder / "bake", "-o", page});
  EXPECT_EQ(again.status, 2);
  EXPECT_TRUE(contains(again.err, "--overwrite")) << again.err;
  EXPECT_EQ(fascicle({"view", folder / "bake", "-o", page, "--overwrite"}).status, 0);
  EXPECT_TRUE(read_text(page) == before) << "the same bake gives the same page";
}

// The bake's files are not trusted: as for an export, damage is an error, and no page is written.
TEST(View, ADamagedBakeIsRefused) {
  const TemporaryFolder folder;
  bake_of("arm", folder / "whole", {"--end", "0.1"});
  for (const char* file : {"frames.fascicle", "model.fascicle", "character.glb", "manifest.json"}) {
    SCOPED_TRACE(file);
    fs::remove_all(folder / "bake");
    fs::copy(folder / "whole", folder / "bake", fs::copy_options::recursive);
    std::string bytes = read_text(folder / ("bake/" + std::string(file)));
    bytes.resize(bytes.size() / 2);
    write_text(folder / ("bake/" + std::string(file)), bytes);
    const Outcome outcome = fascicle({"view", folder / "bake", "-o", folder / "page.html"});
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_EQ(outcome.signal, 0);
    EXPECT_TRUE(contains(outcome.err, "bake")) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "page.html"));
  }
}

// A bake of a character with materials of each kind of alpha: below the page's cutoff lies what alpha times
// the base colour's alpha puts below the material's.
TEST(View, CutoffsAreThoseOfTheTexturesAlpha) {
  const TemporaryFolder folder;
  bake_of("arm", folder / "bake", {"--end", "0.1"});
  const auto cutoff = [&](double alpha, const char* mode, double of_material) {
    change_glb(folder / "bake/character.glb", [&](json& document) {
      document["materials"] = json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, alpha}}}},
                                            {"alphaMode", mode},
                                            {"alphaCutoff", of_material}}});
      for (json& mesh : document["meshes"])
        for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
    });
    const Outcome outcome = fascicle({"view", folder / "bake", "-o", folder / "page.html", "--overwrite"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const std::string page = read_text(folder / "page.html");
    const std::size_t data = page.find("id=\"bake\">") + 10;
    return json::parse(page.substr(data, page.find("</script>", data) - data))["materials"][0]["cutoff"]
        .get<double>();
  };
  // A material that is cut, at texels of alpha 0 to 1, and one that is not.
  for (const double alpha : {1.0, 0.8, 0.5, 0.25, 0.0}) {
    const double of_texture = cutoff(alpha, "MASK", 0.5);
    for (const double texel : {0.0, 0.3, 0.55, 0.7, 0.97, 1.0})
      EXPECT_EQ(texel < of_texture, alpha * texel < 0.5) << alpha << " " << texel;
  }
  EXPECT_EQ(cutoff(0.3, "OPAQUE", 0.5), 0.0);
}

// An interrupt in whichever step leaves no page, and there are three steps a frame.
TEST(View, StopsAfterAnyStep) {
  const TemporaryFolder folder;
  bake_of("arm", folder / "bake", {"--end", "0.1"});
  page::PageOptions options;
  options.bake = folder / "bake";
  std::vector<std::uint64_t> steps;
  options.on_step = [&](std::uint64_t done, std::uint64_t of) {
    steps.push_back(done);
    EXPECT_LE(done, of);
    EXPECT_EQ(of % 3, 0u);
  };
  const page::PageResult whole = page::page_of_bake(options);
  EXPECT_FALSE(whole.interrupted);
  ASSERT_EQ(steps.size(), 3 * whole.frames);
  for (std::size_t k = 0; k < steps.size(); ++k) EXPECT_EQ(steps[k], k + 1);
  std::atomic<bool> interrupted = false;
  options.interrupted = &interrupted;
  for (std::uint64_t stop = 1; stop <= steps.size(); ++stop) {
    interrupted = false;
    options.on_step = [&](std::uint64_t done, std::uint64_t) {
      EXPECT_LE(done, stop) << "it goes on";
      interrupted = done == stop;
    };
    const page::PageResult result = page::page_of_bake(options);
    EXPECT_TRUE(result.interrupted) << stop;
    EXPECT_EQ(result.html, "") << stop;
  }
}

// A scene's name may contain markup.
TEST(View, NamesStayText) {
  const TemporaryFolder folder;
  const std::string name = "</script><img src=x onerror=alert(1)>@BAKE@&amp;";
  bake_of("bar-layers-iii", folder / "bake", {"--end", "0.1"});
  json manifest = json::parse(read_text(folder / "bake/manifest.json"));
  manifest["scene"]["name"] = name;
  write_text(folder / "bake/manifest.json", bake::sealed_text(manifest, 1));
  ASSERT_EQ(fascicle({"view", folder / "bake", "-o", folder / "page.html"}).status, 0);
  const std::string page = read_text(folder / "page.html");
  EXPECT_FALSE(contains(page, "<img src=x")) << "the name is markup";
  const std::size_t data = page.find("id=\"bake\">") + 10;
  const json kept = json::parse(page.substr(data, page.find("</script>", data) - data));
  EXPECT_EQ(kept["scene"], name);
}

}  // namespace
}  // namespace fascicle::tests
