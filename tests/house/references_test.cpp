// References resolve: documents named in code, comments and docs exist, and so do link targets in docs.
#include <array>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

bool ends_a_path(const std::set<std::string>& paths, const std::string& end) {
  if (paths.contains(end)) return true;
  for (const std::string& path : paths)
    if (path.ends_with("/" + end)) return true;
  return false;
}

// Unresolved references and links, as "path:line: reference". `paths` are all files and folders of the
// repository. A document may be named by the end of its path; links are relative to their own folder.
std::vector<std::string> missing_references(const Source& source, const std::set<std::string>& paths) {
  static const std::regex document(R"re([A-Za-z0-9_./-]*[A-Za-z0-9_-]\.(md|rst|pdf|docx|odt)\b)re");
  static const std::regex link(R"re(\]\(([^)#:]+)(#[^)]*)?\))re");
  static const std::regex address(R"re([a-z]+://[^\s)>"]+)re");
  std::vector<std::string> missing;
  const std::vector<std::string> lines = lines_of(source.text);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::string line = std::regex_replace(lines[k], address, "#");
    const auto report = [&](const std::string& reference) {
      missing.push_back(source.path + ":" + std::to_string(k + 1) + ": " + reference);
    };
    for (std::sregex_iterator found(line.begin(), line.end(), document), end; found != end; ++found) {
      std::string name = fs::path(found->str()).lexically_normal().generic_string();
      while (name.starts_with("../")) name.erase(0, 3);
      if (!ends_a_path(paths, name)) report(found->str());
    }
    if (!source.path.ends_with(".md")) continue;
    for (std::sregex_iterator found(line.begin(), line.end(), link), end; found != end; ++found) {
      std::string target =
          (fs::path(source.path).parent_path() / found->str(1)).lexically_normal().generic_string();
      if (target.ends_with("/")) target.pop_back();
      if (!paths.contains(target)) report(found->str(1));
    }
  }
  return missing;
}

TEST(References, LeadToWhatIsThere) {
  const std::vector<Source> files = read_repository(FASCICLE_SOURCE_DIR);
  std::set<std::string> paths;
  for (const Source& file : files)
    for (fs::path path = file.path; !path.empty(); path = path.parent_path())
      paths.insert(path.generic_string());
  ASSERT_TRUE(paths.contains("README.md") && paths.contains("docs/architecture.md") && paths.contains("do"));
  for (const Source& file : files) {
    if (file.path.starts_with("tests/house/")) continue;  // has dead references as controls
    for (const std::string& missing : missing_references(file, paths)) ADD_FAILURE() << missing;
  }
}

// The controls: dead references are found, and valid ones pass.
TEST(References, ThatLeadNowhereAreSeen) {
  const std::set<std::string> paths{"README.md", "docs", "docs/architecture.md", "docs/figures/a.png",
                                    "host/a.cpp"};
  for (const char* line : {"// see design.md", "# method.md, 3.2", "as docs/contact.md has it",
                           "(../notes.rst)", "docs/old/architecture.md", "the paper.pdf"})
    EXPECT_EQ(missing_references({"host/a.cpp", std::string("\n") + line + "\n"}, paths).size(), 1u) << line;
  for (const char* line : {"[a](docs/b.png)", "![a](figures/a.png)", "[a](gone/#there)"})
    EXPECT_EQ(missing_references({"README.md", line}, paths).size(), 1u) << line;
  for (const char* line :
       {"// see docs/architecture.md, Exactness", "architecture.md.", "../docs/architecture.md",
        "https://example.org/method.md", "a.mdd", "design", "x.text"})
    EXPECT_TRUE(missing_references({"host/a.cpp", line}, paths).empty()) << line;
  for (const char* line : {"[a](docs/figures/a.png)", "[a](docs)", "[a](docs/architecture.md#exactness)",
                           "[a](https://example.org/b.png)", "[a](#here)"})
    EXPECT_TRUE(missing_references({"README.md", line}, paths).empty()) << line;
}

}  // namespace
}  // namespace fascicle::tests
