// The documentation and the program agree: every command in README and docs is run, or is of a kind listed
// here with the reason why not; every scene file is parsed; every option mentioned exists.
//
// The commands of a page run from top to bottom in a separate folder. It contains man.glb, a character, and
// blob.obj, a closed surface. A ```toml block whose first line is "# NAME.toml" is written there under that
// name.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

namespace fs = std::filesystem;

const fs::path readme_root(FASCICLE_SOURCE_DIR);

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Fenced {
  std::string language;
  std::vector<std::string> lines;
};

std::vector<Fenced> fenced(const std::string& text) {
  std::istringstream page(text);
  std::vector<Fenced> blocks;
  bool inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      inside = !inside;
      if (inside) blocks.push_back({line.substr(3), {}});
    } else if (inside) {
      blocks.back().lines.push_back(line);
    }
  }
  return blocks;
}

// README, every page below docs, and those next to the code, by path from the root.
std::vector<std::string> pages() {
  std::vector<std::string> found{"README.md", "CONTRIBUTING.md", "bench/README.md"};
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(readme_root / "docs"))
    if (entry.path().extension() == ".md")
      found.push_back(entry.path().lexically_relative(readme_root).generic_string());
  std::ranges::sort(found);
  return found;
}

enum class Kind { run, script, other, unknown };

// Commands that a test cannot run, by their beginning, with the reason.
struct NotRun {
  std::string_view beginning, reason;
};
constexpr std::array not_run{
    NotRun{"blender ", "opens a window; tests/readers runs Blender without one"},
    NotRun{"usdcat ", "USD's own program, which Debian 12 does not have"},
    NotRun{"cmake ", "configures another build; ./do does the same"},
    NotRun{"fascicle-convert ",
           "its input would be an FBX file, of which the project has none; see test_convert"},
};

Kind kind_of(const std::string& command) {
  if (command.starts_with("fascicle ")) return Kind::run;
  // These build or take minutes, so only the existence of their subcommand is checked.
  if (command.starts_with("./do ")) return Kind::script;
  for (const NotRun& kind : not_run)
    if (command.starts_with(kind.beginning)) return Kind::other;
  return Kind::unknown;
}

// The line without its trailing comment.
std::string command_of(const std::string& line) {
  const std::size_t comment = line.find(" #");
  std::string command = line.substr(0, comment);
  while (command.ends_with(' ')) command.pop_back();
  return command;
}

bool script_knows(const std::string& script, const std::string& command) {
  std::istringstream words(command.substr(5));
  std::string subcommand;
  words >> subcommand;
  return std::regex_search(script, std::regex("\n  ([a-z]+ \\| )*" + subcommand + "( \\| [a-z]+)*\\)"));
}

// The output and exit code of a `fascicle` command run in a folder.
struct Ended {
  int status = 0;
  std::string output;
};
Ended run_in(const fs::path& folder, const std::string& command) {
  const fs::path log = folder / "log";
  const std::string line = "cd '" + folder.string() + "' && export FASCICLE_CACHE_DIR='" +
                           (folder / "cache").string() + "' PATH='" + FASCICLE_BINARY_DIR +
                           "':\"$PATH\" && { " + command + "; } > '" + log.string() + "' 2>&1";
  const int status = std::system(line.c_str());
  return {status, text_of(log)};
}

// A cube of 0.2 m.
constexpr const char* cube_obj =
    "v 0 0 0\nv .2 0 0\nv .2 .2 0\nv 0 .2 0\nv 0 0 .2\nv .2 0 .2\nv .2 .2 .2\nv 0 .2 .2\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

class Pages : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    std::string name = GetParam();
    std::ranges::replace(name, '/', '-');
    folder_ = fs::temp_directory_path() / ("fascicle-pages-" + std::to_string(getpid()) + "-" + name);
    fs::create_directories(folder_ / "out");
    text_ = text_of(readme_root / GetParam());
  }
  void TearDown() override { fs::remove_all(folder_); }

  void put_files() const {
    std::ofstream(folder_ / "blob.obj") << cube_obj;
    const Ended made = run_in(folder_,
                              "fascicle bake arm -o made --end 0.1 && "
                              "sed 's/\"curl (baked)\"/\"curl\"        /' made/character.glb > man.glb");
    ASSERT_EQ(made.status, 0) << made.output;
    for (const Fenced& block : fenced(text_)) {
      if (block.language != "toml" || block.lines.empty()) continue;
      const std::string& first = block.lines.front();
      if (!first.starts_with("# ") || !first.ends_with(".toml")) continue;
      std::ofstream file(folder_ / first.substr(2));
      for (const std::string& line : block.lines) file << line << "\n";
    }
  }

  fs::path folder_;
  std::string text_;
};

TEST_P(Pages, CommandsRun) {
  const std::string script = text_of(readme_root / "do");
  bool has_files = false;
  for (const Fenced& block : fenced(text_)) {
    if (block.language != "sh") continue;
    for (const std::string& line : block.lines) {
      const std::string command = command_of(line);
      switch (kind_of(command)) {
        case Kind::unknown:
          ADD_FAILURE() << GetParam() << ": no test runs '" << line << "', and `not_run` gives no reason";
          break;
        case Kind::other:
          break;
        case Kind::script:
          EXPECT_TRUE(script_knows(script, command)) << line;
          break;
        case Kind::run:
          if (!has_files) put_files();
          has_files = true;
          if (command.find("vulkan") != std::string::npos && !std::getenv("FASCICLE_REQUIRE_VULKAN") &&
              run_in(folder_, "fascicle devices | grep -q vulkan:").status != 0) {
            ADD_FAILURE() << "no Vulkan device: '" << line << "' was NOT run";
            break;
          }
          const Ended ended = run_in(folder_, command);
          EXPECT_EQ(ended.status, 0) << GetParam() << ": " << line << "\n" << ended.output;
          break;
      }
    }
  }
}

// A TOML block is a list of jobs, a whole scene, or a named file.
TEST_P(Pages, SceneFilesAreSome) {
  bool has_files = false;
  for (const Fenced& block : fenced(text_)) {
    if (block.language != "toml") continue;
    std::string scene;
    bool is_jobs = false, has_file = false;
    for (const std::string& line : block.lines) {
      is_jobs = is_jobs || line.starts_with("[job.");
      has_file = has_file || line.starts_with("file = ");
      scene += line + "\n";
    }
    if (is_jobs) continue;  // read by the page's own command
    if (has_file && !has_files) {
      put_files();
      has_files = true;
    }
    std::ofstream(folder_ / "page.toml") << scene;
    EXPECT_NO_THROW(scene::load_scene((folder_ / "page.toml").string())) << GetParam() << "\n" << scene;
  }
}

INSTANTIATE_TEST_SUITE_P(Docs, Pages, testing::ValuesIn(pages()), [](const auto& page) {
  std::string name = page.param;
  std::ranges::replace_if(
      name, [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
});

// The program's subcommands and options, from its own help.
std::set<std::string> words_of_help(const fs::path& folder) {
  std::set<std::string> words;
  static const std::regex option(R"(--[a-z][a-z-]*)");
  static const std::regex subcommand(R"(\n  ([a-z]+)  )");
  const std::string help = run_in(folder, "fascicle --help").output;
  std::string all = help;
  for (std::sregex_iterator found(help.begin(), help.end(), subcommand), end; found != end; ++found) {
    words.insert(found->str(1));
    const std::string more = run_in(folder, "fascicle " + found->str(1) + " --help").output;
    all += more;
    for (std::sregex_iterator own(more.begin(), more.end(), subcommand); own != end; ++own)
      all += run_in(folder, "fascicle " + found->str(1) + " " + own->str(1) + " --help").output;
  }
  for (std::sregex_iterator found(all.begin(), all.end(), option), end; found != end; ++found)
    words.insert(found->str());
  return words;
}

// Subcommands after `fascicle`, and options, in a page's `code` that are not among these words.
std::vector<std::string> unknown_words(const std::string& page, const std::set<std::string>& words) {
  static const std::regex code(R"(`([^`\n]+)`)");
  static const std::regex subcommand(R"(^fascicle ([a-z]+))");
  static const std::regex option(R"((^| )(--[a-z][a-z-]*))");
  std::vector<std::string> unknown;
  for (std::sregex_iterator found(page.begin(), page.end(), code), end; found != end; ++found) {
    const std::string text = found->str(1);
    if (text.starts_with("cmake ") || text.starts_with("./do ") || text.starts_with("apt")) continue;
    std::smatch word;
    if (std::regex_search(text, word, subcommand) && !words.contains(word.str(1))) unknown.push_back(text);
    for (std::sregex_iterator name(text.begin(), text.end(), option); name != end; ++name)
      if (!words.contains(name->str(2))) unknown.push_back(text);
  }
  return unknown;
}

TEST(Readme, OptionsThatPagesNameExist) {
  const fs::path folder = fs::temp_directory_path() / ("fascicle-options-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::set<std::string> words = words_of_help(folder);
  fs::remove_all(folder);
  ASSERT_TRUE(words.contains("bake") && words.contains("--softness")) << "the help could not be parsed";
  for (const std::string& page : pages()) {
    if (page == "bench/README.md") continue;  // also names options of Google Benchmark and of a script
    for (const std::string& text : unknown_words(text_of(readme_root / page), words))
      ADD_FAILURE() << page << ": `" << text << "`";
  }
}

TEST(Readme, IsShort) {
  const std::string text = text_of(readme_root / "README.md");
  EXPECT_LE(std::ranges::count(text, '\n'), 150);
  std::size_t commands = 0, scripts = 0;
  for (const Fenced& block : fenced(text))
    for (const std::string& line : block.lines) {
      commands += kind_of(line) == Kind::run;
      scripts += kind_of(line) == Kind::script;
    }
  EXPECT_GE(commands, 8u);
  EXPECT_EQ(scripts, 2u) << "the first screen should show two commands";
}

// The controls: a command of unknown kind, an unknown option and an unknown subcommand are detected.
TEST(Readme, WhatIsWrongIsSeen) {
  EXPECT_EQ(kind_of("rm -rf out"), Kind::unknown);
  EXPECT_EQ(kind_of("fascicle bake arm"), Kind::run);
  EXPECT_EQ(command_of("fascicle devices   # all of them"), "fascicle devices");
  EXPECT_FALSE(script_knows("\n  bake)\n", "./do fly"));
  EXPECT_TRUE(script_knows("\n  bench | kernels)\n", "./do kernels --x"));
  const std::set<std::string> words{"bake", "--end"};
  EXPECT_TRUE(unknown_words("see `fascicle bake X --end 1` and `--end`", words).empty());
  EXPECT_EQ(unknown_words("`fascicle fly`, `fascicle bake --ende`, `--star`", words).size(), 3u);
}

}  // namespace

}  // namespace fascicle::tests
