// The manual page and the completions contain what the program's --help does, and man and the shells accept
// them.
#include <cstdlib>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

std::string manual(const std::string& kind) {
  const Outcome outcome = fascicle({"manual", kind});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.out;
}

std::set<std::string> all_of(const std::string& text, const char* pattern) {
  const std::regex word(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator k(text.begin(), text.end(), word), end; k != end; ++k) found.insert((*k)[1]);
  return found;
}

// The commands of the --help text, which begin a line.
std::set<std::string> commands_of_help() {
  const std::string help = fascicle({"--help"}).out;
  return all_of(help.substr(help.find("Subcommands:")), "\n  ([a-z]+) ");
}

TEST(Manual, HasEveryCommandAndOptionThatHelpHas) {
  const std::string page = manual("man");
  const std::string bash = manual("bash"), zsh = manual("zsh"), fish = manual("fish");
  const std::set<std::string> commands = commands_of_help();
  ASSERT_GE(commands.size(), 8u);
  EXPECT_FALSE(commands.contains("manual")) << "manual is for build scripts";
  for (const std::string& command : commands) {
    EXPECT_NE(page.find(".SS fascicle " + command + "\n"), std::string::npos) << command;
    EXPECT_NE(fish.find("-a " + command + " "), std::string::npos) << command;
    EXPECT_NE(zsh.find("    " + command + ") shift"), std::string::npos) << command;
    const std::size_t at = bash.find("    " + command + ") options=");
    ASSERT_NE(at, std::string::npos) << command;
    const std::string line = bash.substr(at, bash.find('\n', at) - at);
    const std::set<std::string> options =
        all_of(fascicle({command, "--help"}).out, "\n  (?:-[a-z],)?(--[a-z][a-z-]*)");
    EXPECT_GE(options.size(), 2u) << command;
    for (const std::string& option : options) {
      EXPECT_NE((line + " ").find(option), std::string::npos) << command << " " << option;
      EXPECT_NE(zsh.find("'*" + option + "["), std::string::npos) << option;
      EXPECT_NE(fish.find(" -l " + option.substr(2) + " "), std::string::npos) << option;
      std::string roff;
      for (const char c : option) roff += c == '-' ? std::string("\\-") : std::string(1, c);
      EXPECT_NE(page.find(roff), std::string::npos) << option;
    }
  }
}

// Expects no messages from a shell's syntax checker; skipped with a message if the shell is not installed.
void check_with(const std::string& program, const std::string& arguments, const std::string& text) {
  if (std::system(("command -v " + program + " >/dev/null").c_str()) != 0) {
    std::fprintf(stderr, "%s IS NOT INSTALLED, NOT TESTED\n", program.c_str());
    return;
  }
  const TemporaryFolder folder;
  write_text(folder / "text", text);
  const int status =
      std::system((program + " " + arguments + " " + (folder / "text") + " 2>" + (folder / "said")).c_str());
  EXPECT_EQ(status, 0) << program;
  EXPECT_EQ(read_text(folder / "said"), "") << program;
}

TEST(Manual, IsReadWithoutAWarning) {
  check_with("bash", "-n", manual("bash"));
  check_with("zsh", "-n", manual("zsh"));
  check_with("fish", "-n", manual("fish"));
  // man prints the page; its warnings go to stderr, which check_with reads.
  check_with("man", "--warnings -l >/dev/null", manual("man"));
}

std::string completed(const std::string& words, int current) {
  const TemporaryFolder folder;
  write_text(folder / "script", manual("bash") + "\ncd " + (folder / ".") + "\nCOMP_WORDS=(" + words +
                                    ")\nCOMP_CWORD=" + std::to_string(current) +
                                    "\n_fascicle\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
  EXPECT_EQ(std::system(("bash " + (folder / "script") + " > " + (folder / "out")).c_str()), 0);
  return read_text(folder / "out");
}

// A nested subcommand has its section in the page and its words in the completions.
TEST(Manual, HasBatchStatus) {
  const std::string page = manual("man");
  const std::size_t at = page.find(".SS fascicle batch status\n");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(page.find("\\-\\-merge", at), std::string::npos);
  EXPECT_EQ(completed("fascicle batch statu", 2), "status\n");
  EXPECT_EQ(completed("fascicle batch --merg", 2), "--merge\n");
  EXPECT_EQ(completed("fascicle bake statu", 2), "\n");
  EXPECT_NE(manual("fish").find(" -l merge "), std::string::npos);
  EXPECT_NE(manual("zsh").find("'*--merge["), std::string::npos);
}

TEST(Manual, BashCompletes) {
  EXPECT_EQ(completed("fascicle ba", 1), "bake\nbatch\n");
  EXPECT_EQ(completed("fascicle bake --usd", 2), "--usd-skel\n");
  EXPECT_EQ(completed("fascicle bake --format gl", 3), "glb\n");
  EXPECT_EQ(completed("fascicle bake --format glb,pc", 3), "glb,pc2\n");
  EXPECT_EQ(completed("fascicle bake rod-c", 2), "rod-cantilever\n");
}

}  // namespace
}  // namespace fascicle::tests
