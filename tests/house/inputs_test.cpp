// All input from outside has one entry point: files are read by host/base/file.h, TOML is parsed by
// host/scene/parse_toml.h.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

// Files of host whose code contains `word`, except those with an allowed prefix.
std::vector<std::string> places_of(const std::string& word, const std::vector<std::string>& allowed) {
  std::vector<std::string> places;
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR)) {
    bool is_allowed = !source.path.starts_with("host/");
    for (const std::string& path : allowed) is_allowed = is_allowed || source.path.starts_with(path);
    if (!is_allowed && without_comments(source.text).find(word) != std::string::npos)
      places.push_back(source.path);
  }
  return places;
}

TEST(Inputs, TomlIsParsedInOnePlace) {
  EXPECT_EQ(places_of("toml::parse(", {"host/scene/parse_toml.cpp"}), std::vector<std::string>{});
  EXPECT_NE(places_of("toml::parse(", {}), std::vector<std::string>{});
}

TEST(Inputs, FilesAreReadInOnePlace) {
  // Allowed: separate programs, which use nothing of ours; system information in /proc; and files that a
  // helper of ours wrote into a temporary folder of ours.
  const std::vector<std::string> allowed{
      "host/mesher/",        "host/convert/",       "host/pipeline/device_choice.cpp",
      "host/cli/memory.cpp", "host/build/wrap.cpp", "host/cli/bench_measure.cpp"};
  EXPECT_EQ(places_of("std::ifstream", allowed), std::vector<std::string>{});
  // host/bake/folder.cpp opens folders to lock them.
  for (const char* word : {"std::fstream", "fopen(", "::open("})
    EXPECT_EQ(places_of(word, {"host/base/", "host/mesher/", "host/convert/", "host/bake/folder.cpp"}),
              std::vector<std::string>{})
        << word;
  EXPECT_NE(places_of("std::ifstream", {}), std::vector<std::string>{});
}

// A program that calls the library may have set a locale with a decimal comma.
TEST(Inputs, NumbersAreReadWhateverTheLocale) {
  for (const char* word : {"stod(", "stof(", "strtod(", "strtof(", "atof("})
    EXPECT_EQ(places_of(word, {}), std::vector<std::string>{}) << word;
  EXPECT_NE(places_of("from_chars(", {}), std::vector<std::string>{});
}

}  // namespace
}  // namespace fascicle::tests
