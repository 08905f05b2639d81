// The numbers in docs/paper.md match this program's measurements. Checks figures 2, 3, 6 and 7, which take
// seconds, to the last digit, as every machine bakes the same bits.
#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

std::string complaints_about(const fs::path& docs, const fs::path& messages) {
  const std::string command = "python3 -B '" FASCICLE_SOURCE_DIR "/docs/paper.py' --check '" FASCICLE_PROGRAM
                              "' --docs '" +
                              docs.string() + "' > /dev/null 2> '" + messages.string() + "'";
  const int status = std::system(command.c_str());
  const std::string text = read_text(messages);
  EXPECT_EQ(status == 0, text.empty()) << text;
  return text;
}

TEST(PaperNumbers, AreWhatTheProgramMeasures) {
  const TemporaryFolder folder;
  EXPECT_EQ(complaints_about(FASCICLE_SOURCE_DIR "/docs", folder / "messages"), "");

  // The control: a page and numbers that agree with each other but not with the program.
  const fs::path docs = folder.path() / "docs";
  fs::create_directories(docs);
  fs::copy(FASCICLE_SOURCE_DIR "/docs/figures", docs / "figures");
  std::string numbers = read_text(FASCICLE_SOURCE_DIR "/docs/paper.json");
  const std::string key = "\"across\": 0.";
  const std::size_t at = numbers.find(key);
  ASSERT_NE(at, std::string::npos);
  numbers.insert(at + key.size(), "9");
  write_text(docs / "paper.json", numbers);
  write_text(docs / "paper.md", "");
  EXPECT_NE(complaints_about(docs, folder / "messages").find("figure 6 measures"), std::string::npos);
}

}  // namespace
}  // namespace fascicle::tests
