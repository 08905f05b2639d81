// Presets release, asan and tsan are unity builds: they compile several sources of a folder as one, in groups
// that change with every new source. So names local to a source must be unique in its folder, or a new source
// makes others clash.
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

std::string folder_of(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

// The names that a line defines, and for a function its parameter types as far as they are on that line. A
// mere redeclaration, such as `using` of the same type, may be repeated.
struct Defined {
  std::vector<std::string> names;
  std::string parameters = {};  // with '('; empty if not a function
};
Defined defined_on(const std::string& line) {
  static const std::regex type(R"(^(?:struct|class|enum class|enum) (\w+).*\{)"),
      constant(R"(^(?:inline |static )*(?:constexpr|const) [^(=]*?(\w+)(?:\[\w*\])?\s*(?:=|\{).*)"),
      another(R"(,\s*(\w+)(?:\[\w*\])?\s*=)"),
      function(R"(^(?:inline |static |constexpr )*[A-Za-z_][\w:<>,&* ]*[ &*](\w+)\(([^;]*)$)"),
      parameter(R"(\s+\w+(?=[,)]))");
  std::smatch found;
  if (std::regex_search(line, found, type)) return {{found[1]}};
  if (std::regex_search(line, found, constant)) {
    Defined defined{{found[1]}};
    for (std::sregex_iterator more(line.begin(), line.end(), another), end; more != end; ++more)
      defined.names.push_back((*more)[1]);
    return defined;
  }
  if (std::regex_search(line, found, function)) {
    const std::string rest = found[2];
    return {{found[1]}, "(" + std::regex_replace(rest.substr(0, rest.find(" {")), parameter, "")};
  }
  return {};
}

// "folder: name in a.cpp b.cpp" for each name that several sources of a folder define in unnamed namespaces.
// Functions may share a name if their parameters differ.
std::vector<std::string> clashes(const std::vector<Source>& sources) {
  using Users = std::map<std::string, std::set<std::string>>;  // key: parameters
  std::map<std::pair<std::string, std::string>, Users> all;
  for (const Source& source : sources) {
    if (!source.path.ends_with(".cpp")) continue;
    bool is_own = false;
    for (const std::string& line : lines_of(source.text)) {
      if (line == "namespace {") is_own = true;
      if (line == "}  // namespace") is_own = false;
      if (!is_own) continue;
      const Defined defined = defined_on(line);
      for (const std::string& name : defined.names)
        all[{folder_of(source.path), name}][defined.parameters].insert(source.path);
    }
  }
  std::vector<std::string> found;
  for (auto& [name, users] : all) {
    if (const auto other = users.find(""); other != users.end() && users.size() > 1)
      for (auto& [parameters, paths] : users) paths.insert(other->second.begin(), other->second.end());
    for (const auto& [parameters, paths] : users) {
      if (paths.size() < 2) continue;
      std::string text = name.first + ": " + name.second + parameters + " in";
      for (const std::string& path : paths) text += " " + path.substr(name.first.size() + 1);
      found.push_back(text);
    }
  }
  return found;
}

// Tests are exempt: CI compiles them as unity builds, and clashing sources are listed as APART in their
// CMakeLists.txt.
TEST(Unity, SourcesOfAFolderKeepNamesOfTheirOwn) {
  std::vector<Source> sources;
  for (Source& source : read_sources(FASCICLE_SOURCE_DIR))
    if (!source.path.starts_with("tests/") && !source.path.starts_with("bench/"))
      sources.push_back(std::move(source));
  ASSERT_GT(sources.size(), 200U);
  for (const std::string& clash : clashes(sources)) ADD_FAILURE() << clash << ": rename one of them";
}

// The control: clashing names are found, and others are not.
TEST(Unity, AClashIsFound) {
  const std::string first =
      "namespace {\n"
      "constexpr int most = 3;\n"
      "constexpr double one = 1.0, two = 2.0;\n"
      "constexpr int count = 7;\n"
      "struct Face {\n};\n"
      "std::string percent(double share) {\n}\n"
      "double length(const Vector& v) {\n}\n"
      "using Path = std::string;\n"
      "}  // namespace\n"
      "int open(int a) {\n}\n";
  const std::string second =
      "namespace {\n"
      "constexpr double most{4};\n"
      "constexpr int two = 2;\n"
      "int count(double x) {\n}\n"
      "struct Face {\n};\n"
      "std::string percent(double x) {\n}\n"
      "double length(const Edge& e) {\n}\n"
      "using Path = std::string;\n"
      "}  // namespace\n"
      "int open(int b) {\n}\n";
  EXPECT_EQ(clashes({{"host/a/one.cpp", first}, {"host/a/two.cpp", second}}),
            (std::vector<std::string>{
                "host/a: Face in one.cpp two.cpp", "host/a: count(double) in one.cpp two.cpp",
                "host/a: most in one.cpp two.cpp", "host/a: percent(double) in one.cpp two.cpp",
                "host/a: two in one.cpp two.cpp"}));
  EXPECT_TRUE(clashes({{"host/a/one.cpp", first}, {"host/b/two.cpp", second}}).empty());
}

}  // namespace
}  // namespace fascicle::tests
