// Eigen declares some functions in one header and defines them in another. A source that includes only the
// first compiles, and links as long as another source of its unit, or of the program, has the definition. So
// every source must include the header that defines what it calls, itself or through another of ours.
#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

struct Header {
  std::string name;
  std::vector<std::string> words;     // what it defines, as it is called
  std::vector<std::string> includes;  // other headers of this table that it includes
};

const std::vector<Header>& eigen_headers() {
  static const std::vector<Header> table{
      {"Eigen/Geometry",
       {".cross(", ".unitOrthogonal(", ".homogeneous(", ".hnormalized(", "Eigen::AngleAxis",
        "Eigen::Quaternion", "Eigen::AlignedBox", "Eigen::Affine", "Eigen::Isometry"},
       {"Eigen/LU", "Eigen/SVD"}},
      {"Eigen/LU", {".determinant()", ".inverse()", ".partialPivLu(", ".fullPivLu(", "PivLU<"}, {}},
      {"Eigen/Cholesky", {".ldlt(", ".llt(", "::LLT<", "::LDLT<"}, {}},
      {"Eigen/QR", {"ouseholderQr(", "HouseholderQR<"}, {"Eigen/Cholesky"}},
      {"Eigen/SVD", {".jacobiSvd(", ".bdcSvd(", "JacobiSVD<", "BDCSVD<"}, {"Eigen/QR"}},
      {"Eigen/Eigenvalues", {"EigenSolver<", ".eigenvalues("}, {"Eigen/Geometry"}},
      {"Eigen/Dense", {}, {"Eigen/Eigenvalues"}},
  };
  return table;
}

struct File {
  std::string text;  // without comments
  std::vector<std::string> includes;
};
using Files = std::map<std::string, File>;  // by path

File file_of(const std::string& source) {
  static const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  File file{without_comments(source), {}};
  for (const std::string& line : lines_of(file.text))
    if (std::smatch found; line.find('#') != std::string::npos && std::regex_search(line, found, include))
      file.includes.push_back(found[1]);
  return file;
}

// Adds the header, those it includes, and those that they include.
void add_closure(const Files& files, const std::string& path, std::set<std::string>& found) {
  if (!found.insert(path).second) return;
  for (const Header& header : eigen_headers())
    if (header.name == path)
      for (const std::string& other : header.includes) add_closure(files, other, found);
  if (const auto file = files.find(path); file != files.end())
    for (const std::string& other : file->second.includes) add_closure(files, other, found);
}

// "path: Eigen/Header" for each header that a source lacks.
std::vector<std::string> lacking(const Files& files) {
  std::vector<std::string> found;
  for (const auto& [path, file] : files) {
    std::set<std::string> included;
    add_closure(files, path, included);
    const auto calls = [&text = file.text](const std::string& word) {
      return text.find(word) != std::string::npos;
    };
    for (const Header& header : eigen_headers())
      if (std::ranges::any_of(header.words, calls) && !included.contains(header.name))
        found.push_back(path + ": " + header.name);
  }
  return found;
}

TEST(EigenHeaders, AreIncludedWhereTheirFunctionsAreCalled) {
  Files files;
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR)) {
    // This file has their names as text.
    if (!source.path.ends_with("eigen_headers_test.cpp")) files[source.path] = file_of(source.text);
  }
  ASSERT_GT(files.size(), 500u);
  EXPECT_EQ(lacking(files), std::vector<std::string>{});
}

TEST(EigenHeaders, AMissingOneIsSeen) {
  Files files{{"own.h", file_of("#include <Eigen/Geometry>\n")},
              {"other.h", file_of("#include <Eigen/Core>\n")}};
  files["good.cpp"] = file_of("#include \"own.h\"\nauto f() { return a.cross(b) * m.inverse(); }\n");
  EXPECT_EQ(lacking(files), std::vector<std::string>{});
  files["bad.cpp"] = file_of("#include \"other.h\"\nauto f() { return a.cross(b); }\n");
  files["worse.cpp"] = file_of("#include <Eigen/QR>\nEigen::JacobiSVD<Matrix> of;\n");
  EXPECT_EQ(lacking(files), (std::vector<std::string>{"bad.cpp: Eigen/Geometry", "worse.cpp: Eigen/SVD"}));
}

}  // namespace
}  // namespace fascicle::tests
