// What others build against: the exported symbols, and an installed copy used from outside the tree.
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/library/shell.h"

namespace fascicle_tests {
namespace {

TEST(Library, ExportsItsOwnNamesAlone) {
  const Ran ran = run_in_shell(std::string("nm -D --defined-only ") + FASCICLE_LIBRARY);
  ASSERT_EQ(ran.status, 0) << ran.out;
  std::istringstream lines(ran.out);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const std::string name = line.substr(line.rfind(' ') + 1);
    EXPECT_TRUE(name.starts_with("fascicle_")) << line;
  }
  EXPECT_GT(count, 40u);
}

// The library exports exactly the functions of the headers.
TEST(Library, ExportsWhatTheHeadersDeclare) {
  const std::string headers = std::string(FASCICLE_SOURCE_DIR) + "/include/fascicle/";
  const Ran declared = run_in_shell("cat " + headers + "fascicle.h " + headers + "solver.h");
  const Ran exported =
      run_in_shell(std::string("nm -D --defined-only ") + FASCICLE_LIBRARY + " | sed 's/.* //' | sort");
  std::set<std::string> names;
  const std::regex function("FASCICLE_API [^;(]*?(fascicle_[a-z0-9_]+)\\(");
  for (std::sregex_iterator k(declared.out.begin(), declared.out.end(), function), end; k != end; ++k)
    names.insert((*k)[1]);
  std::string sorted;
  for (const std::string& name : names) sorted += name + "\n";
  EXPECT_EQ(sorted, exported.out);
}

TEST(Library, HasASoname) {
  const Ran ran = run_in_shell(std::string("readelf -d ") + FASCICLE_LIBRARY);
  EXPECT_NE(ran.out.find("[libfascicle.so.0]"), std::string::npos) << ran.out;
}

// Every program on the page is in the examples, word for word.
TEST(Library, ThePageShowsTheExamples) {
  const std::string docs = FASCICLE_SOURCE_DIR "/docs/";
  const std::string page = run_in_shell("cat " + docs + "library.md").out;
  const std::string examples = run_in_shell("cat " + docs + "examples/library/*").out;
  std::size_t count = 0;
  for (const char* language : {"```c\n", "```cpp\n", "```cmake\n"})
    for (std::size_t at = page.find(language); at != std::string::npos;
         at = page.find(language, at + 1), ++count) {
      const std::size_t begin = at + std::string(language).size();
      const std::string block = page.substr(begin, page.find("```", begin) - begin);
      EXPECT_NE(examples.find(block), std::string::npos) << block;
    }
  EXPECT_GE(count, 6u);
}

std::string only_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

// The last line of the output that holds a hash.
std::string hash_in(const std::string& text) {
  const std::string mark = "position hash of the last frame: ";
  const std::size_t found = text.find(mark);
  return found == std::string::npos ? "" : only_line(text.substr(found + mark.size()));
}

TEST(Library, InstalledItServesAProgramOutsideTheTree) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "SKIPPED: a program without a sanitizer cannot load a library that has one";
#endif
  const Folder folder;
  const std::string prefix = folder / "prefix", examples = folder / "examples", build = folder / "build";
  Ran ran =
      run_in_shell(std::string(FASCICLE_CMAKE) + " --install " + FASCICLE_BINARY_DIR + " --prefix " + prefix);
  ASSERT_EQ(ran.status, 0) << ran.out;
  ran = run_in_shell("cp -r " FASCICLE_SOURCE_DIR "/docs/examples/library " + examples);
  ASSERT_EQ(ran.status, 0) << ran.out;
  // Moved, so that no file may depend on its old place.
  const std::string moved = folder / "moved";
  std::filesystem::rename(prefix, moved);
  const std::string compilers = std::string(" -DCMAKE_C_COMPILER=") + FASCICLE_C_COMPILER +
                                " -DCMAKE_CXX_COMPILER=" + FASCICLE_CXX_COMPILER;
  ran = run_in_shell(std::string(FASCICLE_CMAKE) + " -S " + examples + " -B " + build +
                     " -DCMAKE_PREFIX_PATH=" + moved + " -DCMAKE_CXX_FLAGS='-Wall -Wextra' " + compilers +
                     " && " + FASCICLE_CMAKE + " --build " + build);
  ASSERT_EQ(ran.status, 0) << ran.out;
  EXPECT_EQ(ran.out.find("warning:"), std::string::npos) << ran.out;
  EXPECT_EQ(run_in_shell("grep -rl -e -Werror -e " FASCICLE_SOURCE_DIR " " + moved +
                         "/lib*/ --include=*.cmake --include=*.pc")
                .out,
            "")
      << "our flags and folders reach users";

  // With pkg-config.
  ran = run_in_shell("export PKG_CONFIG_PATH=$(dirname $(find " + moved + " -name fascicle.pc)); " +
                     FASCICLE_C_COMPILER + " -std=c11 -o " + (folder / "by_pkg_config") + " " + examples +
                     "/bake_character.c $(pkg-config --cflags --libs fascicle) -Wl,-rpath,$(pkg-config "
                     "--variable=libdir fascicle)");
  ASSERT_EQ(ran.status, 0) << ran.out;

  const std::string scene = " bar-layers-i ", end = " scene.end=0.1";
  ran = run_in_shell(std::string(FASCICLE_PROGRAM) + " bake" + scene + "--set" + end + " --device cpu -o " +
                     (folder / "a"));
  const std::string hash = hash_in(ran.out);
  ASSERT_EQ(hash.size(), 16u) << ran.out;
  const std::string quiet = " 2>" + (folder / "errors");
  for (const std::string& program : {build + "/bake_character", folder / "by_pkg_config"}) {
    ran = run_in_shell(program + scene + program + "-out" + end + quiet);
    EXPECT_EQ(ran.status, 0) << program << run_in_shell("cat " + (folder / "errors")).out;
    EXPECT_EQ(only_line(ran.out), hash) << program;
  }
  ran = run_in_shell(build + "/step_frames" + scene + end);
  EXPECT_EQ(ran.status, 0) << ran.out;
  EXPECT_EQ(only_line(ran.out), hash);
  ran = run_in_shell(build + "/solver_alone");
  EXPECT_EQ(ran.status, 0) << ran.out;

  // The installed program works too: it and the library find the mesher in the prefix.
  ran = run_in_shell("PATH=/usr/bin:/bin " + moved +
                     "/bin/fascicle bake arm --end 0.05 --no-cache --device cpu -o " + (folder / "b"));
  ASSERT_EQ(ran.status, 0) << ran.out;
  const std::string of_arm = hash_in(ran.out);
  ran = run_in_shell("FASCICLE_CACHE_DIR=" + (folder / "cache") + " PATH=/usr/bin:/bin " + build +
                     "/bake_character arm " + (folder / "c") + " scene.end=0.05" + quiet);
  EXPECT_EQ(only_line(ran.out), of_arm) << run_in_shell("cat " + (folder / "errors")).out;
}

}  // namespace
}  // namespace fascicle_tests
