// A helper's output file appears complete or not at all, however the helper ends.
#include "host/base/pending_output.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/helper_program.h"
#include "host/base/sandbox.h"

namespace fascicle::tests::pending_output_test {
namespace {

namespace fs = std::filesystem;

class PendingOutputTest : public testing::Test {
 protected:
  std::string operator()(const char* name) const { return (folder_.path() / name).string(); }
  auto files() const {
    return std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator());
  }

  // Starts a child that opens a pending output and raises `number`. Returns the signal that ended it.
  int ended_by(int number, bool is_in_sandbox) {
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit none{0, 0};
      ::setrlimit(RLIMIT_CORE, &none);
      const base::PendingOutput output((*this)("out"));
      if (!fs::exists(output.part())) ::_exit(1);
      if (is_in_sandbox) base::enter_sandbox({}, (*this)("out"));
      ::raise(number);
      ::_exit(2);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status)) << number << ": not ended by a signal; exit status "
                                     << WEXITSTATUS(status);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  base::TemporaryFolder folder_;
};

TEST_F(PendingOutputTest, WhatWasNotFinishedLeavesNothing) {
  const std::string path = (*this)("out");
  {
    const base::PendingOutput output(path);
    EXPECT_TRUE(fs::exists(output.part()));
    EXPECT_FALSE(fs::exists(path));
  }
  EXPECT_EQ(files(), 0);
  base::PendingOutput(path).finish("whole");
  std::ifstream in(path);
  std::string text;
  EXPECT_TRUE(in >> text);
  EXPECT_EQ(text, "whole");
  EXPECT_EQ(files(), 1);
  EXPECT_THROW(base::PendingOutput((*this)("missing/out")), std::system_error);
}

TEST_F(PendingOutputTest, NothingIsWrittenThroughALinkOfThePartsName) {
  const std::string path = (*this)("out"), kept = (*this)("kept");
  std::ofstream(kept) << "kept";
  const std::string part = base::PendingOutput(path).part();
  fs::create_symlink(kept, part);
  base::PendingOutput(path).finish("other one");
  EXPECT_EQ(fs::file_size(kept), 4u);
}

TEST_F(PendingOutputTest, ASignalLeavesNothingAndEndsTheHelper) {
  for (const bool is_in_sandbox : {false, true})
    for (const int number :
         {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGILL, SIGABRT, SIGBUS, SIGFPE, SIGSEGV}) {
      EXPECT_EQ(ended_by(number, is_in_sandbox), number);
      EXPECT_EQ(files(), 0) << number << (is_in_sandbox ? " in the sandbox" : "");
    }
}

// SIGKILL cannot be caught. The next helper removes leftovers that are more than an hour old, and nothing
// else.
TEST_F(PendingOutputTest, WhatAKilledOneLeftGoesWithTheNext) {
  EXPECT_EQ(ended_by(SIGKILL, false), SIGKILL);
  ASSERT_EQ(files(), 1) << "the control: a killed helper leaves its part";
  const fs::path left = fs::directory_iterator(folder_.path())->path();
  base::PendingOutput((*this)("out")).finish("whole");
  EXPECT_TRUE(fs::exists(left)) << "its owner may still be writing it";
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(2);
  for (const char* name : {"out.part-", "out.part-12a", "other.part-12"}) {
    std::ofstream((*this)(name)) << "a user's";
    fs::last_write_time((*this)(name), long_ago);
  }
  fs::last_write_time(left, long_ago);
  base::PendingOutput((*this)("out")).finish("whole");
  EXPECT_FALSE(fs::exists(left));
  for (const char* name : {"out.part-", "out.part-12a", "other.part-12"})
    EXPECT_TRUE(fs::exists((*this)(name))) << name;
}

// Afterwards the previous signal handlers are back.
TEST_F(PendingOutputTest, ListensOnlyWhileItIsThere) {
  struct sigaction during {
  }, after{};
  {
    const base::PendingOutput output((*this)("out"));
    ::sigaction(SIGTERM, nullptr, &during);
  }
  ::sigaction(SIGTERM, nullptr, &after);
  EXPECT_NE(during.sa_handler, SIG_DFL);
  EXPECT_EQ(after.sa_handler, SIG_DFL);
}

}  // namespace
}  // namespace fascicle::tests::pending_output_test
