// Eigen declares some functions in one header and defines them in another. A source that includes only the
// first compiles, and links as long as another source of its unit, or of the program, has the definition. So
// every source must include the header that defines what it calls, itself or through another of ours.
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
  const char* name;
  std::regex uses;
  std::vector<std::string> includes;  // other headers of this table that it includes
};

const std::vector<Header>& eigen_headers() {
  static const std::vector<Header> table{
      {"Eigen/Geometry",
       std::regex(R"(\.cross\(|\.unitOrthogonal\(|\.h(omogeneous|normalized)\()"
                  R"(|Eigen::(AngleAxis|Quaternion|AlignedBox|Affine|Isometry))"),
       {"Eigen/LU", "Eigen/SVD"}},
      {"Eigen/LU",
       std::regex(R"(\.determinant\(\)|\.inverse\(\)|\.(partial|full)PivLu\(|(Partial|Full)PivLU<)"),
       {}},
      {"Eigen/Cholesky", std::regex(R"(\.ldlt\(|\.llt\(|\bL(L|DL)T<)"), {}},
      {"Eigen/QR", std::regex(R"(\.(colPivH|fullPivH|h)ouseholderQr\(|HouseholderQR<)"), {"Eigen/Cholesky"}},
      {"Eigen/SVD", std::regex(R"(\.(jacobi|bdc)Svd\(|(Jacobi|BDC)SVD<)"), {"Eigen/QR"}},
      {"Eigen/Eigenvalues",
       std::regex(R"((Self|Generalized|Complex)\w*EigenSolver<|\.eigenvalues\()"),
       {"Eigen/Geometry"}},
      {"Eigen/Dense", std::regex("^$"), {"Eigen/Eigenvalues"}},
  };
  return table;
}

using Texts = std::map<std::string, std::string>;  // by path, without comments

// Adds the header, those it includes, and of our own also theirs.
void add_closure(const Texts& texts, const std::string& path, std::set<std::string>& found) {
  static const std::regex include(R"(#\s*include\s*[<"]([^>"]+)[>"])");
  if (!found.insert(path).second) return;
  for (const Header& header : eigen_headers())
    if (header.name == path)
      for (const std::string& other : header.includes) add_closure(texts, other, found);
  const auto text = texts.find(path);
  if (text == texts.end()) return;
  for (std::sregex_iterator at(text->second.begin(), text->second.end(), include), end; at != end; ++at)
    add_closure(texts, (*at)[1], found);
}

// "path: Eigen/Header" for each header that a source lacks.
std::vector<std::string> lacking(const Texts& texts) {
  std::vector<std::string> found;
  for (const auto& [path, text] : texts) {
    std::set<std::string> included;
    add_closure(texts, path, included);
    for (const Header& header : eigen_headers())
      if (std::regex_search(text, header.uses) && !included.contains(header.name))
        found.push_back(path + ": " + header.name);
  }
  return found;
}

TEST(EigenHeaders, AreIncludedWhereTheirFunctionsAreCalled) {
  Texts texts;
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR))
    texts[source.path] = without_comments(source.text);
  ASSERT_GT(texts.size(), 500u);
  EXPECT_EQ(lacking(texts), std::vector<std::string>{});
}

TEST(EigenHeaders, AMissingOneIsSeen) {
  Texts texts{{"own.h", "#include <Eigen/Geometry>\n"}, {"other.h", "#include <Eigen/Core>\n"}};
  texts["good.cpp"] = "#include \"own.h\"\nauto f() { return a.cross(b) * m.inverse(); }\n";
  EXPECT_EQ(lacking(texts), std::vector<std::string>{});
  texts["bad.cpp"] = "#include \"other.h\"\nauto f() { return a.cross(b); }\n";
  texts["worse.cpp"] = "#include <Eigen/QR>\nEigen::JacobiSVD<Matrix> of;\n";
  EXPECT_EQ(lacking(texts), (std::vector<std::string>{"bad.cpp: Eigen/Geometry", "worse.cpp: Eigen/SVD"}));
}

}  // namespace
}  // namespace fascicle::tests
