// If files of a bake are damaged, whatever reads them later names the file and says what to do.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/checkpoint.h"
#include "host/bake/read_frame_cache.h"
#include "host/bake/sealed_json.h"
#include "tests/cli/changed_glb.h"
#include "tests/cli/program.h"

namespace fascicle::tests::damaged_bakes_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void expect_bad_input(const Outcome& outcome, const std::string& file) {
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, file)) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "bake again") || contains(outcome.err, "--overwrite")) << outcome.err;
}

// One bake per scene for all tests; each test gets a copy.
class DamagedBake : public testing::Test {
 protected:
  static std::vector<std::string> bake_command(const std::string& scene, const std::string& folder) {
    return {"bake", scene, "-o", folder, "--end", "0.1", "--device", "cpu"};
  }
  void take(const std::string& scene) {
    static const TemporaryFolder made;
    if (!fs::exists(made / scene)) {
      const Outcome outcome = fascicle(bake_command(scene, made / scene));
      ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
    fs::remove_all(out_);
    fs::copy(made / scene, out_, fs::copy_options::recursive);
  }
  Outcome exported(const std::string& formats = "glb,pc2") const {
    return fascicle({"export", out_, "--to", formats, "-o", folder_ / "exported", "--overwrite"});
  }
  Outcome resumed(const std::string& scene) const {
    std::vector<std::string> command = bake_command(scene, out_);
    command.push_back("--resume");
    return fascicle(command);
  }

  const TemporaryFolder folder_;
  const std::string out_ = folder_ / "out";
};

json& primitive(json& document) {
  return document["meshes"][0]["primitives"][0];
}

// A blend shape that is on in the bind pose and off in the clip, so that exports skin each vertex themselves.
void give_shape(json& document) {
  primitive(document)["targets"] = {{{"POSITION", primitive(document)["attributes"]["POSITION"]}}};
  document["meshes"][0]["weights"] = {1.0};
  json& clip = document["animations"][0];
  const json input = clip["samplers"][0]["input"];
  document["accessors"].push_back({{"componentType", 5126},
                                   {"type", "SCALAR"},
                                   {"count", document["accessors"][input.get<std::size_t>()]["count"]}});
  clip["samplers"].push_back({{"input", input}, {"output", document["accessors"].size() - 1}});
  std::size_t node = 0;
  while (!document["nodes"][node].contains("mesh")) ++node;
  clip["channels"].push_back(
      {{"sampler", clip["samplers"].size() - 1}, {"target", {{"node", node}, {"path", "weights"}}}});
}

json& accessor_of(json& document, const char* attribute) {
  return document["accessors"][primitive(document)["attributes"][attribute].get<std::size_t>()];
}

constexpr const char* no_bytes = "data:application/octet-stream;base64,AAAA";

struct CharacterDamage {
  const char* name;
  std::function<void(json&)> change;
};

const std::vector<CharacterDamage>& character_damages() {
  static const std::vector<CharacterDamage> all{
      // Reads the weights' floats as 16-bit integers.
      {"joints beyond the skin",
       [](json& d) { accessor_of(d, "JOINTS_0")["bufferView"] = accessor_of(d, "WEIGHTS_0")["bufferView"]; }},
      {"one weight for all vertices", [](json& d) { accessor_of(d, "WEIGHTS_0")["count"] = 1; }},
      {"one joint for all vertices", [](json& d) { accessor_of(d, "JOINTS_0")["count"] = 1; }},
      {"joints without weights", [](json& d) { primitive(d)["attributes"].erase("WEIGHTS_0"); }},
      {"no positions", [](json& d) { primitive(d)["attributes"].erase("POSITION"); }},
      {"fewer vertices",
       [](json& d) {
         for (const char* attribute : {"POSITION", "NORMAL", "JOINTS_0", "WEIGHTS_0"})
           accessor_of(d, attribute)["count"] = accessor_of(d, attribute)["count"].get<std::size_t>() - 1;
       }},
      {"a buffer elsewhere",
       [](json& d) {
         d["buffers"].push_back({{"byteLength", 3}, {"uri", no_bytes}});
       }},
      {"meshes that are none", [](json& d) { d["meshes"] = "none"; }},
      {"no node", [](json& d) { d["nodes"] = json::array(); }}};
  return all;
}

TEST_F(DamagedBake, ACharacterIsHeldAgainstItsSkinAndTheModel) {
  for (const bool has_shape : {false, true}) {
    take("arm");
    if (has_shape) change_glb(out_ + "/character.glb", give_shape);
    ASSERT_EQ(exported("glb,usda").status, 0)
        << "the control: undamaged, with" << (has_shape ? "" : "out") << " a shape";
    for (const CharacterDamage& damage : character_damages()) {
      SCOPED_TRACE(std::string(damage.name) + (has_shape ? ", with a shape" : ""));
      take("arm");
      change_glb(out_ + "/character.glb", [&](json& document) {
        if (has_shape) give_shape(document);
        damage.change(document);
      });
      expect_bad_input(exported("glb,usda"), "character.glb");
    }
  }
  take("arm");
  fs::remove(out_ + "/character.glb");
  expect_bad_input(exported("glb"), "character.glb");
}

// The same frames with a changed header.
void change_cache(const std::string& path, const std::function<void(bake::CacheHeader&)>& change_header,
                  const std::function<void(model::Frame&)>& change_frame = {}) {
  std::string bytes;
  {
    const bake::FrameCacheReader cache(path);
    bake::CacheHeader header = cache.header();
    change_header(header);
    bytes = bake::encode_cache_header(header);
    for (std::uint64_t k = 0; k < cache.frame_count(); ++k) {
      model::Frame frame = cache.read(k);
      frame.positions.resize(std::size_t{3} * header.vertex_count);
      if (change_frame) change_frame(frame);
      bytes += bake::encode_cache_record(header, frame);
    }
  }
  write_text(path, bytes);
}

TEST_F(DamagedBake, FramesAreHeldAgainstTheModel) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<const char*, std::function<void(bake::CacheHeader&)>>> damages{
      {"fewer vertices", [](auto& header) { header.vertex_count = 3; }},
      {"more vertices", [](auto& header) { header.vertex_count += 7; }},
      {"no frame rate", [](auto& header) { header.fps = nan; }},
      {"frame rate 0", [](auto& header) { header.fps = 0.0; }},
      {"frame rate below 0", [](auto& header) { header.fps = -60.0; }},
      {"another frame rate than the manifest's", [](auto& header) { header.fps = 30.0; }},
      {"an endless start", [](auto& header) { header.start = std::numeric_limits<double>::infinity(); }},
      {"no unit", [](auto& header) { header.unit = nan; }},
      {"another unit", [](auto& header) { header.unit *= 2.0; }},
      {"no origin", [](auto& header) { header.rest_origin[1] = nan; }},
      {"more frames than can be counted",
       [](auto& header) { header.frames = std::numeric_limits<std::uint64_t>::max(); }},
      {"more frames than are there", [](auto& header) { header.frames += 1; }}};
  take("bar-hang-none");
  change_cache(out_ + "/frames.fascicle", [](auto&) {});
  ASSERT_EQ(exported().status, 0) << "the control: an unchanged header";
  for (const auto& [name, change] : damages) {
    SCOPED_TRACE(name);
    take("bar-hang-none");
    change_cache(out_ + "/frames.fascicle", change);
    expect_bad_input(exported(), out_);
    expect_bad_input(resumed("bar-hang-none"), "frames.fascicle");
  }
  take("bar-hang-none");
  change_cache(
      out_ + "/frames.fascicle", [](auto&) {},
      [](model::Frame& frame) {
        if (frame.index == 2) frame.positions[4] = std::numeric_limits<float>::quiet_NaN();
      });
  expect_bad_input(exported(), "frames.fascicle: frame 2");
}

// All that reads a bake's frames, but the exports.
std::vector<std::vector<std::string>> showing(const std::string& bake, const TemporaryFolder& folder) {
  return {{"render", bake, "-o", folder / "a.png"},
          {"render", bake, "--mode", "lag", "-o", folder / "lag.png"},
          {"render", bake, "--compare", "-o", folder / "both.png"},
          {"report", bake, "-o", folder / "a.html"},
          {"view", bake, "-o", folder / "page.html"}};
}

// Distances between positions may be beyond the largest float, and origins beyond any distance.
TEST_F(DamagedBake, VastPositionsAreRefused) {
  take("arm");
  for (const std::vector<std::string>& command : showing(out_, folder_))
    ASSERT_EQ(fascicle(command).status, 0) << "the control: undamaged";
  const std::vector<std::function<void(model::Frame&)>> damages{
      [](model::Frame& frame) {
        for (std::size_t k = 0; k < frame.positions.size(); ++k)
          frame.positions[k] = (k % 2 == 0 ? 1.0f : -1.0f) * std::numeric_limits<float>::max();
      },
      [](model::Frame& frame) { frame.positions[7] = 1e10f; },
      [](model::Frame& frame) { frame.origin[1] = 1e300; }};
  const TemporaryFolder shown;
  for (const auto& damage : damages) {
    take("arm");
    change_cache(
        out_ + "/frames.fascicle", [](auto&) {}, damage);
    for (const std::vector<std::string>& command : showing(out_, shown)) {
      SCOPED_TRACE(testing::PrintToString(command));
      expect_bad_input(fascicle(command), "frames.fascicle");
    }
    expect_bad_input(exported(), "frames.fascicle");
  }
}

// The clip gives nodes above each other a size, from frame 3 on.
void resize_joints(const std::string& file, float size, int nodes) {
  const std::vector<float> sizes{0.0f, 0.05f, 1, 1, 1, size, size, size};
  const std::string bytes(reinterpret_cast<const char*>(sizes.data()), sizes.size() * sizeof(float));
  change_glb(
      file,
      [nodes](json& d) {
        const std::size_t view = d["bufferViews"].size() - 1, input = d["accessors"].size();
        d["accessors"].push_back(
            {{"componentType", 5126}, {"type", "SCALAR"}, {"count", 2}, {"bufferView", view}});
        d["accessors"].push_back({{"componentType", 5126},
                                  {"type", "VEC3"},
                                  {"count", 2},
                                  {"bufferView", view},
                                  {"byteOffset", 8}});
        json& clip = d["animations"][0];
        clip["samplers"].push_back({{"input", input}, {"output", input + 1}, {"interpolation", "STEP"}});
        const std::size_t sampler = clip["samplers"].size() - 1;
        json& roots = d["scenes"][0]["nodes"];
        for (int depth = 0; depth < nodes; ++depth) {
          d["nodes"].push_back({{"children", roots}});
          roots = {d["nodes"].size() - 1};
          clip["channels"].push_back(
              {{"sampler", sampler}, {"target", {{"node", roots[0]}, {"path", "scale"}}}});
        }
      },
      bytes);
}

TEST_F(DamagedBake, VastJointsAreRefused) {
  // The flesh itself is in the frames: it is shown without the joints.
  const std::vector<std::string> flesh{"render", out_, "-o", folder_ / "flesh.png", "--overwrite"};
  const TemporaryFolder shown;
  for (const int nodes : {1, 5, 9}) {
    SCOPED_TRACE(nodes);
    take("arm");
    resize_joints(out_ + "/character.glb", 3e38f, nodes);
    EXPECT_EQ(fascicle(flesh).status, 0);
    expect_bad_input(fascicle({"render", out_, "--compare", "-o", shown / "both.png"}), "frame");
    expect_bad_input(fascicle({"view", out_, "-o", shown / "page.html"}), "frame");
    for (const char* options : {"--glb-stride=6", "--glb-compress=0.001"})
      expect_bad_input(
          fascicle({"export", out_, "--to", "glb", "-o", shown / "exported", "--overwrite", options}),
          "character.glb");
  }
}

// A clip may hide a limb by almost no size.
TEST_F(DamagedBake, JointsOfAlmostNoSizeAreExported) {
  take("arm");
  resize_joints(out_ + "/character.glb", 1e-37f, 1);
  for (const char* options : {"--glb-stride=6", "--glb-compress=0.001"}) {
    const Outcome outcome =
        fascicle({"export", out_, "--to", "glb", "-o", folder_ / "exported", "--overwrite", options});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    // Numbers that are not finite are null in JSON.
    change_glb(folder_ / "exported/surface.glb",
               [](const json& d) { EXPECT_FALSE(contains(d.dump(), "null")); });
  }
}

TEST_F(DamagedBake, TheManifestIsHeldAgainstTheFrames) {
  for (const json& fps : {json(nullptr), json("sixty"), json(30)}) {
    SCOPED_TRACE(fps);
    take("bar-hang-none");
    json manifest = json::parse(read_text(out_ + "/manifest.json"));
    manifest["output"]["fps"] = fps;
    write_text(out_ + "/manifest.json", bake::sealed_text(manifest));
    expect_bad_input(exported(), "manifest.json");
  }
}

// A changed number: still valid JSON, so only the checksum detects it.
TEST_F(DamagedBake, TheManifestIsHeldAgainstItsChecksum) {
  for (const char* text : {"7", "1e999", "NaN"}) {
    SCOPED_TRACE(text);
    take("bar-hang-none");
    std::string manifest = read_text(out_ + "/manifest.json");
    const std::size_t at = manifest.find("\"runs\": ") + 8;
    ASSERT_LT(at, manifest.size());
    manifest.replace(at, 1, text);
    write_text(out_ + "/manifest.json", manifest);
    expect_bad_input(exported(), "manifest.json");
    const Outcome verified = fascicle({"verify", out_});
    EXPECT_EQ(verified.status, 3);
    EXPECT_TRUE(contains(verified.err, "manifest.json")) << verified.err;
    // The remedy in the messages works: the files still count as ours.
    std::vector<std::string> command = bake_command("bar-hang-none", out_);
    command.push_back("--overwrite");
    const Outcome again = fascicle(command);
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(fascicle({"verify", out_}).status, 0);
  }
}

// A bar without joints, and a scene whose solids are bound to joints.
TEST_F(DamagedBake, TheSceneIsHeldAgainstTheModel) {
  const fs::path scene = folder_ / "bound.toml";
  write_text(
      scene,
      read_text(fs::path(FASCICLE_SOURCE_DIR) / "scenes/arm.toml") +
          "[collider.a]\nshape = \"sphere\"\nradius = 0.01\ncenter = [0.0, 1.0, 0.0]\njoint = \"forearm\"\n"
          "[collider.b]\nshape = \"sphere\"\nradius = 0.01\ncenter = [0.0, 1.0, 0.0]\njoint = \"hand\"\n");
  const std::string of_arm = folder_ / "bound";
  const Outcome made = fascicle(bake_command(scene, of_arm));
  ASSERT_EQ(made.status, 0) << made.err;
  take("squeeze");
  json manifest = json::parse(read_text(out_ + "/manifest.json"));
  const json other = json::parse(read_text(of_arm + "/manifest.json"));
  for (const char* key : {"scene", "inputs"}) manifest[key] = other[key];
  const Outcome control = fascicle({"render", out_, "-o", folder_ / "control.png"});
  ASSERT_EQ(control.status, 0) << control.err;
  write_text(out_ + "/manifest.json", bake::sealed_text(manifest));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"render", out_, "-o", folder_ / "a.png"},
        std::vector<std::string>{"report", out_, "-o", folder_ / "a.html"}})
    expect_bad_input(fascicle(command), "different bakes");
}

TEST_F(DamagedBake, LostFilesAreNamed) {
  for (const char* file : {"frames.fascicle", "model.fascicle", "manifest.json"}) {
    SCOPED_TRACE(file);
    take("bar-hang-none");
    fs::remove(fs::path(out_) / file);
    expect_bad_input(exported(), file);
  }
  take("bar-hang-none");
  fs::remove(out_ + "/frames.fascicle");
  expect_bad_input(resumed("bar-hang-none"), "frames.fascicle");
}

TEST_F(DamagedBake, ACheckpointIsHeldAgainstTheModel) {
  const std::vector<std::pair<const char*, std::function<void(bake::Checkpoint&)>>> damages{
      {"fewer positions", [](auto& checkpoint) { checkpoint.state.positions.pop_back(); }},
      {"skinned without a skeleton", [](auto& checkpoint) { checkpoint.state.skinned.resize(6); }},
      {"a frame after the last", [](auto& checkpoint) { checkpoint.state.frame = 99; }},
      {"a frame that no number follows",
       [](auto& checkpoint) { checkpoint.state.frame = std::numeric_limits<std::uint64_t>::max(); }},
      {"no origin",
       [](auto& checkpoint) { checkpoint.state.origin[0] = std::numeric_limits<double>::quiet_NaN(); }}};
  take("bar-hang-none");
  ASSERT_EQ(resumed("bar-hang-none").status, 0) << "the control: undamaged";
  for (const auto& [name, change] : damages) {
    SCOPED_TRACE(name);
    take("bar-hang-none");
    const fs::path path = out_ + "/checkpoint";
    bake::Checkpoint checkpoint = bake::read_checkpoint(path).value();
    change(checkpoint);
    bake::write_checkpoint(path, bake::view_of(checkpoint));
    expect_bad_input(resumed("bar-hang-none"), "checkpoint");
  }
  take("bar-hang-none");
  const std::string whole = read_text(out_ + "/checkpoint");
  for (const std::size_t length : {std::size_t{8}, std::size_t{20}, whole.size() / 2, whole.size() - 1}) {
    write_text(out_ + "/checkpoint", whole.substr(0, length));
    expect_bad_input(resumed("bar-hang-none"), "checkpoint");
  }
}

}  // namespace
}  // namespace fascicle::tests::damaged_bakes_test
