// fascicle render --compare, --worst, and the file's own colours and shapes, as a user sees them.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/cli/drawn_frames.h"
#include "host/cli/log.h"
#include "host/cli/render_arguments.h"
#include "host/formats/surface.h"
#include "host/model/model.h"
#include "host/page/base64.h"
#include "tests/cli/changed_glb.h"
#include "tests/cli/pixels.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The number of pixels in columns [first, last) that are much bluer than red.
std::size_t blue_between(const Pixels& pixels, unsigned first, unsigned last) {
  std::size_t count = 0;
  for (unsigned y = 0; y < pixels.height; ++y)
    for (unsigned x = first; x < last; ++x) {
      const std::uint8_t* p = &pixels.rgb[3 * (std::size_t{y} * pixels.width + x)];
      count += p[2] > p[0] + 60 ? 1u : 0u;
    }
  return count;
}

// A PNG of one blue pixel.
const std::string blue_png =
    "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGMQ0XgGAAF2ASO9MrfzAAAAAElFTkSuQmCC";

class RenderCompare : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome outcome =
        fascicle({"bake", "jump", "-o", bake_, "--end", "0.2", "--preroll", "0s", "--device", "cpu", "-q"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  Outcome render(std::vector<std::string> arguments, const std::string& size = "120x160") const {
    arguments.insert(arguments.begin(), {"render", bake_, "--overwrite", "--size", size});
    return fascicle(arguments);
  }
  void paint(const json& image) const {
    change_glb(fs::path(bake_) / "character.glb", [&](json& document) {
      document["materials"] =
          json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
      document["textures"] = json::array({{{"source", 0}}});
      document["images"] = json::array({image});
      for (json& primitive : document["meshes"][0]["primitives"]) {
        primitive["material"] = 0;
        primitive["attributes"]["TEXCOORD_0"] = add_uvs(document, primitive);
      }
    });
  }

  TemporaryFolder folder_;
  std::string bake_ = folder_ / "bake";
  std::string sheet_ = folder_ / "sheet.png";

 private:
  // All coordinates are 0, one pair per vertex: an accessor without a buffer view.
  static std::size_t add_uvs(json& document, const json& primitive) {
    const std::size_t position = primitive["attributes"]["POSITION"];
    document["accessors"].push_back(
        {{"componentType", 5126}, {"type", "VEC2"}, {"count", document["accessors"][position]["count"]}});
    return document["accessors"].size() - 1;
  }
};

TEST_F(RenderCompare, BothHalvesShowTheBodyInItsColours) {
  paint({{"uri", blue_png}});
  const Outcome outcome = render({"-o", sheet_, "--compare", "--frame", "6"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Pixels pair = pixels_of(sheet_);
  ASSERT_EQ(pair.width, 240u);
  EXPECT_GT(pair.height, 160u);
  const std::size_t left = blue_between(pair, 0, 120), right = blue_between(pair, 120, 240);
  // With the fitted camera, the body covers more than a tenth of its picture; the two pictures differ only by
  // the soft flesh.
  EXPECT_GT(left, 120u * 160u / 10);
  EXPECT_NEAR(static_cast<double>(left), static_cast<double>(right), 0.1 * static_cast<double>(left));

  ASSERT_EQ(render({"-o", sheet_, "--compare", "--frame", "6", "--threads", "1"}).status, 0);
  const std::string one = read_text(sheet_);
  ASSERT_EQ(render({"-o", sheet_, "--compare", "--frame", "6", "--threads", "5"}).status, 0);
  EXPECT_EQ(read_text(sheet_), one);

  // The control: without the file's colours nothing is blue.
  ASSERT_EQ(render({"-o", sheet_, "--compare", "--frame", "6", "--plain"}).status, 0);
  EXPECT_EQ(blue_between(pixels_of(sheet_), 0, 240), 0u);
}

TEST_F(RenderCompare, BrokenImageIsAWarningAndAPicture) {
  for (const char* uri : {"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEA", "data:image/png;base64,????",
                          "../outside.png", "data:image/webp;base64,UklGRiIAAABXRUJQ"}) {
    paint({{"uri", uri}});
    const Outcome outcome = render({"-o", sheet_, "--frame", "1"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "its surface gets its plain colour")) << uri << ": " << outcome.err;
    EXPECT_EQ(pixels_of(sheet_).width, 120u);
  }
}

// Skinning the render mesh by the file and skinning the tetrahedra by the drive lead to the same positions.
TEST_F(RenderCompare, SkinnedSurfaceIsWhereTheDriveSkinsIt) {
  cli::RenderArguments arguments;
  arguments.input.name = bake_;
  cli::Log log({});
  cli::DrawnFrames frames(arguments, log);
  const model::Model& model = frames.model();
  for (const std::uint64_t k : {std::uint64_t{0}, std::uint64_t{7}, frames.count() - 1}) {
    const std::vector<float> vertices = frames.skinned_vertices(k), surface = frames.skinned_surface(k);
    ASSERT_EQ(surface.size(), std::size_t{3} * model.surface_count());
    const std::vector<float> carried = formats::embed(model, vertices);
    double most = 0.0;
    for (std::size_t i = 0; i < surface.size(); ++i)
      most = std::max(most, std::fabs(double{surface[i]} - double{carried[i]}));
    // For a body of 2 m; the file's weights, bind matrices and poses are floats.
    EXPECT_LT(most, 2e-5) << k;
  }
}

// A blend shape lifts the whole mesh by 0.3 m in the course of the clip.
void lift(const fs::path& character, float seconds) {
  std::string bytes;
  const auto append = [&](const std::vector<float>& values) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  };
  append({0.0f, seconds});
  append({0.0f, 1.0f});
  change_glb(character, [&](json& document) {
    const auto add_view = [&](std::size_t offset, std::size_t length) {
      document["bufferViews"].push_back(
          {{"buffer", document["buffers"].size()}, {"byteOffset", offset}, {"byteLength", length}});
      return document["bufferViews"].size() - 1;
    };
    const auto add_accessor = [&](std::size_t view, std::size_t count, const char* type) {
      document["accessors"].push_back({{"bufferView", view},
                                       {"componentType", 5126},
                                       {"type", type},
                                       {"count", count},
                                       {"min", json::array({0})},
                                       {"max", json::array({1})}});
      return document["accessors"].size() - 1;
    };
    const std::size_t times = add_accessor(add_view(0, 8), 2, "SCALAR"),
                      weights = add_accessor(add_view(8, 8), 2, "SCALAR");
    for (json& primitive : document["meshes"][0]["primitives"]) {
      const std::size_t count =
          document["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()]["count"];
      const std::size_t view = add_view(bytes.size(), 12 * count);
      for (std::size_t i = 0; i < count; ++i) append({0.0f, 0.3f, 0.0f});
      const std::size_t target = add_accessor(view, count, "VEC3");
      document["accessors"][target]["min"] = document["accessors"][target]["max"] = {0.0f, 0.3f, 0.0f};
      primitive["targets"] = json::array({{{"POSITION", target}}});
    }
    document["meshes"][0]["weights"] = json::array({0.0});
    json& clip = document["animations"][0];
    std::size_t node = 0;
    while (!document["nodes"][node].contains("mesh")) ++node;
    clip["samplers"].push_back({{"input", times}, {"output", weights}, {"interpolation", "LINEAR"}});
    clip["channels"].push_back(
        {{"sampler", clip["samplers"].size() - 1}, {"target", {{"node", node}, {"path", "weights"}}}});
    document["buffers"].push_back({{"byteLength", bytes.size()},
                                   {"uri", "data:application/octet-stream;base64," + page::base64(bytes)}});
  });
}

std::vector<float> vertices_of_obj(const std::string& text) {
  std::istringstream lines(text);
  std::vector<float> vertices;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    float value = 0.0f;
    while (word == "v" && words >> value) vertices.push_back(value);
  }
  return vertices;
}

// The mean row of the blue pixels in columns [first, last).
double blue_row(const Pixels& pixels, unsigned first, unsigned last) {
  double sum = 0.0, count = 0.0;
  for (unsigned y = 0; y < pixels.height; ++y)
    for (unsigned x = first; x < last; ++x) {
      const std::uint8_t* p = &pixels.rgb[3 * (std::size_t{y} * pixels.width + x)];
      if (p[2] <= p[0] + 60) continue;
      sum += y;
      ++count;
    }
  return sum / count;
}

// Blend shapes move the flesh that is drawn, as they move what is exported.
TEST_F(RenderCompare, BlendShapesMoveTheFlesh) {
  paint({{"uri", blue_png}});
  lift(fs::path(bake_) / "character.glb", 0.2f);
  ASSERT_EQ(fascicle({"export", bake_, "--to", "obj", "-q"}).status, 0);
  cli::RenderArguments arguments;
  arguments.input.name = bake_;
  cli::Log log({});
  cli::DrawnFrames frames(arguments, log);
  const std::uint64_t last = frames.count() - 1;
  for (const std::uint64_t k : {std::uint64_t{0}, last}) {
    const std::string number = std::to_string(k);
    const std::vector<float> exported = vertices_of_obj(read_text(
        fs::path(bake_) / "obj" / ("frame_" + std::string(6 - number.size(), '0') + number + ".obj")));
    const std::vector<float> drawn = frames.surface(k),
                             carried = formats::embed(frames.model(), frames.positions(k));
    ASSERT_EQ(drawn.size(), exported.size());
    double most = 0.0, lifted = 0.0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      most = std::max(most, std::fabs(double{drawn[i]} - double{exported[i]}));
      if (i % 3 == 1)
        lifted += 3.0 * (double{drawn[i]} - double{carried[i]}) / static_cast<double>(drawn.size());
    }
    EXPECT_LT(most, 1e-6) << k;  // both round to float
    // Bones lean during the jump, and the lift with them.
    EXPECT_NEAR(lifted, k == 0 ? 0.0 : 0.3, 0.05) << k;
  }
  ASSERT_EQ(render({"-o", sheet_, "--compare", "--frame", std::to_string(last)}).status, 0);
  const Pixels pair = pixels_of(sheet_);
  // The two differ by the soft flesh, a small part of the body; a seventh of it is more than 10 rows.
  EXPECT_NEAR(blue_row(pair, 0, 120), blue_row(pair, 120, 240), 3.0);
}

TEST_F(RenderCompare, WorstFramesAreThoseOfTheMetrics) {
  std::string text = "frame,time,look,look_jump\n";
  for (int k = 0; k <= 12; ++k)
    text += std::to_string(k) + ",0," + (k == 9 ? "5" : k == 2 ? "4" : k == 10 ? "4.5" : "0.5") + ",1\n";
  write_text(fs::path(bake_) / "metrics.csv", text);
  const Outcome outcome = render({"-o", sheet_, "--worst", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "worst first: 9, 2\n")) << outcome.out;
  EXPECT_EQ(outcome.err.find("no column look"), std::string::npos);
  const Outcome compared = render({"-o", sheet_, "--compare"});
  EXPECT_TRUE(contains(compared.out, "worst first: 9, 2\n")) << compared.out;
  write_text(fs::path(bake_) / "metrics.csv",
             "frame,inverted,inverted_skinned,lag_fat\n0,0,0,0\n4,3,1,0\n8,9,8,1\n");
  const Outcome without = render({"-o", sheet_, "--worst", "2"});
  EXPECT_TRUE(contains(without.out, "worst first: 4, 8\n")) << without.out;
  EXPECT_TRUE(contains(without.err, "no column look")) << without.err;
}

// The rows of a picture's first columns above `below` that hold dark ink.
unsigned inked_rows(const Pixels& picture, unsigned columns, unsigned below) {
  unsigned rows = 0;
  for (unsigned y = 0; y < below; ++y) {
    bool is_inked = false;
    for (unsigned x = 0; x < columns; ++x) is_inked |= picture.rgb[3 * (y * picture.width + x)] < 120;
    rows += is_inked;
  }
  return rows;
}

TEST_F(RenderCompare, CaptionsOfARunAreOfOneSize) {
  const auto written = [&](const std::string& joint) {
    std::string text = "frame,time,look,look_jump,worst_joint\n";
    for (int k = 0; k <= 12; ++k) text += std::to_string(k) + ",0,0.5,0.5," + (k == 4 ? joint : "hip") + "\n";
    write_text(fs::path(bake_) / "metrics.csv", text);
    const std::string film = folder_ / "film";
    const Outcome outcome = render({"-o", film, "--compare"}, "400x160");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::set<unsigned> rows;
    for (const char* name : {"/0002.png", "/0004.png"}) {
      const Pixels picture = pixels_of(film + name);
      rows.insert(inked_rows(picture, 100, picture.height - 160));
    }
    return rows;
  };
  const std::set<unsigned> with_long = written("a-joint-with-a-very-long-name"), with_short = written("hip");
  EXPECT_EQ(with_long.size(), 1u);
  EXPECT_EQ(with_short.size(), 1u);
  // The control: a long name makes the letters of all frames smaller.
  EXPECT_LT(*with_long.begin(), *with_short.begin());
}

TEST_F(RenderCompare, WrongUseIsOneClearMessage) {
  const auto expect_refused = [&](const Outcome& outcome, int status, const std::string& part) {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, part)) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(sheet_));
  };
  expect_refused(render({"-o", sheet_, "--worst", "0"}), 2, "--worst");
  expect_refused(render({"-o", sheet_, "--worst", "2", "--frame", "1"}), 2, "leave out --frame");
  expect_refused(render({"-o", sheet_, "--worst", "2", "--sheet", "2x1"}), 2, "leave out --sheet");
  expect_refused(render({"-o", folder_ / "frames", "--worst", "2"}), 2, ".png");
  expect_refused(fascicle({"render", "bar-beta-1", "-o", sheet_, "--compare"}), 2, "--compare needs a bake");
  expect_refused(fascicle({"render", "bar-beta-1", "-o", sheet_, "--worst", "3"}), 2, "--worst needs a bake");
  fs::remove(fs::path(bake_) / "metrics.csv");
  expect_refused(render({"-o", sheet_, "--compare"}), 3, "metrics.csv");
  fs::remove(fs::path(bake_) / "character.glb");
  expect_refused(render({"-o", sheet_, "--compare", "--frame", "1"}), 3, "character.glb");
}

// A body without a skeleton is shown next to its rest pose.
TEST_F(RenderCompare, BarStandsBesideItsRest) {
  ASSERT_EQ(
      fascicle({"bake", "bar-beta-1", "-o", bake_, "--overwrite", "--end", "0.1", "--device", "cpu", "-q"})
          .status,
      0);
  const Outcome outcome = render({"-o", sheet_, "--compare", "--sheet", "2x1"}, "160x96");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(pixels_of(sheet_).width, 640u);
}

}  // namespace
}  // namespace fascicle::tests
