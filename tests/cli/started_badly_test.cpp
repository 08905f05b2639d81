// However the program is started: closed streams, early signals, file limits, and symbolic links at its
// outputs' paths.
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/cli/program.h"

namespace fascicle::tests::started_badly_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Runs `fascicle ARGUMENTS...` after calling `prepare` in its process. stdout and stderr go to files, unless
// `prepare` closes them.
Outcome started(const std::vector<std::string>& arguments, const std::function<void()>& prepare) {
  const TemporaryFolder folder;
  std::vector<std::string> words{FASCICLE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string out = folder / "out", err = folder / "err", cache = folder / "cache";
  const pid_t process = ::fork();
  if (process == 0) {
    ::setenv("FASCICLE_CACHE_DIR", cache.c_str(), 1);
    for (const int number : {SIGINT, SIGTERM, SIGXFSZ}) std::signal(number, SIG_DFL);
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDOUT_FILENO);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
    prepare();
    ::execv(argv[0], argv.data());
    std::_Exit(127);
  }
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  Outcome outcome;
  if (WIFEXITED(status)) outcome.status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  outcome.out = read_text(out);
  outcome.err = read_text(err);
  return outcome;
}

std::vector<std::string> bake_command(const std::string& folder, const std::string& end = "0.1") {
  return {"bake", "bar-hang-none", "-o", folder, "--end", end, "--device", "cpu", "--format", "pc2,obj"};
}

std::vector<std::string> with(std::vector<std::string> command, const std::string& word) {
  command.push_back(word);
  return command;
}

json manifest_of(const std::string& folder) {
  return json::parse(read_text(folder + "/manifest.json"));
}

// Progress lines would go to the third file that a bake opens, and its results to the second.
TEST(StartedBadly, ClosedStreamsLeaveNothingInOutputs) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle(bake_command(folder / "whole")).status, 0);
  const std::vector<std::vector<int>> closings{{0}, {1}, {2}, {0, 1}, {1, 2}, {0, 1, 2}};
  for (const std::vector<int>& closed : closings) {
    SCOPED_TRACE(testing::PrintToString(closed));
    fs::remove_all(folder / "out");
    const Outcome outcome = started(with(bake_command(folder / "out"), "--verbose"), [&] {
      for (const int stream : closed) ::close(stream);
    });
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const char* file : {"metrics.csv", "frames.fascicle", "surface.pc2", "rest.obj", "model.fascicle",
                             "obj/frame_000000.obj", "obj/frame_000006.obj"})
      EXPECT_TRUE(read_text(folder / ("out/" + std::string(file))) ==
                  read_text(folder / ("whole/" + std::string(file))))
          << file;
    EXPECT_EQ(manifest_of(folder / "out")["status"], "complete");
  }
}

// The reader of stderr has ended: the bake goes on, and only its lines are lost.
TEST(StartedBadly, ABakeWhoseLinesNobodyReadsGoesOn) {
  const TemporaryFolder folder;
  const Outcome outcome = started(with(bake_command(folder / "out"), "--verbose"), [] {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) std::_Exit(126);
    ::close(ends[0]);
    ::dup2(ends[1], STDERR_FILENO);
    std::signal(SIGPIPE, SIG_DFL);
  });
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(manifest_of(folder / "out")["status"], "complete");
}

// Sends a signal before the program starts, blocked until the program unblocks it, so it arrives as early as
// possible.
void send_at_once(int number) {
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, number);
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  ::kill(::getpid(), number);
}

TEST(StartedBadly, ASignalThatComesAtOnceInterrupts) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle(bake_command(folder / "whole")).status, 0);
  for (const int number : {SIGINT, SIGTERM}) {
    SCOPED_TRACE(number);
    const auto signalled = [&](const std::vector<std::string>& command) {
      return started(command, [&] { send_at_once(number); });
    };
    const Outcome baked = signalled(bake_command(folder / "out", "2"));
    EXPECT_EQ(baked.status, 75) << baked.signal << baked.err;
    EXPECT_TRUE(contains(baked.err, "interrupted")) << baked.err;
    const Outcome exported =
        signalled({"export", folder / "whole", "--to", "mdd", "-o", folder / "exported"});
    EXPECT_EQ(exported.status, 75) << exported.signal << exported.err;
    const Outcome batch = signalled({"bake", "arm", "--clips", "all", "-o", folder / "clips"});
    EXPECT_EQ(batch.status, 75) << batch.signal << batch.err;
    const Outcome drawn = signalled({"render", folder / "whole", "-o", folder / "drawn.png"});
    EXPECT_EQ(drawn.status, 75) << drawn.signal << drawn.err;
    EXPECT_EQ(signalled({"verify", folder / "whole"}).status, 75);
    EXPECT_EQ(signalled({"report", folder / "whole", "-o", folder / "page.html"}).status, 75);
    EXPECT_FALSE(fs::exists(folder / "page.html"));
    // A command with nothing to finish ends like any program.
    EXPECT_EQ(signalled({"scenes"}).signal, number);
  }
}

// A signal ignored by the parent process stays ignored.
TEST(StartedBadly, AnIgnoredSignalStaysIgnored) {
  const TemporaryFolder folder;
  const Outcome outcome = started(bake_command(folder / "out"), [] {
    std::signal(SIGINT, SIG_IGN);
    send_at_once(SIGINT);
  });
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST(StartedBadly, ALimitOnFilesEndsABakeWithItsReason) {
  const TemporaryFolder folder;
  const std::vector<std::string> command{"bake", "bar-hang-none", "-o", folder / "out", "--end",
                                         "2",    "--device",      "cpu"};
  const Outcome outcome = started(command, [] {
    // More than the model and its checkpoints, less than all frames.
    constexpr rlim_t bytes = 400'000;
    const rlimit limit{bytes, bytes};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "frames.fascicle")) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "ulimit -f")) << outcome.err;
  const json manifest = manifest_of(folder / "out");
  EXPECT_EQ(manifest["status"], "failed");
  EXPECT_TRUE(contains(manifest["message"], "ulimit -f")) << manifest["message"];
  EXPECT_GT(fs::file_size(folder / "out/frames.fascicle"), 300'000u);
  // Only whole frames are left, and the bake resumes from there.
  const Outcome resumed = fascicle(with(command, "--resume"));
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(manifest_of(folder / "out")["status"], "complete");
}

// A folder with symbolic links at the paths of outputs being written.
class LinkedOutputs : public testing::Test {
 protected:
  void link(const std::string& name) {
    fs::remove(folder_ / ("out/" + name));
    fs::create_symlink(victim_, folder_ / ("out/" + name));
  }
  void expect_untouched() const { EXPECT_EQ(read_text(victim_), "precious"); }
  void SetUp() override {
    fs::create_directories(folder_ / "out");
    write_text(victim_, "precious");
  }

  const TemporaryFolder folder_;
  const std::string victim_ = folder_ / "victim";
};

TEST_F(LinkedOutputs, AreNotWrittenThroughByANewBake) {
  link("manifest.json.tmp");
  const Outcome outcome = fascicle(bake_command(folder_ / "out"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expect_untouched();
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / "out/manifest.json")));
}

TEST_F(LinkedOutputs, AreNotWrittenThroughByAResumedBakeOrAnExport) {
  ASSERT_EQ(fascicle(bake_command(folder_ / "out")).status, 0);
  for (const char* name : {"manifest.json.tmp", "checkpoint.tmp", "model.fascicle.tmp", "rest.obj.tmp",
                           "import_blender.py.tmp", "surface.mdd.part", "surface.mdd"})
    link(name);
  const Outcome resumed = fascicle(with(bake_command(folder_ / "out"), "--resume"));
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  expect_untouched();
  const Outcome exported = fascicle({"export", folder_ / "out", "--to", "mdd", "--overwrite"});
  EXPECT_EQ(exported.status, 0) << exported.err;
  expect_untouched();
  for (const char* name : {"manifest.json", "model.fascicle", "rest.obj", "surface.mdd"})
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder_ / ("out/" + std::string(name))))) << name;
}

TEST_F(LinkedOutputs, AreReplacedWithOverwrite) {
  ASSERT_EQ(fascicle(bake_command(folder_ / "out")).status, 0);
  for (const char* name : {"frames.fascicle", "frames.fascicle.tmp", "metrics.csv", "metrics.csv.part",
                           "surface.pc2.part", "checkpoint", "checkpoint.tmp", "rest.obj", "rest.obj.tmp",
                           "obj/frame_000003.obj", "obj/frame_000003.obj.tmp"})
    link(name);
  const Outcome outcome = fascicle(with(bake_command(folder_ / "out"), "--overwrite"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  expect_untouched();
  for (const auto& item : fs::recursive_directory_iterator(folder_ / "out")) EXPECT_FALSE(item.is_symlink());
}

// Content of a folder that a symbolic link leads to belongs to the user.
TEST_F(LinkedOutputs, FramesAreNotWrittenIntoALinkedFolder) {
  const auto put_link = [&] {
    fs::remove_all(folder_ / "out/obj");
    fs::create_directory_symlink(folder_ / "frames", folder_ / "out/obj");
  };
  const auto is_plain = [&] { return fs::is_directory(fs::symlink_status(folder_ / "out/obj")); };
  fs::create_directories(folder_ / "frames");
  write_text(folder_ / "frames/frame_000001.obj", "precious");
  put_link();
  EXPECT_EQ(fascicle(bake_command(folder_ / "out")).status, 3);
  fs::remove_all(folder_ / "out");
  ASSERT_EQ(fascicle(bake_command(folder_ / "out")).status, 0);
  put_link();
  EXPECT_EQ(fascicle(with(bake_command(folder_ / "out"), "--resume")).status, 3);
  EXPECT_EQ(fascicle(with(bake_command(folder_ / "out"), "--overwrite")).status, 0);
  EXPECT_TRUE(is_plain());
  put_link();
  EXPECT_EQ(fascicle({"export", folder_ / "out", "--to", "obj"}).status, 3);
  EXPECT_EQ(fascicle({"export", folder_ / "out", "--to", "obj", "--overwrite"}).status, 0);
  EXPECT_TRUE(is_plain());
  EXPECT_EQ(read_text(folder_ / "frames/frame_000001.obj"), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "frames/frame_000002.obj"));
}

// An output stream, or frames, that a resumed bake would continue, replaced by a symbolic link.
TEST_F(LinkedOutputs, AreNotResumed) {
  for (const char* name : {"metrics.csv.part", "surface.pc2.part", "metrics.csv", "frames.fascicle"}) {
    SCOPED_TRACE(name);
    fs::remove_all(folder_ / "out");
    ASSERT_EQ(fascicle(bake_command(folder_ / "out")).status, 0);
    const std::string path = folder_ / ("out/" + std::string(name));
    const std::string whole = path.ends_with(".part") ? path.substr(0, path.size() - 5) : path;
    fs::copy_file(whole, victim_, fs::copy_options::overwrite_existing);
    fs::remove(path);
    fs::create_symlink(victim_, path);
    const std::string before = read_text(victim_);
    fs::remove(folder_ / "out/rest.obj");  // so that something is left to do
    const Outcome outcome = fascicle(with(bake_command(folder_ / "out"), "--resume"));
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "symbolic link")) << outcome.err;
    EXPECT_TRUE(read_text(victim_) == before);
  }
}

}  // namespace
}  // namespace fascicle::tests::started_badly_test
