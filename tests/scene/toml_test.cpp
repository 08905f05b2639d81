// Hostile TOML: input that would crash toml++ never reaches it.
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/scene/jobs.h"
#include "tests/scene/scene_samples.h"
#include "tests/scene/scene_texts.h"

namespace fascicle::tests {
namespace {

std::string repeated(const std::string& text, std::size_t times) {
  std::string all;
  all.reserve(text.size() * times);
  for (std::size_t k = 0; k < times; ++k) all += text;
  return all;
}

// `times` lines, each with its number.
std::string dotted_lines(const std::string& before, const std::string& after, std::size_t times,
                         const std::string& end = "\n") {
  std::string all;
  for (std::size_t k = 0; k < times; ++k) all += before + std::to_string(k) + after + end;
  return all;
}

struct Refused {
  std::string text, message;
};

const std::vector<Refused>& refused_texts() {
  constexpr std::size_t many = 200'000;
  static const std::vector<Refused> list{
      {"a" + repeated(".a", many) + " = 1", "1: TOML: column 64: a key of more than 32 parts"},
      {"\n[a" + repeated(".a", many) + "]", "2: TOML: column 65: a key of more than 32 parts"},
      {"\"a\"" + repeated(" . 'a'", many) + " = 1", "1: TOML: column 191: a key of more than 32 parts"},
      {"x = { a" + repeated(".a", many) + " = 1 }", "1: TOML: column 70: a key of more than 32 parts"},
      {"x = " + repeated("[", many), "1: TOML: column 37: nested deeper than 32 levels"},
      {"x = " + repeated("{a=", many), "1: TOML: column 101: nested deeper than 32 levels"},
      {"x = " + repeated("[{a=", many), "1: TOML: column 69: nested deeper than 32 levels"},
      {repeated("[", many), "1: TOML: column 33: nested deeper than 32 levels"},
      // Preceding strings and comments do not hide it.
      {"s = \"\"\"\n\\\"\"\"\"\"\" # '\nt = '\\'\na" + repeated(".a", many), "4: TOML: column 64: a key of"},
      {"s = '''\n'\n'''''\na" + repeated(".a", many), "4: TOML: column 64: a key of"},
      {"# \u00e4\n\"\u00e4\" = \"\xff\"", "2: TOML: column 8: not valid UTF-8"},
      {"\xc3", "1: TOML: column 1: not valid UTF-8"},
      {"a = \"\xed\xa0\x80\"", "1: TOML: column 6: not valid UTF-8"},
      {"a = 1979-05-27" + repeated("_", 117) + " 11",
       "1: TOML: column 79: a word of more than 64 underscores"},
      {"\u00eb = 1", "1: TOML: "},
      {"a = [1, \u00eb]", "1: TOML: "},
      {std::string("a = 1\n\0", 7), "2: TOML: column 1: a zero byte"},
      {dotted_lines("a", ".b = 1", 60'000), "50001: TOML: column 7: more than 50000 dots in keys"},
      {dotted_lines("[a", ".b]", 60'000), "50001: TOML: column 8: more than 50000 dots in keys"},
      {dotted_lines("[[a", "]]", 60'000), "50001: TOML: column 2: more than 50000 dots in keys"},
      {"x = {" + dotted_lines("a", ".b = 1.0,", 60'000, ""), "1: TOML: column "},
      {repeated("# filler\n", 2'000'000), "1: TOML: column 1: has more than the 16777216 bytes"}};
  return list;
}

TEST(StrangeToml, IsRefusedWithLineAndColumn) {
  for (const auto& [text, message] : refused_texts())
    EXPECT_TRUE(refusal_of_text(text).starts_with("sample.toml:" + message))
        << text.substr(0, 40) << ": " << refusal_of_text(text).substr(0, 200);
}

TEST(StrangeToml, IsRefusedInListsOfJobsToo) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("fascicle-strange-" + std::to_string(getpid()) + ".toml");
  for (const auto& [text, message] : refused_texts()) {
    std::ofstream(file, std::ios::binary) << text;
    std::string said = "no error";
    try {
      (void)scene::read_jobs(file);
    } catch (const scene::SceneError& error) {
      said = error.what();
    }
    // Files are refused by their size before they are read.
    const bool is_large = text.size() > (std::size_t{16} << 20);
    const std::string expected = is_large ? ": has more than the 16777216 bytes" : ":" + message;
    EXPECT_TRUE(said.starts_with(file.string() + expected)) << said.substr(0, 200);
  }
  std::filesystem::remove(file);
}

TEST(StrangeToml, IsRefusedInValuesThatAreSet) {
  EXPECT_NE(refusal_of_text(bar_sample(), {.set = {"layers.fat.alpha={a" + repeated(".a", 50'000) + "=1}"}}),
            "no error");
  for (const auto& refused : refused_texts()) {
    const std::size_t equals = refused.text.find('=');
    const std::string value = equals == std::string::npos ? refused.text : refused.text.substr(equals + 1);
    if (value == " 1") continue;  // in this pair the key is the hostile part
    EXPECT_NE(refusal_of_text(bar_sample(), {.set = {"layers.fat.alpha=" + value}}), "no error");
    // A key that takes text accepts any text, or refuses it by name as above; nothing else is thrown.
    EXPECT_NO_THROW((void)refusal_of_text(bar_sample(), {.set = {"scene.description=" + value}}))
        << value.size();
  }
}

TEST(StrangeToml, HarmlessDotsAndBracketsAreTaken) {
  const std::string dots = repeated(".", 1000), brackets = repeated("[{", 1000);
  EXPECT_EQ(refusal_of_text(bar_sample() + "\n# " + dots + brackets), "no error");
  for (const std::string quotes : {"\"", "'", "\"\"\"", "'''"}) {
    const scene::Scene scene =
        parse(bar_sample(), {.set = {"scene.description=" + quotes + dots + brackets + quotes}});
    EXPECT_NE(scene.text.find(dots + brackets), std::string::npos);
  }
}

// toml++ searches its tables for each dotted key: the most that are allowed must not take long.
TEST(StrangeToml, ManyDottedKeysTakeNoLongerThanTheyMay) {
  const std::string text = dotted_lines("a", ".b = 1", 25'000) + dotted_lines("a", ".c = 1", 25'000);
  const std::clock_t begin = std::clock();
  EXPECT_NE(refusal_of_text(text), "no error");
  // A fraction of a second; ten times as many keys would take a hundred times as long. Sanitizers are ten
  // times slower.
  EXPECT_LT((std::clock() - begin) / CLOCKS_PER_SEC, 10);
}

TEST(StrangeToml, DotsOfNumbersAreNotCounted) {
  const std::string numbers = "[" + repeated("[1.5, 2.5],\n", 60'000) + "]\n";
  const std::string refusal =
      refusal_of_text("[x]\na = " + numbers + "b = { c = " + numbers + ", d = 1.0 }\n");
  EXPECT_EQ(refusal.find("dots"), std::string::npos) << refusal;
}

TEST(StrangeToml, LettersMayFollowAFoldedLine) {
  const scene::Scene scene = parse(bar_sample(), {.set = {"scene.description=\"\"\"a \\\n   \u00eb\"\"\""}});
  EXPECT_NE(scene.text.find("a \u00eb"), std::string::npos) << scene.text;
}

}  // namespace
}  // namespace fascicle::tests
