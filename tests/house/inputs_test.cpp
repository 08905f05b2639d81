// One door for what comes from outside: files are read by host/base/file.h, TOML is parsed by
// host/scene/parse_toml.h.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

// Where `word` stands in the code of host, but in these files and below these folders.
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
  // Programs of their own, which see nothing of ours; what the system says of itself in /proc; and what a
  // helper of ours wrote into a temporary folder of ours.
  const std::vector<std::string> allowed{"host/mesher/",
                                         "host/convert/",
                                         "host/pipeline/device_choice.cpp",
                                         "host/cli/memory.cpp",
                                         "host/build/wrap.cpp",
                                         "host/cli/batch_status.cpp",
                                         "host/cli/bench_measure.cpp"};
  EXPECT_EQ(places_of("std::ifstream", allowed), std::vector<std::string>{});
  // Folders are opened for their locks.
  for (const char* word : {"std::fstream", "fopen(", "::open("})
    EXPECT_EQ(places_of(word, {"host/base/", "host/mesher/", "host/convert/", "host/bake/folder.cpp"}),
              std::vector<std::string>{})
        << word;
  EXPECT_NE(places_of("std::ifstream", {}), std::vector<std::string>{});
}

}  // namespace
}  // namespace fascicle::tests
