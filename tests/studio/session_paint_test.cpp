// Painting in the studio: strokes, undo, and that a saved scene bakes to what was shown.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/made/made_character.h"
#include "host/pipeline/bake_scene.h"
#include "host/scene/paint_file.h"
#include "tests/studio/running_studio.h"

namespace fascicle::tests {
namespace {

class SessionPaintTest : public SessionTest {
 protected:
  void SetUp() override {
    SessionTest::SetUp();
    scene_ = folder_ / "arm.toml";
    base::write_whole(scene_, "[scene]\nend = 0.1\n[character]\nmade = \"arm\"\nresolution = 0.04\n");
  }

  // A stroke over part of the arm, in one message.
  static Json stroke(const std::string& attribute, double value, std::uint64_t number = 1) {
    return {{"type", "paint"}, {"attribute", attribute},     {"value", value},
            {"radius", 0.05},  {"places", {place(), end()}}, {"stroke", number},
            {"mirror", false}};
  }
  static Json place() { return point(arm().surface.vertices[arm().surface.vertices.size() / 2]); }
  static Json end() {
    const rig::Vector3d& p = arm().surface.vertices[arm().surface.vertices.size() / 2];
    return point(p + rig::Vector3d(0.02, 0.0, 0.0));
  }
  static Json point(const rig::Vector3d& p) { return {p[0], p[1], p[2]}; }
  static const rig::Character& arm() {
    static const rig::Character made = made::make_character("arm");
    return made;
  }
  // The next array with this name.
  static DecodedArray wait_for_array(Client& client, const std::string& name) {
    while (const auto message = client.next())
      if (!message->is_text && message->bytes[0] == 2)
        if (DecodedArray array = decode_array(message->bytes); array.name == name) return array;
    ADD_FAILURE() << "no array " << name;
    return {};
  }
  // The history may be sent once more, when it is on disk.
  static bool can_undo(Client& client, const std::string& label) {
    for (int k = 0; k < 10; ++k)
      if (client.wait_for("history").at("undo") == label) return true;
    return false;
  }
  static std::size_t count(const DecodedArray& array, float value) {
    return static_cast<std::size_t>(std::count(array.floats.begin(), array.floats.end(), value));
  }
};

TEST_F(SessionPaintTest, AStrokeIsAChangeThatCanBeTakenBack) {
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  const Json& can = start.messages.at("paint");
  EXPECT_EQ(can.at("can_paint"), true) << can;
  EXPECT_EQ(can.at("arrays"), Json::array());
  EXPECT_EQ(can.at("attributes").size(), 4u);
  const std::vector<std::uint32_t> before = start.arrays.at("surface.layer").numbers;

  client->say(stroke("_LAYER", 1.0));
  const DecodedArray painted = wait_for_array(*client, "paint._LAYER");
  ASSERT_EQ(painted.floats.size(), arm().surface.vertices.size());
  EXPECT_GT(count(painted, 1.0f), 3u);
  const Json changed = client->wait_for("changed");
  EXPECT_EQ(changed.at("effect"), "rebuild");
  EXPECT_NE(changed.at("message").get<std::string>().find("Rebuilding the body"), std::string::npos);
  EXPECT_EQ(client->wait_for("paint").at("arrays"), Json({"paint._LAYER"}));
  EXPECT_EQ(wait_for_array(*client, "paint._LAYER").floats, painted.floats);
  const Json key = key_of(client->wait_for("keys"), "character.paint");
  EXPECT_EQ(key.at("value"), "arm.paint.json");
  EXPECT_EQ(client->wait_for("history").at("undo"), "paint layers");
  const DecodedArray layers = wait_for_array(*client, "surface.layer");
  EXPECT_NE(layers.numbers, before) << "the body uses it";
  client->wait_for("applied");

  client->say({{"type", "undo"}});
  EXPECT_EQ(client->wait_for("changed").at("effect"), "rebuild");
  EXPECT_EQ(client->wait_for("paint").at("arrays"), Json::array());
  EXPECT_EQ(wait_for_array(*client, "surface.layer").numbers, before);
  client->wait_for("applied");
  client->say({{"type", "redo"}});
  EXPECT_EQ(wait_for_array(*client, "paint._LAYER").floats, painted.floats);
  EXPECT_EQ(wait_for_array(*client, "surface.layer").numbers, layers.numbers);
}

TEST_F(SessionPaintTest, PiecesOfAStrokeAreOneStep) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  Json piece = stroke("_RIGID", 1.0, 5);
  piece["last"] = false;
  client->say(piece);
  const DecodedArray first = wait_for_array(*client, "paint._RIGID");
  piece["places"] = {point(arm().surface.vertices[3])};
  client->say(piece);
  const DecodedArray second = wait_for_array(*client, "paint._RIGID");
  EXPECT_GT(count(second, 1.0f), count(first, 1.0f));
  piece["last"] = true;
  client->say(piece);
  EXPECT_EQ(client->wait_for("history").at("steps"), 2);
  // An unfinished stroke ends with another stroke, with a change of a key, and when its page disconnects.
  piece["last"] = false;
  piece["attribute"] = "_LAYER";
  piece["stroke"] = 6;
  client->say(piece);
  client->say({{"type", "set"}, {"changes", {{"flesh.softness", 2.0}}}});
  EXPECT_TRUE(can_undo(*client, "paint layers"));
  EXPECT_TRUE(can_undo(*client, "flesh.softness"));
  const auto other = studio.open();
  start_of(*other);
  piece["places"] = {point(arm().surface.vertices[arm().surface.vertices.size() - 3])};
  piece["value"] = 3.0;
  piece["stroke"] = 7;
  {
    const auto goes = studio.open();
    start_of(*goes);
    goes->say(piece);
    wait_for_array(*goes, "paint._LAYER");
  }
  EXPECT_TRUE(can_undo(*client, "paint layers"));
}

TEST_F(SessionPaintTest, WhatIsSavedBakesToWhatWasShown) {
  Json recorded;
  std::vector<float> painted;
  {
    const Running studio = open();
    const auto client = studio.open();
    start_of(*client);
    client->say({{"type", "record"}});
    const Json unpainted = client->wait_for("recorded");
    client->say(stroke("_LAYER", 1.0));
    client->wait_for("applied");
    Json fibres = stroke("_FIBER", 0.0, 2);
    fibres.erase("value");
    client->say(fibres);
    painted = wait_for_array(*client, "paint._FIBER").floats;
    client->wait_for("applied");
    client->say({{"type", "record"}});
    recorded = client->wait_for("recorded");
    EXPECT_NE(recorded.at("position_hash"), unpainted.at("position_hash")) << "the control: paint acts";
    client->say({{"type", "save"}, {"file", "mine.toml"}});
    const Json saved = client->wait_for("saved");
    EXPECT_EQ(saved.at("paints"), Json({(folder_ / "session" / "mine.paint.json").string()}));
    EXPECT_EQ(client->wait_for("history").at("saved"), true);
    client->say({{"type", "bake"}, {"folder", "out"}});
    EXPECT_EQ(client->wait_for("baked").at("position_hash"), recorded.at("position_hash"));
  }
  const scene::Scene scene = scene::load_scene((folder_ / "session" / "mine.toml").string());
  EXPECT_EQ(scene.paint, "mine.paint.json");
  const rig::Paint paint =
      scene::parse_paint(read(folder_ / "session" / "mine.paint.json"), "mine", arm().surface);
  EXPECT_EQ(paint.attributes.size(), 2u);
  pipeline::BakeRequest request;
  request.output.folder = folder_ / "independent";
  request.output.formats = {"none"};
  request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
  const auto prepared = pipeline::prepare_bake(scene, request, {});
  EXPECT_EQ(pipeline::run_bake(*prepared, request, {}).last_position_hash, recorded.at("position_hash"));

  // After a restart, the session still has the paint.
  {
    const Running again = open();
    const auto client = again.open();
    const Start start = start_of(*client);
    EXPECT_EQ(start.messages.at("history").at("undo"), "paint fibres");
    EXPECT_EQ(start.messages.at("history").at("saved"), true);
    const DecodedArray fibre = start.arrays.count("paint._FIBER") ? start.arrays.at("paint._FIBER")
                                                                  : wait_for_array(*client, "paint._FIBER");
    EXPECT_EQ(fibre.floats, painted);
    client->say({{"type", "record"}});
    EXPECT_EQ(client->wait_for("recorded").at("position_hash"), recorded.at("position_hash"));
  }

  // A studio of the saved scene starts with its paint, and its own session does not change that file.
  scene_ = folder_ / "session" / "mine.toml";
  const std::string file = read(folder_ / "session" / "mine.paint.json");
  const Running studio(scene_.string(), folder_ / "next", folder_ / "cache");
  const auto client = studio.open();
  const Start start = start_of(*client);
  EXPECT_EQ(start.messages.at("history").at("undo"), nullptr);
  EXPECT_EQ(start.messages.at("paint").at("arrays").size(), 2u);
  Json erase = stroke("_LAYER", 0.0, 3);
  erase.erase("value");
  erase["erase"] = true;
  client->say(erase);
  client->wait_for("applied");
  client->say({{"type", "save"}});
  EXPECT_EQ(client->wait_for("saved").at("paints"), Json({(folder_ / "next" / "mine.paint.json").string()}));
  EXPECT_EQ(read(folder_ / "session" / "mine.paint.json"), file);
  EXPECT_EQ(
      scene::parse_paint(read(folder_ / "next" / "mine.paint.json"), "mine", arm().surface).attributes.size(),
      1u);
}

TEST_F(SessionPaintTest, PaintFilesOfOthersAreNotOverwritten) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  base::write_whole(folder_ / "session" / "mine.paint.json", "{}");
  client->say(stroke("_LAYER", 1.0));
  client->wait_for("applied");
  client->say({{"type", "save"}, {"file", "mine.toml"}});
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("mine.paint.json already exists"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "session" / "mine.toml")) << "neither of both is written";
  EXPECT_EQ(read(folder_ / "session" / "mine.paint.json"), "{}");
  client->say({{"type", "save"}, {"file", "mine.toml"}, {"overwrite", true}});
  client->wait_for("saved");
  client->say({{"type", "undo"}});
  client->wait_for("applied");
  client->say(stroke("_LAYER", 2.0, 2));
  client->wait_for("applied");
  client->say({{"type", "save"}});
  client->wait_for("saved");
}

TEST_F(SessionPaintTest, WhatCannotBePaintedSaysWhy) {
  {
    const Running studio = open();
    const auto client = studio.open();
    start_of(*client);
    // A number without a layer is detected when the body is built, and undone.
    client->say(stroke("_LAYER", 7.0, 2));
    EXPECT_NE(client->wait_for("failed").at("error").get<std::string>().find("_LAYER 7"), std::string::npos);
    EXPECT_EQ(client->wait_for("history").at("undo"), nullptr);
  }
  const Running bar("bar-beta-1", folder_ / "bar", folder_ / "cache");
  const auto client = bar.open();
  const Start start = start_of(*client);
  EXPECT_EQ(start.messages.at("paint").at("can_paint"), false);
  client->say(stroke("_LAYER", 1.0));
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("only a character"),
            std::string::npos);
}

// A modulus may be multiplied by more than 1; alpha may not.
TEST_F(SessionPaintTest, StiffnessIsPaintedWhateverLayersSay) {
  const auto most_of = [](const Start& start) {
    return start.messages.at("paint").at("attributes").at(2).at("most").get<double>();
  };
  {
    const Running studio = open();
    const auto client = studio.open();
    EXPECT_GT(most_of(start_of(*client)), 1.0) << "the arm's layers are by modulus";
    client->say({{"type", "record"}});
    const Json before = client->wait_for("recorded");
    client->say(stroke("_STIFFNESS", 4.0));
    EXPECT_GT(count(wait_for_array(*client, "paint._STIFFNESS"), 1.0f), 3u) << "unpainted vertices are 1";
    client->wait_for("applied");
    client->say({{"type", "record"}});
    EXPECT_NE(client->wait_for("recorded").at("position_hash"), before.at("position_hash"));
  }
  base::write_whole(scene_,
                    "[scene]\nend = 0.1\n[character]\nmade = \"arm\"\nresolution = 0.04\n"
                    "[layers.flesh]\nalpha = 0.5\n[layers.bone]\nkinematic = true\n"
                    "where = { bone_distance = { maximum = 0.02 } }\n");
  const Running studio(scene_.string(), folder_ / "by-alpha", folder_ / "cache");
  const auto client = studio.open();
  EXPECT_EQ(most_of(start_of(*client)), 1.0);
  client->say(stroke("_STIFFNESS", 4.0));
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("alpha is at most 1"),
            std::string::npos);
  client->say(stroke("_STIFFNESS", 0.5, 2));
  client->wait_for("applied");
}

// Two arms, each with its own paint.
class SessionPaintsTest : public SessionPaintTest {
 protected:
  void SetUp() override {
    SessionPaintTest::SetUp();
    scene_ = folder_ / "arms.toml";
    base::write_whole(scene_,
                      "[scene]\nend = 0.1\n[character.left]\nmade = \"arm\"\nresolution = 0.04\n"
                      "[character.right]\nmade = \"arm\"\nresolution = 0.04\nat = [0.0, 0.0, 1.0]\n");
  }
  // The rest position of a render vertex.
  static Json rest_of(const Start& start, std::size_t vertex) {
    const std::vector<float>& rest = start.arrays.at("surface.rest").floats;
    return {rest[3 * vertex], rest[3 * vertex + 1], rest[3 * vertex + 2]};
  }
  static std::size_t count_in(const DecodedArray& array, std::size_t arm_number, float value) {
    const std::size_t size = arm().surface.vertices.size();
    const auto first = array.floats.begin() + static_cast<std::ptrdiff_t>(arm_number * size);
    return static_cast<std::size_t>(std::count(first, first + static_cast<std::ptrdiff_t>(size), value));
  }
};

TEST_F(SessionPaintsTest, TheBrushPaintsTheCharacterUnderIt) {
  const std::size_t size = arm().surface.vertices.size(), middle = size / 2;
  Json recorded;
  {
    const Running studio = open();
    const auto client = studio.open();
    const Start start = start_of(*client);
    ASSERT_EQ(start.arrays.at("surface.rest").floats.size(), 6 * size);
    EXPECT_EQ(start.messages.at("paint").at("can_paint"), true) << start.messages.at("paint");
    Json right = stroke("_LAYER", 1.0);
    right["places"] = {rest_of(start, size + middle)};
    client->say(right);
    const DecodedArray first = wait_for_array(*client, "paint._LAYER");
    ASSERT_EQ(first.floats.size(), 2 * size);
    EXPECT_EQ(count_in(first, 0, 1.0f), 0u);
    EXPECT_GT(count_in(first, 1, 1.0f), 3u);
    client->wait_for("applied");
    // A stroke across both arms is one step.
    Json both = stroke("_STIFFNESS", 3.0, 2);
    both["places"] = {rest_of(start, middle), rest_of(start, size + middle)};
    client->say(both);
    const DecodedArray second = wait_for_array(*client, "paint._STIFFNESS");
    EXPECT_LT(count_in(second, 0, 1.0f), size);
    EXPECT_LT(count_in(second, 1, 1.0f), size);
    EXPECT_GT(count_in(second, 0, 1.0f), size / 2) << "vertices far away are unpainted";
    client->wait_for("applied");
    client->say({{"type", "undo"}});
    const Json paint = client->wait_for("paint");
    EXPECT_EQ(paint.at("arrays"), Json({"paint._LAYER"})) << "on both arms at once";
    client->wait_for("applied");
    client->say({{"type", "redo"}});
    client->wait_for("applied");
    client->say({{"type", "record"}});
    recorded = client->wait_for("recorded");
    client->say({{"type", "save"}, {"file", "mine.toml"}});
    EXPECT_EQ(client->wait_for("saved").at("paints"),
              Json({(folder_ / "session" / "mine-left.paint.json").string(),
                    (folder_ / "session" / "mine-right.paint.json").string()}));
  }
  const scene::Scene scene = scene::load_scene((folder_ / "session" / "mine.toml").string());
  pipeline::BakeRequest request;
  request.output.folder = folder_ / "independent";
  request.output.formats = {"none"};
  request.devices = {{.kind = pipeline::DeviceRequest::Kind::cpu}};
  const auto prepared = pipeline::prepare_bake(scene, request, {});
  EXPECT_EQ(pipeline::run_bake(*prepared, request, {}).last_position_hash, recorded.at("position_hash"));
  const Running again = open();
  const auto client = again.open();
  EXPECT_EQ(start_of(*client).messages.at("history").at("undo"), "paint stiffness");
}

// A paint file that the session saved remains its own while its character is unpainted.
TEST_F(SessionPaintsTest, PaintThatWasTakenBackIsSavedAgain) {
  const std::size_t size = arm().surface.vertices.size(), middle = size / 2;
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  const auto paint = [&](std::size_t vertex, double value, std::uint64_t number) {
    Json one = stroke("_LAYER", value, number);
    one["places"] = {rest_of(start, vertex)};
    client->say(one);
    client->wait_for("applied");
  };
  const auto save = [&] {
    client->say({{"type", "save"}, {"file", "mine.toml"}, {"id", 7}});
    while (const auto message = client->next()) {
      if (!message->is_text) continue;
      Json json = Json::parse(message->bytes);
      if (json.value("id", 0) == 7) return json;
    }
    return Json();
  };
  paint(middle, 1.0, 1);
  paint(size + middle, 1.0, 2);
  EXPECT_EQ(save().at("type"), "done");
  client->say({{"type", "undo"}});
  client->wait_for("applied");
  EXPECT_EQ(save().at("type"), "done");
  client->say({{"type", "redo"}});
  client->wait_for("applied");
  paint(size + middle, 2.0, 3);
  const Json last = save();
  EXPECT_EQ(last.at("type"), "done") << last;
  const rig::Paint right =
      scene::parse_paint(read(folder_ / "session" / "mine-right.paint.json"), "mine", arm().surface);
  EXPECT_EQ(std::count(right.attributes.at(0).value.begin(), right.attributes.at(0).value.end(), 1.0f), 0);
  // The control: a file that someone else has changed meanwhile is not the session's.
  base::write_whole(folder_ / "session" / "mine-right.paint.json", "{}");
  paint(size + middle, 1.0, 4);
  EXPECT_EQ(save().at("type"), "refused");
}

// A stroke rewrites only the paint of the character it touches; from a shared file it makes a separate one.
TEST_F(SessionPaintsTest, AStrokeLeavesThePaintOfOthers) {
  const std::size_t size = arm().surface.vertices.size(), middle = size / 2;
  const rig::Paint one{rig::surface_hash(arm().surface), size, {{"_STIFFNESS", {5}, {0.5f}}}};
  // As another program might format it.
  const std::string shared = scene::paint_text(one) + "\n \n";
  base::write_whole(folder_ / "both.paint.json", shared);
  base::write_whole(scene_,
                    "[scene]\nend = 0.1\n[character.left]\nmade = \"arm\"\nresolution = 0.04\n"
                    "paint = \"both.paint.json\"\n"
                    "[character.right]\nmade = \"arm\"\nresolution = 0.04\nat = [0.0, 0.0, 1.0]\n"
                    "paint = \"both.paint.json\"\n");
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  Json right = stroke("_LAYER", 1.0);
  right["places"] = {rest_of(start, size + middle)};
  client->say(right);
  const Json keys = client->wait_for("keys");
  EXPECT_EQ(key_of(keys, "character.left.paint").at("value"), "both.paint.json");
  EXPECT_EQ(key_of(keys, "character.right.paint").at("value"), "arms-right.paint.json");
  client->wait_for("applied");
  client->say({{"type", "save"}, {"file", "mine.toml"}});
  client->wait_for("saved");
  EXPECT_EQ(read(folder_ / "both.paint.json"), shared);
  EXPECT_EQ(read(folder_ / "session" / "mine-left.paint.json"), shared);
  EXPECT_EQ(scene::parse_paint(read(folder_ / "session" / "mine-right.paint.json"), "mine", arm().surface)
                .attributes.size(),
            2u);
}

}  // namespace
}  // namespace fascicle::tests
