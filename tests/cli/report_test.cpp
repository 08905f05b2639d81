// fascicle report: the page is well-formed, agrees with the bake's files, shows the body, and trusts no
// input.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <png.h>
#include <pugixml.hpp>

#include "host/bake/sealed_json.h"
#include "tests/cli/program.h"

namespace fascicle::tests::report_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

pugi::xml_document page_at(const std::string& path) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_file(path.c_str());
  EXPECT_TRUE(result) << result.description() << " at " << result.offset;
  return document;
}

// All text below a node.
std::string text_of(const pugi::xml_node& node) {
  std::string text;
  for (const pugi::xpath_node& one : node.select_nodes(".//text()")) text += one.node().value();
  return text;
}

struct Pixels {
  unsigned width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

std::string decoded(const std::string& base64) {
  std::string bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : base64) {
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t digit = digits.find(c);
    if (digit == std::string::npos) break;
    word = (word << 6U) | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>((word >> static_cast<unsigned>(bits)) & 255U);
  }
  return bytes;
}

Pixels picture_of(const pugi::xml_node& image) {
  const std::string source = image.attribute("src").value(), head = "data:image/png;base64,";
  EXPECT_TRUE(source.starts_with(head));
  const std::string bytes = decoded(source.substr(head.size()));
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0) << png.message;
  png.format = PNG_FORMAT_RGB;
  Pixels pixels{png.width, png.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(png))};
  EXPECT_NE(png_image_finish_read(&png, nullptr, pixels.rgb.data(), 0, nullptr), 0) << png.message;
  EXPECT_EQ(std::to_string(pixels.width), image.attribute("width").value());
  EXPECT_EQ(std::to_string(pixels.height), image.attribute("height").value());
  return pixels;
}

// The fraction of pixels that show skin; ground and sky are grey.
double share_of_skin(const Pixels& pixels) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < pixels.rgb.size(); k += 3)
    count += pixels.rgb[k] > pixels.rgb[k + 2] + 25 ? 1u : 0u;
  return 3.0 * static_cast<double>(count) / static_cast<double>(pixels.rgb.size());
}

class ReportPage : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_ = new TemporaryFolder;
    for (const auto& [name, end] : {std::pair{"arm", "0.7"}, std::pair{"short", "0.02"}}) {
      const Outcome baked =
          fascicle({"bake", "arm", "-o", *made_ / name, "--end", end, "--device", "cpu", "-q"});
      ASSERT_EQ(baked.status, 0) << baked.err;
    }
    const Outcome outcome = fascicle({"report", *made_ / "arm", "-o", *made_ / "arm.html", "--threads", "1"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  static void TearDownTestSuite() {
    delete made_;
    made_ = nullptr;
  }
  // The page of the long bake as it is: its pictures take seconds.
  static pugi::xml_document page_as_made() { return page_at(*made_ / "arm.html"); }
  // A bake of two frames to change: a page of it takes less time.
  void SetUp() override { fs::copy(*made_ / "short", bake_, fs::copy_options::recursive); }

  Outcome report() const {
    return fascicle({"report", bake_, "-o", folder_ / "page.html", "--threads", "1"});
  }
  pugi::xml_document good_page() const {
    const Outcome outcome = report();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.out, "wrote " + folder_ / "page.html")) << outcome.out;
    return page_at(folder_ / "page.html");
  }
  void change_manifest(const json& patch) const {
    json manifest = json::parse(read_text(bake_ + "/manifest.json"));
    manifest.merge_patch(patch);
    write_text(bake_ + "/manifest.json", bake::sealed_text(manifest));
  }
  // After any failure: one message, the exit code, and no page, not even part of one.
  void expect_none(const Outcome& outcome, int status, const std::string& part) const {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_EQ(outcome.signal, 0);
    EXPECT_TRUE(contains(outcome.err, part)) << outcome.err;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path()))
      EXPECT_EQ(entry.path().string(), bake_);
  }

  static TemporaryFolder* made_;
  const TemporaryFolder folder_;
  const std::string bake_ = folder_ / "bake";
};
TemporaryFolder* ReportPage::made_ = nullptr;

TEST_F(ReportPage, SaysWhatTheMetricsSay) {
  const pugi::xml_document page = page_as_made();
  // Parses metrics.csv independently: the maximum of each column and its first frame.
  std::istringstream file(read_text(*made_ / "arm/metrics.csv"));
  const auto cells = [&file] {
    std::string line, cell;
    std::getline(file, line);
    std::istringstream in(line);
    std::vector<std::string> found;
    while (std::getline(in, cell, ',')) found.push_back(cell);
    return found;
  };
  const std::vector<std::string> columns = cells();
  std::map<std::string, std::pair<double, std::string>> largest;
  for (std::vector<std::string> row = cells(); !row.empty(); row = cells())
    for (std::size_t c = 2; c < columns.size(); ++c) {
      if (columns[c] == "worst_joint") continue;
      const double value = std::stod(row[c]);
      const auto [at, is_new] = largest.try_emplace(columns[c], value, row[0]);
      if (!is_new && value > at->second.first) at->second = {value, row[0]};
    }
  std::size_t compared = 0;
  for (const pugi::xpath_node& row : page.select_nodes("//section[@id='curves']//details//tbody/tr")) {
    const std::string column = row.node().child("th").child_value();
    ASSERT_TRUE(largest.contains(column)) << column;
    const pugi::xml_node value = row.node().child("td");
    // Six digits are shown.
    EXPECT_NEAR(std::stod(value.child_value()), largest[column].first, 1e-5 * std::abs(largest[column].first))
        << column;
    EXPECT_EQ(value.next_sibling("td").child_value(), largest[column].second) << column;
    ++compared;
  }
  EXPECT_EQ(compared, largest.size());
  EXPECT_GE(compared, 20u);
  // One plot for each kind of column here: lag, look, energy, volume, inverted.
  EXPECT_EQ(page.select_nodes("//section[@id='curves']//figure[@class='plot']").size(), 5u);
  const pugi::xpath_node_set lags =
      page.select_nodes("//svg[@aria-label='Lag behind skinning, by layer']/path");
  EXPECT_EQ(lags.size(), 3u);  // fat, muscle, bone
}

TEST_F(ReportPage, SaysWhereItIsFrom) {
  const std::string text = text_of(page_as_made().document_element());
  const json manifest = json::parse(read_text(*made_ / "arm/manifest.json"));
  for (const std::string& word :
       {manifest["position_hashes"].back().get<std::string>(), manifest["model"]["hash"].get<std::string>(),
        manifest["inputs"][0]["xxh3_64"].get<std::string>(), manifest["device"]["name"].get<std::string>(),
        manifest["fascicle"]["version"].get<std::string>(), std::string("biceps"), std::string("upper_arm")})
    EXPECT_TRUE(contains(text, word)) << word;
}

TEST_F(ReportPage, ShowsTheBodyBesideSkinning) {
  const pugi::xml_document page = page_as_made();
  const pugi::xpath_node_set stills = page.select_nodes("//section[@id='stills']//figure");
  ASSERT_EQ(stills.size(), 6u);
  std::size_t different = 0;
  for (const pugi::xpath_node& still : stills) {
    const pugi::xpath_node_set images = still.node().select_nodes(".//img");
    ASSERT_EQ(images.size(), 2u);
    const Pixels skinned = picture_of(images[0].node()), flesh = picture_of(images[1].node());
    for (const Pixels* one : {&skinned, &flesh}) {
      EXPECT_GE(share_of_skin(*one), 0.04);
      EXPECT_LE(share_of_skin(*one), 0.6);
    }
    different += skinned.rgb != flesh.rgb ? 1 : 0;
  }
  // At rest in the first frame, with a bent elbow in the last.
  EXPECT_GE(different, 3u);
  const pugi::xpath_node_set body = page.select_nodes("//section[@id='body']//img");
  ASSERT_EQ(body.size(), 3u);
  EXPECT_GE(share_of_skin(picture_of(body[0].node())), 0.04);
  // The arm is one closed part, before and after.
  const std::string table = text_of(page.select_node("//section[@id='body']//table").node());
  EXPECT_TRUE(contains(table, "Open edges00")) << table;
  EXPECT_TRUE(contains(table, "Separate parts11")) << table;
}

TEST_F(ReportPage, WarningsHaveTheirFrame) {
  change_manifest(
      {{"warnings",
        {"look: frame 1: something is wrong at joint \"hand\"", "frame 99999 is not there",
         "the subframe 1 and frame 1st are none", "frame 99999999999999999999999 is none either"}}});
  const pugi::xml_document page = good_page();
  const pugi::xpath_node_set notes = page.select_nodes("//section[@id='warnings']/ul/li");
  ASSERT_EQ(notes.size(), 4u);
  EXPECT_EQ(notes[0].node().select_nodes(".//img").size(), 2u);
  EXPECT_TRUE(contains(text_of(notes[0].node()), "Frame 1,"));
  for (std::size_t k = 1; k < notes.size(); ++k)
    EXPECT_EQ(notes[k].node().select_nodes(".//img").size(), 0u) << k;
}

// Any text in the folder may be hostile.
TEST_F(ReportPage, WhatStrangersWroteStaysText) {
  const std::string bad =
      "</p></style><script>alert(1)</script><img src=x onerror=alert(2)> \"' \x1b[2J\xe2\x80\xae";
  change_manifest({{"warnings", {bad, "frame 1 " + bad}},
                   {"status", bad},
                   {"message", bad},
                   {"fascicle", {{"version", bad}}},
                   {"device", {{"name", bad}, {"driver", bad}}},
                   {"scene", {{bad, bad}, {"layers", {{{"name", bad}, {bad, {bad}}}}}}},
                   {"model", {{"layers", {{{"name", bad}}}}, {"vertices", bad}}},
                   {"open_ends", {{{"joint", bad}, {"became", bad}, {"width_m", bad}}, bad}},
                   {"inputs", {{{"file", bad}, {"xxh3_64", bad}}}}});
  std::string metrics = read_text(bake_ + "/metrics.csv");
  metrics.replace(metrics.find("kinetic_energy"), 14, "<b>onclick</b>");
  write_text(bake_ + "/metrics.csv", metrics);
  const pugi::xml_document page = good_page();
  EXPECT_TRUE(page.select_nodes("//script | //b | //iframe").empty());
  EXPECT_EQ(page.select_nodes("//style").size(), 1u);
  for (const pugi::xpath_node& node : page.select_nodes("//@*"))
    EXPECT_FALSE(std::string(node.attribute().name()).starts_with("on"));
  const std::string text = text_of(page.document_element());
  EXPECT_TRUE(contains(text, "<script>alert(1)</script>"));
  EXPECT_TRUE(contains(text, "\\x1b[2J\\u202e"));
  EXPECT_TRUE(contains(text, "<b>onclick</b>"));
  const std::string raw = read_text(folder_ / "page.html");
  EXPECT_FALSE(contains(raw, "\x1b") || contains(raw, "\xe2\x80\xae") || contains(raw, "<script"));
}

// Values of unexpected types must not make it fail.
TEST_F(ReportPage, AManifestMayHoldAnything) {
  for (const json& wrong : {json(7), json::array({1, json::object()}), json(nullptr)}) {
    for (const char* key :
         {"scene", "model", "open_ends", "timings", "look", "fascicle", "device", "warnings"})
      change_manifest({{key, wrong}});
    const Outcome outcome = fascicle({"report", bake_, "-o", folder_ / "page.html", "--overwrite"});
    EXPECT_EQ(outcome.status, 0) << wrong << outcome.err;
    (void)page_at(folder_ / "page.html");
    change_manifest({{"frames_kept", false}});  // pictures take time and do not change
  }
  // Nested deeper than a page shows, and so deep that recursion would overflow the stack.
  const auto report_nested = [&](std::size_t levels) {
    const std::string deep = std::string(levels, '[') + std::string(levels, ']');
    write_text(bake_ + "/manifest.json",
               "{\"kind\": \"fascicle bake\", \"frames_kept\": false, \"scene\": {\"a\": " + deep +
                   "}, \"model\": " + deep + "}");
    return fascicle({"report", bake_, "-o", folder_ / "page.html", "--overwrite"});
  };
  EXPECT_EQ(report_nested(50).status, 0);
  const Outcome refused = report_nested(1000000);
  EXPECT_EQ(refused.signal, 0);
  EXPECT_EQ(refused.status, 3) << refused.err;
}

TEST_F(ReportPage, IsThereWholeOrNotAtAll) {
  expect_none(fascicle({"report", folder_ / "nowhere", "-o", folder_ / "page.html"}), 3, "nowhere");
  expect_none(fascicle({"report", bake_, "-o", folder_ / "none/page.html"}), 3, "none");
  expect_none(fascicle({"report", bake_, "-o", bake_}), 2, "is a folder");
  expect_none(fascicle({"report", bake_}), 2, "--output");
  // Flips a bit in every 256 bytes of the second half, so in a frame that is shown too.
  std::string frames = read_text(bake_ + "/frames.fascicle");
  for (std::size_t at = frames.size() / 2; at < frames.size(); at += 256)
    frames[at] = static_cast<char>(frames[at] ^ 1);
  write_text(bake_ + "/frames.fascicle", frames);
  expect_none(report(), 3, "frames.fascicle");
  fs::remove(bake_ + "/manifest.json");
  expect_none(report(), 3, "holds no bake");
}

TEST_F(ReportPage, ReplacesOnlyWhenToldTo) {
  write_text(folder_ / "page.html", "mine");
  const Outcome outcome = report();
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_EQ(read_text(folder_ / "page.html"), "mine");
  EXPECT_EQ(fascicle({"report", bake_, "-o", folder_ / "page.html", "--overwrite"}).status, 0);
  EXPECT_TRUE(read_text(folder_ / "page.html").starts_with("<!DOCTYPE html>"));
}

TEST_F(ReportPage, TheSameFolderGivesTheSameBytes) {
  ASSERT_EQ(fascicle({"report", *made_ / "arm", "-o", folder_ / "again.html", "--threads", "4"}).status, 0);
  EXPECT_EQ(read_text(*made_ / "arm.html"), read_text(folder_ / "again.html"));
}

TEST_F(ReportPage, WhatIsMissingIsSaid) {
  fs::remove(bake_ + "/metrics.csv");
  fs::remove(bake_ + "/character.glb");
  const pugi::xml_document page = good_page();
  const std::string text = text_of(page.document_element());
  EXPECT_TRUE(contains(text, "Skinning alone is not shown: ")) << text.substr(0, 600);
  EXPECT_TRUE(contains(text, "metrics.csv is missing"));
  EXPECT_EQ(page.select_nodes("//section[@id='stills']//img").size(), 2u);
}

TEST(Report, ABakeWithoutFramesHasAPageWithoutPictures) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle({"bake", "bar-beta-1", "-o", folder / "bar", "--end", "0.1", "--device", "cpu", "-q",
                      "--format", "none", "--keep-frames", "false"})
                .status,
            0);
  const Outcome outcome = fascicle({"report", folder / "bar", "-o", folder / "page.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const pugi::xml_document page = page_at(folder / "page.html");
  EXPECT_TRUE(page.select_nodes("//img").empty());
  EXPECT_TRUE(contains(text_of(page.document_element()), "frames of this bake were not kept"));
}

TEST(ValidateHtml, SaysWhatWasPrinted) {
  const TemporaryFolder folder;
  const Outcome outcome = fascicle({"validate", "bar-beta-1", "--devices", "cpu", "--frames", "3", "--json",
                                    "--html", folder / "page.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json printed = json::parse(outcome.out);
  const pugi::xml_document page = page_at(folder / "page.html");
  EXPECT_EQ(std::string(page.select_node("//span[@class='state good']").node().child_value()), "holds");
  const pugi::xml_node row = page.select_node("//section[@id='oracle']//tbody/tr").node();
  std::vector<std::string> cells;
  for (const pugi::xml_node& cell : row.children()) cells.push_back(cell.child_value());
  ASSERT_EQ(cells.size(), 7u);
  EXPECT_EQ(cells[0], printed["oracle"][0]["device"]);
  // Four and two digits are shown.
  EXPECT_NEAR(std::stod(cells[2]) / 1e3, printed["oracle"][0]["largest_m"].get<double>(),
              1e-3 * printed["oracle"][0]["largest_m"].get<double>());
  EXPECT_NEAR(std::stod(cells[5]), printed["oracle"][0]["relative"].get<double>(),
              0.05 * printed["oracle"][0]["relative"].get<double>());
  EXPECT_EQ(
      fascicle({"validate", "bar-beta-1", "--devices", "cpu", "--html", folder / "none/page.html"}).status,
      3);
}

// The same for --converged.
TEST(ValidateHtml, ShowsWhatSubstepsCost) {
  const TemporaryFolder folder;
  const Outcome outcome = fascicle({"validate", "rod-hang", "--devices", "cpu", "--frames", "2",
                                    "--converged", "--html", folder / "page.html"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const pugi::xml_document page = page_at(folder / "page.html");
  EXPECT_GE(page.select_nodes("//section[@id='qualities']//tbody/tr").size(), 3u);
}

}  // namespace
}  // namespace fascicle::tests::report_test
