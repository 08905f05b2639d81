// The docs are consistent: links and anchors resolve, every page is reachable from README, paths named in
// pages exist, and lines of pages and shaders have at most 120 columns.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_columns = 120;

// The lines of a page, with fenced blocks blanked.
std::vector<std::string> prose_of(const std::string& text) {
  std::vector<std::string> lines = lines_of(text);
  bool inside = false;
  for (std::string& line : lines) {
    const bool is_fence = line.starts_with("```");
    if (inside || is_fence) line.clear();
    inside = inside != is_fence;
  }
  return lines;
}

// The anchor of a heading, as GitHub and mkdocs generate it.
std::string anchor_of(std::string_view heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '-' || c == '_') anchor += static_cast<char>(std::tolower(byte));
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

std::set<std::string> anchors_of(const std::string& text) {
  std::set<std::string> anchors;
  for (const std::string& line : prose_of(text)) {
    const std::size_t level = line.find_first_not_of('#');
    if (level == std::string::npos || level == 0 || line[level] != ' ') continue;
    anchors.insert(anchor_of(std::string_view(line).substr(level + 1)));
  }
  return anchors;
}

struct Link {
  std::size_t line = 0;
  std::string target, anchor;  // target relative to the root; an empty anchor is the whole page
};

// Links and pictures of a page with targets inside the repository.
std::vector<Link> links_of(const Source& page) {
  static const std::regex link(R"re(\]\(([^)#\s]*)(#([^)\s]*))?\))re");
  std::vector<Link> links;
  const std::vector<std::string> lines = prose_of(page.text);
  for (std::size_t k = 0; k < lines.size(); ++k)
    for (std::sregex_iterator found(lines[k].begin(), lines[k].end(), link), end; found != end; ++found) {
      const std::string to = found->str(1);
      if (to.find("://") != std::string::npos) continue;
      const fs::path target = to.empty() ? fs::path(page.path) : fs::path(page.path).parent_path() / to;
      links.push_back({k + 1, target.lexically_normal().generic_string(), found->str(3)});
    }
  return links;
}

// Dead links, as "path:line: target#anchor".
std::vector<std::string> dead_links(const std::vector<Source>& pages, const std::set<std::string>& paths) {
  std::map<std::string, std::set<std::string>> anchors;
  for (const Source& page : pages) anchors[page.path] = anchors_of(page.text);
  std::vector<std::string> dead;
  for (const Source& page : pages)
    for (const Link& link : links_of(page)) {
      const bool has_anchor = link.anchor.empty() ||
                              (anchors.contains(link.target) && anchors[link.target].contains(link.anchor));
      if (!paths.contains(link.target) || !has_anchor)
        dead.push_back(page.path + ":" + std::to_string(link.line) + ": " + link.target + "#" + link.anchor);
    }
  return dead;
}

// Pages that cannot be reached from README.
std::vector<std::string> unreached(const std::vector<Source>& pages) {
  std::set<std::string> reached{"README.md"};
  for (bool grew = true; grew;) {
    const std::size_t before = reached.size();
    for (const Source& page : pages)
      if (reached.contains(page.path))
        for (const Link& link : links_of(page)) reached.insert(link.target);
    grew = reached.size() > before;
  }
  std::vector<std::string> lost;
  for (const Source& page : pages)
    if (!reached.contains(page.path)) lost.push_back(page.path);
  return lost;
}

// Paths in `code` that begin with a room but do not exist. Names with capitals or wildcards are patterns:
// `shaders/NAME.comp`, `bench/results/*`. Built or baked files are not in rooms.
std::vector<std::string> missing_paths(const Source& page, const std::set<std::string>& paths) {
  static const std::regex path(
      R"re(`((host|gpu|cpu_reference|shaders|docs|tests|bench|scenes|include|python)/[a-z0-9_./-]+)`)re");
  std::vector<std::string> missing;
  const std::vector<std::string> lines = prose_of(page.text);
  for (std::size_t k = 0; k < lines.size(); ++k)
    for (std::sregex_iterator found(lines[k].begin(), lines[k].end(), path), end; found != end; ++found) {
      std::string name = found->str(1);
      while (name.ends_with('/')) name.pop_back();
      // The stem can stand for a header and its source.
      if (paths.contains(name) || paths.contains(name + ".h") || paths.contains(name + ".cpp")) continue;
      missing.push_back(page.path + ":" + std::to_string(k + 1) + ": " + name);
    }
  return missing;
}

std::size_t columns_of(const std::string& line) {
  return static_cast<std::size_t>(
      std::ranges::count_if(line, [](unsigned char c) { return (c & 0xC0U) != 0x80U; }));
}

// Lines over 120 columns. Table rows and URLs cannot be wrapped.
std::vector<std::string> wide_lines(const Source& source) {
  std::vector<std::string> wide;
  const bool is_page = source.path.ends_with(".md");
  const std::vector<std::string> lines = lines_of(source.text);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (columns_of(lines[k]) <= most_columns) continue;
    if (is_page && (lines[k].starts_with("|") || lines[k].find("://") != std::string::npos)) continue;
    wide.push_back(source.path + ":" + std::to_string(k + 1) + ": " + std::to_string(columns_of(lines[k])));
  }
  return wide;
}

struct Tree {
  std::vector<Source> files, pages;
  std::set<std::string> paths;  // files and folders
};

Tree read_tree() {
  Tree tree;
  tree.files = read_repository(FASCICLE_SOURCE_DIR);
  for (const Source& file : tree.files) {
    if (file.path.ends_with(".md")) tree.pages.push_back(file);
    for (fs::path path = file.path; !path.empty(); path = path.parent_path())
      tree.paths.insert(path.generic_string());
  }
  return tree;
}

TEST(Docs, LinksAndAnchorsLeadSomewhere) {
  const Tree tree = read_tree();
  ASSERT_GE(tree.pages.size(), 10u);
  for (const std::string& link : dead_links(tree.pages, tree.paths)) ADD_FAILURE() << link;
}

TEST(Docs, EveryPageIsReachedFromReadme) {
  for (const std::string& page : unreached(read_tree().pages))
    ADD_FAILURE() << page << " is linked by no page";
}

TEST(Docs, PathsThatPagesNameAreThere) {
  const Tree tree = read_tree();
  for (const Source& page : tree.pages)
    if (page.path != "CHANGELOG.md")  // describes the past
      for (const std::string& path : missing_paths(page, tree.paths)) ADD_FAILURE() << path;
}

// clang-format keeps .h and .cpp to their width, and touches none of these.
TEST(Docs, LinesKeepTo120Columns) {
  constexpr std::array<std::string_view, 4> endings{".md", ".inc", ".comp", ".glsl"};
  std::size_t seen = 0;
  for (const Source& file : read_tree().files)
    if (std::ranges::any_of(endings, [&](std::string_view ending) { return file.path.ends_with(ending); })) {
      ++seen;
      for (const std::string& line : wide_lines(file)) ADD_FAILURE() << line;
    }
  EXPECT_GE(seen, 30u);
}

TEST(Docs, TheSiteHoldsEveryPage) {
  const Tree tree = read_tree();
  const auto config = std::ranges::find(tree.files, std::string("mkdocs.yml"), &Source::path);
  ASSERT_NE(config, tree.files.end());
  for (const Source& page : tree.pages) {
    if (page.path.starts_with("tests/")) continue;
    EXPECT_NE(config->text.find(" " + page.path + "\n"), std::string::npos)
        << page.path << " is not in the menu of mkdocs.yml";
  }
}

// The controls: each planted fault is found, and the same text without it passes.
TEST(Docs, PlantedFaultsAreSeen) {
  const std::set<std::string> paths{"README.md", "docs", "docs/a.md", "docs/b.md", "host/formats/glb.h"};
  const Source readme{"README.md", "[a](docs/a.md#two-words) and [here](#top)\n# Top\n"};
  const Source a{"docs/a.md", "## Two words\n```sh\n# No heading\n[x](gone.md)\n```\n[up](../README.md)\n"};
  EXPECT_TRUE(dead_links({readme, a}, paths).empty());
  EXPECT_EQ(dead_links({readme, {"docs/a.md", "## Three words\n"}}, paths).size(), 1u);
  EXPECT_EQ(dead_links({readme, a, {"docs/b.md", "[c](c.md) [d](a.md#no-heading)\n"}}, paths).size(), 2u);

  EXPECT_TRUE(unreached({readme, a}).empty());
  EXPECT_EQ(unreached({readme, a, {"docs/b.md", "[b](b.md)"}}), std::vector<std::string>{"docs/b.md"});

  EXPECT_TRUE(
      missing_paths({"README.md", "`host/formats/glb.h`, `host/formats/glb`, `shaders/NAME.comp`"}, paths)
          .empty());
  EXPECT_EQ(missing_paths({"README.md", "`host/formats/gbl.h` is gone"}, paths).size(), 1u);

  const std::string wide(121, 'x');
  EXPECT_EQ(wide_lines({"a.md", wide + "\n"}).size(), 1u);
  EXPECT_EQ(wide_lines({"a.inc", "| " + wide + "\n"}).size(), 1u);
  EXPECT_TRUE(wide_lines({"a.md", "| " + wide + "\nhttps://" + wide + "\n" + wide.substr(1) + "\n"}).empty());
  EXPECT_EQ(anchor_of("Same bits: what, and what not"), "same-bits-what-and-what-not");
}

}  // namespace
}  // namespace fascicle::tests
