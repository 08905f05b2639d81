// The studio as a page sees it, through a client that opens the printed address.
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "host/base/file.h"
#include "host/studio/session_file.h"
#include "tests/studio/running_studio.h"

namespace fascicle::tests {
namespace {

TEST_F(SessionTest, SendsAllThatThePageNeedsThenFrames) {
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  const Json& hello = start.messages.at("hello");
  EXPECT_EQ(hello.at("protocol"), 1);
  EXPECT_EQ(hello.at("kind"), "live");
  EXPECT_EQ(hello.at("can_touch"), true);
  EXPECT_EQ(hello.at("restored"), false);
  const Json& body = start.messages.at("body");
  EXPECT_EQ(body.at("counts").at("vertices"), 81);
  for (const Json& name : body.at("arrays")) EXPECT_EQ(start.arrays.count(name), 1u) << name;
  EXPECT_EQ(start.arrays.at("rest").floats.size(), 3u * 81u);
  EXPECT_EQ(start.arrays.at("layer").numbers.size(), 81u);
  for (const std::uint32_t v : start.arrays.at("tetrahedron").numbers) EXPECT_LT(v, 81u);
  EXPECT_EQ(start.messages.at("clip").at("frames"), 30);
  const Json frequency = key_of(start.messages.at("keys"), "layers.body.frequency");
  EXPECT_EQ(frequency.at("value"), 6.0);
  EXPECT_EQ(frequency.at("is_set"), true);
  EXPECT_EQ(frequency.at("unit"), "Hz");
  EXPECT_EQ(frequency.at("effect"), "live");
  EXPECT_EQ(frequency.at("rivals").size(), 4u);
  EXPECT_EQ(key_of(start.messages.at("keys"), "bar.jitter").at("effect"), "rebuild");
  EXPECT_EQ(key_of(start.messages.at("keys"), "layers.body.beta").at("is_set"), false);
  EXPECT_FALSE(start.messages.at("presets").at("list").empty());
  client->say({{"type", "show"}, {"id", 1}, {"blocks", {"surface", "vertices"}}});
  EXPECT_EQ(client->wait_for("done").at("id"), 1);
  const DecodedFrame frame = decode_frame(client->wait_for_frame(
      [](const std::string& bytes) { return decode_frame(bytes).blocks.size() == 2; }));
  EXPECT_EQ(frame.blocks.at(4).size(), 3u * 81u);
  EXPECT_EQ(frame.body, body.at("body"));
}

TEST_F(SessionTest, ThePlayerObeys) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "pause"}});
  while (client->wait_for("player").at("state") != "paused") {
  }
  client->say({{"type", "seek"}, {"frame", 12}});
  const DecodedFrame at = decode_frame(
      client->wait_for_frame([](const std::string& bytes) { return decode_frame(bytes).frame == 12; }));
  EXPECT_NEAR(at.time, 12.0 / 60.0, 1e-9);
  client->say({{"type", "step"}});
  const DecodedFrame next = decode_frame(
      client->wait_for_frame([](const std::string& bytes) { return decode_frame(bytes).frame == 13; }));
  EXPECT_GT(next.sequence, at.sequence);
  client->say({{"type", "loop"}, {"on", false}});
  client->say({{"type", "speed"}, {"factor", 4}});
  client->say({{"type", "play"}});
  // Text messages overtake frames, so either may arrive first.
  bool has_played = false, is_at_end = false, is_paused = false;
  while (!is_at_end || !is_paused) {
    const auto message = client->next();
    ASSERT_TRUE(message) << is_at_end << is_paused;
    if (!message->is_text) {
      is_at_end = is_at_end || (message->bytes[0] == 1 && decode_frame(message->bytes).frame == 30);
      continue;
    }
    const Json json = Json::parse(message->bytes);
    if (json.at("type") != "player") continue;
    // The state may still be reported as paused for earlier requests.
    has_played = has_played || json.at("state") == "playing";
    if (!has_played || json.at("state") != "paused") continue;
    EXPECT_EQ(json.at("frame"), 30);
    is_paused = true;
  }
}

// A studio in the background costs nothing.
TEST_F(SessionTest, WhereNobodyLooksNothingIsComputed) {
  const Running studio = open();
  const auto sequence_of_next = [&] {
    const auto client = studio.open();
    start_of(*client);
    return decode_frame(client->wait_for_frame([](const std::string&) { return true; })).sequence;
  };
  const std::uint32_t first = sequence_of_next();
  std::this_thread::sleep_for(std::chrono::seconds(5));
  // Five seconds have 300 frames; only a few are computed before the closed page is noticed.
  EXPECT_LT(sequence_of_next() - first, 150U);
}

TEST_F(SessionTest, WhatMakesNoSenseIsRefusedAndTheSessionGoesOn) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  for (const char* text : {"{", "[]", R"({"type":"x"})", R"({"type":"seek","frame":-1})"}) {
    client->say_text(text);
    EXPECT_FALSE(client->wait_for("refused").at("error").get<std::string>().empty());
  }
  client->say_binary("\1\2\3");
  client->wait_for("refused");
  client->say({{"type", "set"}, {"id", 9}, {"changes", {{"layers.body.frequency", -1.0}}}});
  Json refused = client->wait_for("refused");
  EXPECT_EQ(refused.at("id"), 9);
  EXPECT_EQ(refused.at("error"), "layers.body.frequency: is -1; must be above 0");
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequncy", 1.0}}}});
  EXPECT_NE(client->wait_for("refused").at("error").get<std::string>().find("frequency"), std::string::npos);
  client->say({{"type", "set"}, {"changes", {{"layers.nobody.frequency", 1.0}}}});
  client->wait_for("refused");
  client->say({{"type", "undo"}});
  client->wait_for("refused");
  client->say({{"type", "play"}, {"id", 10}});
  EXPECT_EQ(client->wait_for("done").at("id"), 10);
  for (int k = 0; k < 200; ++k) client->say_text("{");
  while (client->next(std::chrono::seconds(5))) {
  }
  EXPECT_TRUE(client->is_closed());
  EXPECT_NE(client->close_reason().find("invalid messages"), std::string::npos);
  const auto other = studio.open();
  start_of(*other);
}

// Changes, undo and redo reach the flesh, and the page is told how long each took.
TEST_F(SessionTest, ChangesAreAppliedUndoneAndMadeAgain) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 3.0}}}, {"label", "softer"}});
  Json changed = client->wait_for("changed");
  EXPECT_EQ(changed.at("changes").at("layers.body.frequency"), 3.0);
  EXPECT_EQ(changed.at("effect"), "live");
  EXPECT_EQ(client->wait_for("history").at("undo"), "softer");
  Json applied = client->wait_for("applied");
  EXPECT_EQ(applied.at("revision"), changed.at("revision"));
  RecordProperty("seconds_from_change_to_frame", applied.at("seconds").dump());
  const auto shows = [&](const Json& revision) {
    client->wait_for_frame(
        [&](const std::string& bytes) { return decode_frame(bytes).revision == revision; });
  };
  shows(changed.at("revision"));
  client->say({{"type", "undo"}});
  changed = client->wait_for("changed");
  EXPECT_EQ(changed.at("changes").at("layers.body.frequency"), 6.0);
  EXPECT_EQ(client->wait_for("history").at("redo"), "softer");
  shows(changed.at("revision"));
  client->say({{"type", "redo"}});
  changed = client->wait_for("changed");
  EXPECT_EQ(changed.at("changes").at("layers.body.frequency"), 3.0);
  shows(changed.at("revision"));
  // Setting a key removes its rival.
  client->say({{"type", "set"}, {"changes", {{"layers.body.youngs_modulus", 4000.0}}}});
  changed = client->wait_for("changed");
  EXPECT_TRUE(changed.at("changes").at("layers.body.frequency").is_null());
  shows(changed.at("revision"));
  // A finer bar needs a new body.
  client->say({{"type", "set"}, {"changes", {{"bar.vertices", {11, 3, 3}}}}});
  EXPECT_EQ(client->wait_for("changed").at("effect"), "rebuild");
  const Json body = client->wait_for("body");
  EXPECT_EQ(body.at("counts").at("vertices"), 99);
  client->wait_for_frame(
      [&](const std::string& bytes) { return decode_frame(bytes).body == body.at("body"); });
}

TEST_F(SessionTest, AChangeThatCannotBeBuiltIsTakenBack) {
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"},
               {"changes", {{"probe.tip.where", {{"sphere", {{"center", {9, 9, 9}}, {"radius", 0.1}}}}}}}});
  const Json failed = client->wait_for("failed");
  EXPECT_NE(failed.at("error").get<std::string>().find("holds no vertex"), std::string::npos);
  EXPECT_TRUE(client->wait_for("history").at("undo").is_null());
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
  client->wait_for("applied");
}

TEST_F(SessionTest, PresetsChangeNamedKeys) {
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  std::map<std::string, Json> presets;
  for (const Json& preset : start.messages.at("presets").at("list")) presets[preset.at("name")] = preset;
  for (const char* name : {"more-jiggle", "firmer", "heavier", "cartoon"}) {
    EXPECT_FALSE(presets.at(name).at("changes").empty()) << name;
    EXPECT_FALSE(presets.at(name).contains("why_not")) << name;
  }
  EXPECT_TRUE(presets.at("only-tail").contains("why_not"));
  client->say({{"type", "preset"}, {"name", "only-tail"}});
  client->wait_for("refused");
  client->say({{"type", "preset"}, {"name", "more-jiggle"}});
  const Json changed = client->wait_for("changed");
  for (const auto& [path, value] : presets.at("more-jiggle").at("changes").items())
    EXPECT_EQ(changed.at("changes").at(path), value) << path;
  client->wait_for("applied");
}

// As after SIGKILL: a copy of the session folder as it is on disk.
TEST_F(SessionTest, WhatWasChangedIsThereAfterAKill) {
  const fs::path copy = folder_ / "copy";
  {
    const Running studio = open();
    const auto client = studio.open();
    start_of(*client);
    for (const double value : {5.0, 4.0, 3.0}) {
      client->say({{"type", "set"},
                   {"changes", {{"layers.body.frequency", value}}},
                   {"label", "to " + std::to_string(value)}});
      client->wait_for("applied");
    }
    client->say({{"type", "undo"}});
    client->wait_for("applied");
    // Waits until the newest step is on disk.
    for (;;) {
      const auto there = studio::read_session(folder_ / "session");
      if (there && there->steps.size() == 4 && there->at == 2) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    fs::create_directories(copy);
    fs::copy_file(folder_ / "session" / studio::session_file_name, copy / studio::session_file_name);
  }
  // With another name for the same file.
  const fs::path name = scene_.parent_path() / "." / scene_.filename();
  const Running again(name.string(), copy, folder_ / "cache");
  const auto client = again.open();
  const Start start = start_of(*client);
  EXPECT_EQ(start.messages.at("hello").at("restored"), true);
  EXPECT_EQ(key_of(start.messages.at("keys"), "layers.body.frequency").at("value"), 4.0);
  EXPECT_EQ(start.messages.at("history").at("redo"), "to 3.000000");
  client->say({{"type", "redo"}});
  EXPECT_EQ(client->wait_for("changed").at("changes").at("layers.body.frequency"), 3.0);
}

TEST_F(SessionTest, AnotherSceneBeginsAnewAndTheOldSessionIsKept) {
  {
    const Running studio = open();
    const auto client = studio.open();
    start_of(*client);
    client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
    client->wait_for("applied");
  }
  base::write_whole(scene_, std::string(bar_text) + "# more\n");
  const Running studio = open();
  const auto client = studio.open();
  const Start start = start_of(*client);
  EXPECT_EQ(start.messages.at("hello").at("restored"), false);
  EXPECT_EQ(key_of(start.messages.at("keys"), "layers.body.frequency").at("value"), 6.0);
  EXPECT_TRUE(fs::exists(folder_ / "session" / studio::old_session_file_name));
}

TEST_F(SessionTest, EveryOldSessionIsKept) {
  const fs::path session = folder_ / "session";
  fs::create_directories(session);
  for (const char* text : {"{\"first\": 1}", "{\"second\": 1}", "{\"third\": 1}"}) {
    base::write_whole(session / studio::session_file_name, text);
    const Running studio = open();
    start_of(*studio.open());
  }
  EXPECT_EQ(read(session / "session.before.json"), "{\"first\": 1}");
  EXPECT_EQ(read(session / "session.before-2.json"), "{\"second\": 1}");
  EXPECT_EQ(read(session / "session.before-3.json"), "{\"third\": 1}");
}

// The version is 2: sessions of older and newer programs are not opened.
TEST_F(SessionTest, ASessionOfAnotherVersionIsKept) {
  for (const char* version : {"1", "3"}) {
    const fs::path session = folder_ / ("session-" + std::string(version));
    std::string text;
    {
      const Running studio(scene_.string(), session, folder_ / "cache");
      const auto client = studio.open();
      start_of(*client);
      client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
      client->wait_for("applied");
    }
    text = read(session / "session.json");
    constexpr std::string_view own = "\"fascicle_studio\": 2";
    ASSERT_NE(text.find(own), std::string::npos);
    {
      // The control: a session of this version is opened.
      const Running studio(scene_.string(), session, folder_ / "cache");
      EXPECT_EQ(start_of(*studio.open()).messages.at("hello").at("restored"), true);
    }
    text.replace(text.find(own), own.size(), "\"fascicle_studio\": " + std::string(version));
    base::write_whole(session / "session.json", text);
    const Running studio(scene_.string(), session, folder_ / "cache");
    const auto client = studio.open();
    EXPECT_EQ(start_of(*client).messages.at("hello").at("restored"), false);
    EXPECT_EQ(read(session / "session.before.json"), text);
  }
}

TEST_F(SessionTest, ASessionThatCannotBeReadIsKept) {
  fs::create_directories(folder_ / "session");
  base::write_whole(folder_ / "session" / "session.json", "{\"fascicle_studio\": 2}");
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
  client->wait_for("applied");
  EXPECT_EQ(read(folder_ / "session" / "session.before.json"), "{\"fascicle_studio\": 2}");
}

// A session as another program, or a stranger, may have written it.
class ForeignSession : public SessionTest {
 protected:
  static std::string bar_with(const std::string& line) {
    std::string text = bar_text;
    constexpr std::string_view own = "frequency = 6.0   # Hz: the bar's own";
    return text.replace(text.find(own), own.size(), line);
  }
  // Returns the file's text.
  std::string leave(std::vector<studio::HistoryStep> steps, std::size_t at) {
    const std::string text = studio::session_text({.source = scene_.string(),
                                                   .base_hash = studio::hash_of_all(bar_text, {}),
                                                   .steps = std::move(steps),
                                                   .at = at});
    fs::create_directories(folder_ / "session");
    base::write_whole(folder_ / "session" / studio::session_file_name, text);
    return text;
  }
  static Json frequency(const Start& start) {
    return key_of(start.messages.at("keys"), "layers.body.frequency").at("value");
  }
};

// It may be what killed the program, and would kill it again at each start.
TEST_F(ForeignSession, AChangeThatWasNeverShownIsOnlyOfferedAgain) {
  leave({{"", bar_text, {}, true},
         {"softer", bar_with("frequency = 3.0"), {}, true},
         {"softest", bar_with("frequency = 2.0"), {}, false}},
        2);
  {
    const Running studio = open();
    const auto client = studio.open();
    const Start start = start_of(*client);
    const Json& hello = start.messages.at("hello");
    EXPECT_EQ(hello.at("restored"), true);
    EXPECT_NE(hello.at("message").get<std::string>().find("softest. Redo"), std::string::npos) << hello;
    EXPECT_EQ(frequency(start), 3.0);
    EXPECT_EQ(start.messages.at("history").at("undo"), "softer");
    client->say({{"type", "redo"}});
    client->wait_for("applied");
    bool is_noted = false;
    for (int k = 0; k < 1000 && !is_noted; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const auto there = studio::read_session(folder_ / "session");
      is_noted = there && there->at == 2 && there->steps[2].is_built;
    }
    EXPECT_TRUE(is_noted);
  }
  // The control: now it was shown.
  const Running studio = open();
  EXPECT_EQ(frequency(start_of(*studio.open())), 2.0);
}

TEST_F(ForeignSession, OneStepThatIsNotTheSceneIsARestoredSession) {
  leave({{"", bar_with("frequency = 3.0"), {}, true}}, 0);
  {
    const Running studio = open();
    const Start start = start_of(*studio.open());
    EXPECT_EQ(start.messages.at("hello").at("restored"), true);
    EXPECT_EQ(frequency(start), 3.0);
  }
  leave({{"", bar_text, {}, true}}, 0);
  const Running studio = open();
  EXPECT_EQ(start_of(*studio.open()).messages.at("hello").at("restored"), false) << "the control";
}

TEST_F(ForeignSession, WhatCannotBeBuiltIsKeptAndTheSceneBegins) {
  const std::string no_vertex =
      std::string(bar_text) + "[probe.far]\nwhere = { sphere = { center = [9, 9, 9], radius = 0.1 } }\n";
  const std::vector<std::string> wrong{bar_with("damping = \"x\""), "layers = { body = 1 }\n", "[",
                                       no_vertex};
  for (const std::string& text : wrong)
    for (const bool is_alone : {true, false}) {
      std::vector<studio::HistoryStep> steps{{"", text, {}, true}};
      if (!is_alone) steps.insert(steps.begin(), {"", bar_text, {}, true});
      const std::size_t at = steps.size() - 1;
      const std::string file = leave(std::move(steps), at);
      {
        const Running studio = open();
        const auto client = studio.open();
        const Start start = start_of(*client);
        EXPECT_EQ(start.messages.at("hello").at("restored"), false);
        EXPECT_EQ(frequency(start), 6.0);
        EXPECT_TRUE(start.messages.at("history").at("undo").is_null());
        client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
        client->wait_for("applied");
      }
      EXPECT_EQ(read(folder_ / "session" / studio::old_session_file_name), file);
      fs::remove_all(folder_ / "session");
    }
}

TEST_F(ForeignSession, AStepOfAWrongTextIsRefused) {
  leave({{"", "layers = { body = 1 }\n", {}, true},
         {"here", bar_text, {}, true},
         {"text", bar_with("density = \"x\""), {}, true}},
        1);
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  for (const char* way : {"undo", "redo"}) {
    client->say({{"type", way}});
    EXPECT_NE(client->wait_for("refused").at("error"), "");
  }
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
  client->wait_for("applied");
}

// Nothing has read such paint, and file names are made from its keys.
TEST_F(ForeignSession, PaintThatTheSceneDoesNotNameIsNotSaved) {
  const auto paint = std::make_shared<const std::string>(1024, 'x');
  leave({{"", bar_text, {}, true},
         {"softer",
          bar_with("frequency = 3.0"),
          {{"character.paint", paint}, {"character.a0.paint", paint}, {"character.a1.paint", paint}},
          true}},
        1);
  const Running studio = open();
  const auto client = studio.open();
  EXPECT_EQ(frequency(start_of(*client)), 3.0);
  client->say({{"type", "save"}});
  const Json saved = client->wait_for("saved");
  EXPECT_FALSE(saved.contains("paints")) << saved;
  std::size_t scenes = 0;
  for (const auto& file : fs::directory_iterator(folder_ / "session")) {
    EXPECT_EQ(file.path().string().find(".paint"), std::string::npos) << file.path();
    scenes += file.path().extension() == ".toml";
  }
  EXPECT_EQ(scenes, 1u);
}

TEST_F(ForeignSession, AFolderInItsPlaceIsKept) {
  fs::create_directories(folder_ / "session" / studio::session_file_name);
  const Running studio = open();
  const auto client = studio.open();
  start_of(*client);
  client->say({{"type", "set"}, {"changes", {{"layers.body.frequency", 5.0}}}});
  client->wait_for("applied");
  EXPECT_TRUE(fs::is_directory(folder_ / "session" / studio::old_session_file_name));
}

// Each page numbers its gestures from 1.
TEST_F(SessionTest, GesturesOfTwoPagesAreTwoSteps) {
  const Running studio = open();
  const auto one = studio.open(), other = studio.open();
  start_of(*one);
  start_of(*other);
  one->say({{"type", "set"}, {"gesture", 1}, {"changes", {{"layers.body.frequency", 5.0}}}});
  EXPECT_EQ(one->wait_for("history").at("steps"), 2);
  other->say({{"type", "set"}, {"gesture", 1}, {"changes", {{"layers.body.damping", 5.0}}}});
  Json history = other->wait_for("history");
  while (history.at("undo") != "layers.body.damping") history = other->wait_for("history");
  EXPECT_EQ(history.at("steps"), 3);
}

TEST_F(SessionTest, ASlowPageGetsTheNewestFrameAndNoMemory) {
  const Running studio = open();
  const auto slow = studio.open({.receive_buffer = 4096});
  const auto quick = studio.open();
  start_of(*quick);
  std::uint32_t last = 0;
  for (int k = 0; k < 300; ++k)
    last = decode_frame(quick->wait_for_frame([](const std::string&) { return true; })).sequence;
  start_of(*slow);
  // Frames in socket buffers are old; later ones are new.
  std::uint32_t newest = 0;
  for (int k = 0; k < 2000 && newest < last; ++k)
    newest = decode_frame(slow->wait_for_frame([](const std::string&) { return true; })).sequence;
  EXPECT_GE(newest, last);
}

TEST_F(SessionTest, TheHandIsOnePagesAtATime) {
  const Running studio = open();
  auto one = studio.open();
  const auto two = studio.open();
  start_of(*one);
  start_of(*two);
  one->say(
      {{"type", "hand"}, {"action", "grab"}, {"vertex", 80}, {"of", "vertices"}, {"place", {0.4, 0.1, 0.1}}});
  EXPECT_EQ(one->wait_for("hand").at("is_held"), true);
  two->say({{"type", "hand"}, {"action", "grab"}, {"vertex", 0}, {"of", "vertices"}, {"place", {0, 0, 0}}});
  two->wait_for("refused");
  one->say({{"type", "hand"}, {"action", "move"}, {"place", {0.4, 0.2, 0.1}}});
  two->wait_for_frame([](const std::string& bytes) { return (decode_frame(bytes).flags & 2u) != 0; });
  one.reset();
  two->wait_for_frame([](const std::string& bytes) { return (decode_frame(bytes).flags & 2u) == 0; });
  two->say(
      {{"type", "hand"}, {"action", "grab"}, {"vertex", 80}, {"of", "vertices"}, {"place", {0.4, 0.1, 0.1}}});
  EXPECT_EQ(two->wait_for("hand").at("is_held"), true);
  two->say({{"type", "hand"}, {"action", "grab"}, {"vertex", 4000000}, {"place", {0, 0, 0}}});
  two->wait_for("refused");
}

}  // namespace
}  // namespace fascicle::tests
