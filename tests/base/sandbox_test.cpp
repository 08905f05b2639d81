// What a helper can still do in the sandbox, beside the same attempts without it.
#include "host/base/sandbox.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/helper_program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

enum class By { nothing, landlock, seccomp };

struct Attempt {
  std::string what;
  By refused_by;
  std::function<bool()> succeeds;
};

bool opens(const fs::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (descriptor >= 0) ::close(descriptor);
  return descriptor >= 0;
}

bool makes_socket(int family) {
  const int descriptor = ::socket(family, SOCK_STREAM, 0);
  if (descriptor >= 0) ::close(descriptor);
  return descriptor >= 0;
}

bool forks() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  if (child > 0) ::waitpid(child, nullptr, 0);
  return child > 0;
}

bool maps(int protection, int later) {
  constexpr std::size_t size = 4096;
  void* const memory = ::mmap(nullptr, size, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return false;
  const bool is_changed = later == protection || ::mprotect(memory, size, later) == 0;
  ::munmap(memory, size);
  return is_changed;
}

bool peeks() {
  int from = 1, to = 0;
  const iovec source{&from, sizeof from}, target{&to, sizeof to};
  return ::process_vm_readv(::getpid(), &target, 1, &source, 1, 0) == static_cast<ssize_t>(sizeof from);
}

class Sandbox : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"work", "elsewhere"}) fs::create_directory(folder_.path() / name);
    for (const char* name : {"input", "work/other", "elsewhere/kept", "elsewhere/neighbour"})
      std::ofstream(folder_.path() / name) << "text";
  }
  fs::path operator()(const std::string& name) const { return folder_.path() / name; }

  std::vector<Attempt> attempts() const {
    const auto at = [this](const std::string& name) { return (*this)(name); };
    return {
        {"reads its input", By::nothing, [=] { return opens(at("input"), O_RDONLY); }},
        {"writes beside its output", By::nothing,
         [=] { return opens(at("work/part"), O_WRONLY | O_CREAT | O_EXCL); }},
        {"renames to its output", By::nothing,
         [=] { return ::rename(at("work/part").c_str(), at("work/out").c_str()) == 0; }},
        {"removes what it wrote", By::nothing, [=] { return ::unlink(at("work/out").c_str()) == 0; }},
        {"takes memory", By::nothing, [] { return maps(PROT_READ | PROT_WRITE, PROT_READ); }},
        {"reads /etc/passwd", By::landlock, [] { return opens("/etc/passwd", O_RDONLY); }},
        {"reads its input's neighbour", By::landlock,
         [=] { return opens(at("elsewhere/neighbour"), O_RDONLY); }},
        {"reads the output's folder", By::landlock,
         [=] { return opens(at("work"), O_RDONLY | O_DIRECTORY); }},
        {"reads beside its output", By::landlock, [=] { return opens(at("work/other"), O_RDONLY); }},
        {"writes into its input", By::landlock, [=] { return opens(at("input"), O_WRONLY); }},
        {"writes elsewhere", By::landlock, [=] { return opens(at("elsewhere/new"), O_WRONLY | O_CREAT); }},
        {"truncates what lies elsewhere", By::landlock,
         [=] { return opens(at("elsewhere/kept"), O_WRONLY | O_TRUNC); }},
        {"removes what lies elsewhere", By::landlock,
         [=] { return ::unlink(at("elsewhere/kept").c_str()) == 0; }},
        {"opens a socket of the internet", By::seccomp, [] { return makes_socket(AF_INET); }},
        {"opens a socket of this machine", By::seccomp, [] { return makes_socket(AF_UNIX); }},
        {"starts a process", By::seccomp, forks},
        {"signals its parent", By::seccomp, [] { return ::kill(::getppid(), 0) == 0; }},
        {"makes memory executable", By::seccomp, [] { return maps(PROT_READ, PROT_READ | PROT_EXEC); }},
        {"takes executable memory", By::seccomp,
         [] { return maps(PROT_READ | PROT_EXEC, PROT_READ | PROT_EXEC); }},
        {"changes a file's rights", By::seccomp, [=] { return ::chmod(at("input").c_str(), 0600) == 0; }},
        {"makes a link", By::seccomp, [=] { return ::symlink("input", at("work/link").c_str()) == 0; }},
        {"makes a folder", By::seccomp, [=] { return ::mkdir(at("work/folder").c_str(), 0700) == 0; }},
        {"reads a process's memory", By::seccomp, peeks},
        // The last: where it succeeds nothing comes after it.
        {"becomes another program", By::seccomp,
         [] {
           ::execl("/bin/sh", "sh", "-c", "printf 1 >&3", nullptr);
           return false;
         }},
    };
  }

  // What succeeded, in the order of attempts(), as a child of this process reports it.
  std::string outcome(bool is_in_sandbox) const {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe(ends.data()), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      constexpr int report = 3;
      if (ends[1] != report) ::dup2(ends[1], report);
      if (is_in_sandbox) base::enter_sandbox({(*this)("input"), (*this)("missing")}, (*this)("work/out"));
      for (const Attempt& attempt : attempts()) {
        const char answer = attempt.succeeds() ? '1' : '0';
        if (::write(report, &answer, 1) != 1) ::_exit(1);
      }
      ::_exit(0);
    }
    ::close(ends[1]);
    std::string text;
    for (char c = 0; ::read(ends[0], &c, 1) == 1;) text += c;
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    return text;
  }

  base::TemporaryFolder folder_;
};

TEST_F(Sandbox, LeavesWhatAHelperNeedsAndNothingElse) {
  const std::string kernel = base::sandbox_words();
  const bool has_landlock = kernel.find("Landlock") != std::string::npos;
  const bool has_seccomp = kernel.find("seccomp") != std::string::npos;
  if (!has_landlock || !has_seccomp)
    GTEST_SKIP() << "SKIPPED LOUDLY: this kernel has no whole sandbox, but " << kernel;
  // Nothing happens to what is elsewhere, so the control comes second.
  const std::string inside = outcome(true), outside = outcome(false);
  const std::vector<Attempt> all = attempts();
  ASSERT_EQ(inside.size(), all.size());
  ASSERT_EQ(outside.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(inside[i] == '1', all[i].refused_by == By::nothing) << all[i].what;
    EXPECT_EQ(outside[i], '1') << "the control: without the sandbox it " << all[i].what;
  }
}

// abort() must end it: a helper that is lost says so by its signal.
TEST_F(Sandbox, LetsAProgramEndItself) {
  const pid_t child = ::fork();
  if (child == 0) {
    base::enter_sandbox({}, "");
    std::abort();
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
}

}  // namespace
}  // namespace fascicle::tests
