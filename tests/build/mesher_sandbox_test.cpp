// fascicle-mesher from outside: it enters its sandbox before it opens a file, and reads no other file.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/sandbox.h"
#include "host/build/mesher.h"

namespace fascicle::tests::mesher_sandbox_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* tetrahedron =
    "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

// Two intersecting tetrahedra.
constexpr const char* crossing =
    "OFF\n8 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.2 0.2 0.2\n1.2 0.2 0.2\n0.2 1.2 0.2\n0.2 0.2 1.2\n"
    "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 4 6 5\n3 4 5 7\n3 5 6 7\n3 4 7 6\n";

// The line "NAME:\tVALUE" of /proc/PID/status.
std::string status_of(pid_t process, const std::string& name) {
  std::ifstream in("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(in, line);)
    if (line.rfind(name + ":\t", 0) == 0) return line.substr(name.size() + 2);
  return "";
}

class MesherSandbox : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(::mkfifo(at("surface.off").c_str(), 0600), 0);
    std::ofstream(at("points.txt")) << "1\n0.2 0.2 0.2\n";
    std::ofstream(at("other.txt")) << "1\n0.3 0.2 0.2\n";
    fs::create_symlink("points.txt", at("points"));
    arguments_ = {build::mesher_path({}).string(),
                  "tetrahedralize",
                  at("surface.off"),
                  at("out.mesh"),
                  "--points",
                  at("points")};
    std::vector<char*> words;
    for (std::string& word : arguments_) words.push_back(word.data());
    words.push_back(nullptr);
    ASSERT_EQ(::posix_spawn(&mesher_, words.front(), nullptr, nullptr, words.data(), environ), 0);
    // It blocks in open(), as nothing has opened the FIFO of its surface for writing. On a busy machine it
    // may take a while to get there.
    constexpr auto patience = std::chrono::seconds(60);
    const auto began = std::chrono::steady_clock::now();
    while (!waits() && std::chrono::steady_clock::now() - began < patience)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_TRUE(waits()) << "fascicle-mesher does not open its input";
  }
  void TearDown() override {
    if (mesher_ > 0 && !is_over_) {
      ::kill(mesher_, SIGKILL);
      ::waitpid(mesher_, nullptr, 0);
    }
  }

  std::string at(const std::string& name) const { return (folder_.path() / name).string(); }
  // A non-blocking open for writing succeeds only once a reader has the FIFO open.
  bool waits() {
    if (writer_ >= 0) return true;
    const int there = ::open(at("surface.off").c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    writer_ = there;
    return there >= 0;
  }
  std::string part() const { return at("out.mesh.part-" + std::to_string(mesher_)); }
  int finish(const std::string& surface = tetrahedron) {
    EXPECT_EQ(::write(writer_, surface.data(), surface.size()), static_cast<ssize_t>(surface.size()));
    ::close(writer_);
    int status = 0;
    EXPECT_EQ(::waitpid(mesher_, &status, 0), mesher_);
    is_over_ = true;
    EXPECT_TRUE(WIFEXITED(status));
    return WEXITSTATUS(status);
  }

  base::TemporaryFolder folder_;
  std::vector<std::string> arguments_;
  pid_t mesher_ = 0;
  int writer_ = -1;
  bool is_over_ = false;
};

TEST_F(MesherSandbox, IsEnteredBeforeTheInputIsRead) {
  EXPECT_EQ(status_of(mesher_, "NoNewPrivs"), "1");
  if (base::sandbox_words().find("seccomp") != std::string::npos) {
    EXPECT_EQ(status_of(mesher_, "Seccomp"), "2") << "2 means filter mode";
  }
  EXPECT_EQ(status_of(::getpid(), "NoNewPrivs"), "0") << "the control: this process does not have it set";
  // Its output exists already, as it may no longer open files for writing.
  ASSERT_TRUE(fs::exists(part()));
  EXPECT_EQ(fs::file_size(part()), 0u);
  // Also the control of the next test: the mesher works in its sandbox.
  EXPECT_EQ(finish(), build::mesher_done);
  EXPECT_TRUE(fs::exists(at("out.mesh")));
  EXPECT_FALSE(fs::exists(part()));
}

// TetGen gives up with an exception that unwinds nothing.
TEST_F(MesherSandbox, LeavesNothingOfAnOutputWhereTetGenGivesUp) {
  EXPECT_TRUE(fs::exists(part()));
  EXPECT_EQ(finish(crossing), build::mesher_self_intersecting);
  EXPECT_FALSE(fs::exists(part()));
  EXPECT_FALSE(fs::exists(at("out.mesh")));
}

TEST_F(MesherSandbox, ReadsNoFileThatItWasNotGivenAtTheStart) {
  if (base::sandbox_words().find("Landlock") == std::string::npos)
    GTEST_SKIP() << "SKIPPED LOUDLY: this kernel has no Landlock";
  fs::remove(at("points"));
  fs::create_symlink("other.txt", at("points"));
  constexpr int unreadable = 3;
  EXPECT_EQ(finish(), unreadable);
  EXPECT_FALSE(fs::exists(part()));
  EXPECT_FALSE(fs::exists(at("out.mesh")));
}

}  // namespace
}  // namespace fascicle::tests::mesher_sandbox_test
