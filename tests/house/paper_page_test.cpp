// docs/paper.md is what `./do paper` generates from its numbers, and its pictures exist. tests/cli checks
// that the program measures those numbers.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

const fs::path repository(FASCICLE_SOURCE_DIR);

std::string text_in(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// A copy of the page, its numbers and pictures, and what the generator reports about it.
class PaperPage : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("fascicle-paper-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    for (const char* name : {"paper.md", "paper.json"})
      fs::copy_file(repository / "docs" / name, folder_ / name);
    fs::copy(repository / "docs/figures", folder_ / "figures");
  }
  void TearDown() override { fs::remove_all(folder_); }

  // The first complaint; empty if there is none.
  std::string complaint() const {
    const std::string command = "python3 -B '" + (repository / "docs/paper.py").string() +
                                "' --check --docs '" + folder_.string() + "' 2> '" +
                                (folder_ / "wrong").string() + "'";
    const int status = std::system(command.c_str());
    const std::string wrong = text_in(folder_ / "wrong");
    EXPECT_EQ(status == 0, wrong.empty()) << wrong;
    return wrong;
  }

  void change(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = text_in(folder_ / name);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(folder_ / name) << text.replace(at, from.size(), to);
  }

  fs::path folder_;
};

TEST_F(PaperPage, IsWhatItsNumbersGive) {
  EXPECT_EQ(complaint(), "");
}

TEST_F(PaperPage, IsMadeByACommand) {
  const std::string script = text_in(repository / "do");
  EXPECT_NE(script.find("\n#   ./do paper "), std::string::npos) << "./do help does not list it";
  EXPECT_NE(script.find("\n  paper)"), std::string::npos);
}

TEST_F(PaperPage, ShowsEveryFigureAndTableItPromises) {
  const std::string page = text_in(folder_ / "paper.md");
  for (const char* heading : {"## Figure 2:", "## Figure 3:", "## Figure 6:", "## Figure 7:", "## Figure 8:",
                              "## Figure 9:", "## Figure 10:", "## Table 1:", "## Table 2:"})
    EXPECT_NE(page.find(heading), std::string::npos) << heading;
}

// The controls: each of these changes is detected.
TEST_F(PaperPage, SeesAChangedPage) {
  change("paper.md", "It holds.", "It holds!");
  EXPECT_NE(complaint().find("paper.md is not what paper.json gives"), std::string::npos);
}
TEST_F(PaperPage, SeesAChangedNumber) {
  change("paper.json", "\"across\": 0.", "\"across\": 1.");
  EXPECT_NE(complaint().find("paper.md is not what paper.json gives"), std::string::npos);
}
TEST_F(PaperPage, SeesAMissingPicture) {
  fs::remove(folder_ / "figures/figure-7.svg");
  EXPECT_NE(complaint().find("figures/figure-7.svg"), std::string::npos);
}

}  // namespace
}  // namespace fascicle::tests
