// What a helper can still do in the sandbox, compared with the same attempts outside.
#include "host/base/sandbox.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
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
#include "host/base/pending_output.h"

namespace fascicle::tests::sandbox_test {
namespace {

namespace fs = std::filesystem;

enum class By { nothing, landlock, seccomp };

// Landlock fails with EACCES, or with EXDEV for a name in another folder; the seccomp filter fails with
// EPERM.
By refuser_of(int error) {
  return error == EACCES || error == EXDEV ? By::landlock : error == EPERM ? By::seccomp : By::nothing;
}

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

// With F_SETSIG and O_ASYNC this would let any writer to the pipe signal its owner.
bool has_signalled(int descriptor, pid_t process) {
  return ::fcntl(descriptor, F_SETOWN, process) == 0;
}

// Any library may do this with its own files.
bool copies(int descriptor) {
  const int copy = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  if (copy < 0) return false;
  const bool is_known = (::fcntl(copy, F_GETFD) & FD_CLOEXEC) != 0 && ::fcntl(copy, F_GETFL) >= 0;
  ::close(copy);
  return is_known;
}

bool peeks() {
  int from = 1, to = 0;
  const iovec source{&from, sizeof from}, target{&to, sizeof to};
  return ::process_vm_readv(::getpid(), &target, 1, &source, 1, 0) == static_cast<ssize_t>(sizeof from);
}

class Sandbox : public ::testing::Test {
 protected:
  void SetUp() override { fill(); }
  void fill() const {
    for (const char* name : {"work", "work/below", "elsewhere"}) fs::create_directory(folder_.path() / name);
    for (const char* name :
         {"input", "work/other", "work/below/kept", "elsewhere/kept", "elsewhere/neighbour"})
      std::ofstream(folder_.path() / name) << "text";
  }
  fs::path operator()(const std::string& name) const { return folder_.path() / name; }

  std::vector<Attempt> attempts() {
    const auto at = [this](const std::string& name) { return (*this)(name); };
    return {
        {"reads its input", By::nothing, [=] { return opens(at("input"), O_RDONLY); }},
        {"writes its output", By::nothing, [this] { return writes_output(); }},
        {"removes its output", By::nothing, [=] { return ::unlink(at("work/out").c_str()) == 0; }},
        {"copies a descriptor", By::nothing, [] { return copies(report); }},
        {"takes memory", By::nothing, [] { return maps(PROT_READ | PROT_WRITE, PROT_READ); }},
        {"reads /etc/passwd", By::landlock, [] { return opens("/etc/passwd", O_RDONLY); }},
        {"reads its input's neighbour", By::landlock,
         [=] { return opens(at("elsewhere/neighbour"), O_RDONLY); }},
        {"reads the output's folder", By::landlock,
         [=] { return opens(at("work"), O_RDONLY | O_DIRECTORY); }},
        {"reads beside its output", By::landlock, [=] { return opens(at("work/other"), O_RDONLY); }},
        {"writes another file beside its output", By::landlock,
         [=] { return opens(at("work/new"), O_WRONLY | O_CREAT); }},
        {"writes into what lies beside its output", By::landlock,
         [=] { return opens(at("work/other"), O_WRONLY); }},
        {"writes below its output's folder", By::landlock,
         [=] { return opens(at("work/below/kept"), O_WRONLY | O_TRUNC); }},
        {"moves a file into a folder below", By::landlock,
         [=] { return ::rename(at("work/other").c_str(), at("work/below/kept").c_str()) == 0; }},
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
        {"has a file signal its parent", By::seccomp, [] { return has_signalled(report, ::getppid()); }},
        {"makes memory executable", By::seccomp, [] { return maps(PROT_READ, PROT_READ | PROT_EXEC); }},
        {"takes executable memory", By::seccomp,
         [] { return maps(PROT_READ | PROT_EXEC, PROT_READ | PROT_EXEC); }},
        {"changes a file's rights", By::seccomp, [=] { return ::chmod(at("input").c_str(), 0600) == 0; }},
        {"makes a link", By::seccomp, [=] { return ::symlink("input", at("work/link").c_str()) == 0; }},
        {"makes a folder", By::seccomp, [=] { return ::mkdir(at("work/folder").c_str(), 0700) == 0; }},
        {"reads a process's memory", By::seccomp, peeks},
        // Must be the last: if it succeeds, the process is replaced.
        {"becomes another program", By::seccomp,
         [] {
           ::execl("/bin/sh", "sh", "-c", "printf 1 >&3", nullptr);
           return false;
         }},
    };
  }

  bool writes_output() {
    try {
      output_->finish("text");
      return true;
    } catch (const std::system_error& error) {
      errno = error.code().value();
      return false;
    }
  }

  // One character for each of attempts(), reported by a child process: 1 for success, or who refused it.
  std::string outcome(bool is_in_sandbox) {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe(ends.data()), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      if (ends[1] != report) ::dup2(ends[1], report);
      output_.emplace((*this)("work/out").string());
      if (is_in_sandbox) base::enter_sandbox({(*this)("input"), (*this)("missing")}, (*this)("work/out"));
      for (const Attempt& attempt : attempts()) {
        errno = 0;
        const char answer = attempt.succeeds() ? '1' : letter_of(refuser_of(errno));
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

  static char letter_of(By refuser) {
    return refuser == By::landlock ? 'L' : refuser == By::seccomp ? 'S' : '?';
  }

  static constexpr int report = 3;
  std::optional<base::PendingOutput> output_;  // the child's
  base::TemporaryFolder folder_;
};

TEST_F(Sandbox, LeavesWhatAHelperNeedsAndNothingElse) {
  const std::string kernel = base::sandbox_words();
  const bool has_landlock = kernel.find("Landlock") != std::string::npos;
  const bool has_seccomp = kernel.find("seccomp") != std::string::npos;
  if (!has_landlock && !has_seccomp)
    GTEST_SKIP() << "SKIPPED LOUDLY: this kernel has neither Landlock nor seccomp";
  if (!has_landlock || !has_seccomp)
    std::printf("TESTED IN PART: this kernel has no whole sandbox, but %s\n", kernel.c_str());
  const std::string inside = outcome(true);
  fill();
  const std::string outside = outcome(false);
  const std::vector<Attempt> all = attempts();
  ASSERT_EQ(inside.size(), all.size());
  ASSERT_EQ(outside.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const By refuser = all[i].refused_by;
    const bool is_here = refuser == By::landlock ? has_landlock : refuser != By::seccomp || has_seccomp;
    const char wanted = refuser == By::nothing ? '1' : letter_of(refuser);
    if (is_here) {
      EXPECT_EQ(inside[i], wanted) << all[i].what;
    }
    EXPECT_EQ(outside[i], '1') << "the control: without the sandbox it " << all[i].what;
  }
}

// abort() must still work: the parent recognises a crash by its signal.
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
}  // namespace fascicle::tests::sandbox_test
