// The session file.
#include "host/studio/session_file.h"

#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "host/base/file.h"
#include "host/scene/input_files.h"
#include "host/studio/session.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using studio::parse_session;
using studio::SessionRecord;

SessionRecord sample() {
  return {.source = "man.toml",
          .base_hash = "0123456789abcdef",
          .steps = {{"", "[scene]\n# \xc3\xa4\n"}, {"softer", "[scene]\nfps = 30\n"}},
          .at = 1,
          .saved_file = "man.toml",
          .saved_hash = "fedcba9876543210",
          .saved_text = "0011"};
}

TEST(SessionFile, ReadsBack) {
  const SessionRecord record = sample();
  const auto again = parse_session(studio::session_text(record));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->source, record.source);
  EXPECT_EQ(again->base_hash, record.base_hash);
  EXPECT_EQ(again->at, record.at);
  EXPECT_EQ(again->saved_file, record.saved_file);
  EXPECT_EQ(again->saved_hash, record.saved_hash);
  EXPECT_EQ(again->saved_text, record.saved_text);
  ASSERT_EQ(again->steps.size(), 2u);
  EXPECT_EQ(again->steps[0].text, record.steps[0].text);
  EXPECT_EQ(again->steps[1].label, "softer");
}

TEST(SessionFile, SaysWhatWasBuilt) {
  SessionRecord record = sample();
  record.steps[0].is_built = true;
  const std::string text = studio::session_text(record);
  const auto again = parse_session(text);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->steps[0].is_built);
  EXPECT_FALSE(again->steps[1].is_built);
  // Older programs did not say it, and restored every step.
  std::string old = text;
  for (const std::string member : {",\n   \"built\": true", ",\n   \"built\": false"}) {
    ASSERT_NE(old.find(member), std::string::npos) << old;
    old.erase(old.find(member), member.size());
  }
  const auto of_old = parse_session(old);
  ASSERT_TRUE(of_old);
  EXPECT_TRUE(of_old->steps[0].is_built && of_old->steps[1].is_built);
}

// The history of a scene with any name outlives its first save.
TEST(SessionFile, SavedSceneMayHaveAnyFileName) {
  for (const std::string name : {"my bar.toml", "man (1).toml", "m\xc3\xbcller.toml"}) {
    SessionRecord record = sample();
    record.saved_file = name;
    const auto again = parse_session(studio::session_text(record));
    ASSERT_TRUE(again) << name;
    EXPECT_EQ(again->saved_file, name);
    EXPECT_EQ(again->steps.size(), 2u);
  }
}

TEST(SessionFile, AHiddenSceneMayKeepItsName) {
  SessionRecord record = sample();
  record.saved_file = ".man.toml";
  const std::string text = studio::session_text(record);
  EXPECT_TRUE(parse_session(text, ".man.toml"));
  EXPECT_FALSE(parse_session(text, ".woman.toml"));
  EXPECT_FALSE(parse_session(text));
}

// Steps that share a paint store it once.
TEST(SessionFile, KeepsPaintOnce) {
  SessionRecord record = sample();
  record.saved_paints = {{"character.paint", "1234"}};
  const auto paint = std::make_shared<const std::string>("{\"fascicle_paint\": 1}");
  record.steps.push_back({"paint", "a", {{"character.paint", paint}}});
  record.steps.push_back({"softer", "b", {{"character.paint", paint}, {"character.left.paint", paint}}});
  const std::string text = studio::session_text(record);
  EXPECT_EQ(text.find("fascicle_paint"), text.rfind("fascicle_paint"));
  const auto again = parse_session(text);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->saved_paints.at("character.paint"), "1234");
  EXPECT_TRUE(again->steps[1].paints.empty());
  ASSERT_EQ(again->steps[2].paints.count("character.paint"), 1u);
  const auto& read = again->steps[2].paints.at("character.paint");
  EXPECT_EQ(*read, *paint);
  EXPECT_EQ(again->steps[3].paints.at("character.paint"), read);
  EXPECT_EQ(again->steps[3].paints.at("character.left.paint"), read) << "two characters may share it";
  std::string beyond = text;
  constexpr std::string_view number = "\"character.paint\": 0";
  beyond.replace(beyond.find(number), number.size(), "\"character.paint\": 7");
  EXPECT_FALSE(parse_session(beyond));
}

TEST(SessionFile, WhatIsDamagedIsNoSession) {
  const std::string text = studio::session_text(sample());
  for (std::size_t k = 0; k < text.size(); ++k) {
    EXPECT_FALSE(parse_session(text.substr(0, k)));
    std::string changed = text;
    changed[k] = static_cast<char>(changed[k] ^ 1);
    (void)parse_session(changed);  // either result is fine, as long as it does not throw
  }
  EXPECT_FALSE(parse_session("{}"));
  EXPECT_FALSE(parse_session("[]"));
  // File names outside the folder are refused, because bakes write to them.
  for (const char* elsewhere :
       {"../man.toml", "/root/.bashrc", ".bashrc", "a/b.toml", ".toml", "man", "/man.toml"}) {
    SessionRecord stranger = sample();
    stranger.saved_file = elsewhere;
    EXPECT_FALSE(parse_session(studio::session_text(stranger))) << elsewhere;
  }
  SessionRecord beyond = sample();
  beyond.at = 2;
  EXPECT_FALSE(parse_session(studio::session_text(beyond)));
}

// File names are derived from the keys of paints.
TEST(SessionFile, PaintIsOfCharactersAlone) {
  const auto with_key = [](const std::string& key) {
    SessionRecord record = sample();
    record.steps.push_back({"paint", "a", {{key, std::make_shared<const std::string>("{}")}}});
    return parse_session(studio::session_text(record));
  };
  for (const char* key : {"character.paint", "character.left.paint", "character.left-2_b.paint"})
    EXPECT_TRUE(with_key(key)) << key;
  for (const char* key :
       {"character./../../evil.paint", "character.../evil.paint", "character.a/b.paint", "character..paint",
        "character.paint/../x", "character.left.file", "character.", "paint", "", "x.left.paint",
        "character.left.paint.paint/", "character.a\\b.paint", "character.left.paint\n"})
    EXPECT_FALSE(with_key(key)) << key;
}

// Many keys can name one large paint, and cost time that grows with their square.
TEST(SessionFile, PaintIsOfAsManyCharactersAsASceneMayHave) {
  const auto with_keys = [](int count) {
    SessionRecord record = sample();
    record.steps.push_back({"paint", "a", {}});
    const auto paint = std::make_shared<const std::string>("{}");
    for (int k = 0; k < count; ++k)
      record.steps.back().paints["character.a" + std::to_string(k) + ".paint"] = paint;
    return parse_session(studio::session_text(record));
  };
  ASSERT_TRUE(with_keys(256));
  EXPECT_EQ(with_keys(256)->steps.back().paints.size(), 256u);
  EXPECT_FALSE(with_keys(257));
}

TEST(SessionFile, HashesOfPaintAreThoseOfAllText) {
  const studio::Paints paints{{"character.a.paint", std::make_shared<const std::string>("one")},
                              {"character.b.paint", std::make_shared<const std::string>("two")}};
  EXPECT_EQ(studio::hash_of_all("text", paints), scene::hash_of("textonetwo"));
  EXPECT_EQ(studio::hash_of_all("text", {}), scene::hash_of("text"));
}

TEST(SessionFile, TheNewestIsOnDiskWhenTheWriterGoes) {
  const fs::path folder = fs::temp_directory_path() / "fascicle-session-writer";
  fs::remove_all(folder);
  fs::create_directories(folder);
  {
    studio::SessionWriter writer(folder, [](const std::string& error) { EXPECT_EQ(error, ""); });
    for (int k = 0; k < 200; ++k) {
      SessionRecord record = sample();
      record.steps[1].text = std::to_string(k);
      writer.put(std::move(record));
    }
  }
  const auto found = studio::read_session(folder);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->steps[1].text, "199");
  fs::remove_all(folder);
}

}  // namespace
}  // namespace fascicle::tests
