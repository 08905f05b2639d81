// fascicle batch as a user runs it: every bake equals that of `fascicle bake`, and a stopped batch resumes to
// the same bytes.
#include <csignal>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using json = nlohmann::json;

const std::string three_bars =
    "format = [\"pc2\"]\n"
    "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=1.5\"]\n"
    "[job.bar.vary]\n\"layers.body.alpha\" = [0.4, 0.6, 0.8]\n";

// Too light for the force on it: it becomes non-finite in its first frame.
const std::string too_light =
    "[bar]\nsize = [4e-9, 1e-9, 1e-9]\nvertices = [5, 3, 3]\n[layers.body]\ndensity = 0.001\n"
    "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n"
    "[force.push]\nkind = \"point\"\nvector = [0.0, -1e9, 0.0]\nwhere = { everywhere = true }\n";

std::string list_in(const TemporaryFolder& folder, const std::string& text) {
  write_text(folder / "jobs.toml", "output = \"" + (folder / "out") + "\"\n" + text);
  return folder / "jobs.toml";
}

json summary_of(const TemporaryFolder& folder) {
  return json::parse(read_text(folder / "out/batch.json")).at("jobs");
}

void expect_what_bake_makes(const TemporaryFolder& folder) {
  for (const char* alpha : {"0.4", "0.6", "0.8"}) {
    const std::string one = std::string("one-") + alpha;
    const Outcome baked = fascicle({"bake", "bar-beta-1", "--set", "scene.end=1.5", "--set",
                                    std::string("layers.body.alpha=") + alpha, "--format", "pc2", "--device",
                                    "cpu", "-o", folder / one});
    ASSERT_EQ(baked.status, 0) << baked.err;
    for (const char* file : {"/frames.fascicle", "/surface.pc2", "/metrics.csv"})
      EXPECT_TRUE(read_text(folder / (one + file)) ==
                  read_text(folder / ("out/bar-" + std::string(alpha) + file)))
          << alpha << file;
  }
}

// Whoever reads the results may go, as `head` does: that may end the program, but loses nothing. They are
// more than a stream holds back until the program ends.
TEST(Batch, ResultsAreWrittenBeforeTheyArePrinted) {
  constexpr std::size_t count = 32;
  const TemporaryFolder folder;
  std::string text;
  for (std::size_t k = 0; k < count; ++k)
    text += "[job." + std::string(90, 'n') + std::to_string(k) +
            "]\nscene = \"bar-beta-1\"\nset = [\"scene.end=0.05\"]\n";
  const std::string list = list_in(folder, text);
  const auto run_into_a_closed_pipe = [&](const std::string& command) {
    const std::string piped = "{ sleep 1; " + std::string(FASCICLE_PROGRAM) + " batch " + command +
                              "; echo $? > " + (folder / "status") + "; } 2> /dev/null | true";
    ASSERT_EQ(std::system(piped.c_str()), 0);
    EXPECT_EQ(read_text(folder / "status"), "141\n");  // the control: it was ended by SIGPIPE
  };
  run_into_a_closed_pipe(list + " -q --device cpu");
  ASSERT_EQ(summary_of(folder).size(), count);
  for (const json& row : summary_of(folder)) EXPECT_EQ(row.at("status"), "done");
  std::filesystem::remove(folder / "out/batch.json");
  run_into_a_closed_pipe("status " + list + " --merge");
  EXPECT_EQ(summary_of(folder).size(), count);
}

TEST(Batch, MakesWhatBakeMakesOnSeveralDevices) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder, three_bars);
  const Outcome outcome = fascicle({"batch", list, "--device", "cpu,cpu:scalar"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_what_bake_makes(folder);
  for (const json& row : summary_of(folder)) {
    EXPECT_EQ(row.at("status"), "done");
    EXPECT_TRUE(contains(outcome.out, row.at("job").get<std::string>())) << outcome.out;
    EXPECT_TRUE(contains(outcome.out, row.at("last_position_hash").get<std::string>())) << outcome.out;
  }
  // Its folders now contain bakes.
  const Outcome again = fascicle({"batch", list});
  EXPECT_EQ(again.status, 2);
  EXPECT_TRUE(contains(again.err, "--resume")) << again.err;
  const std::string hashes = summary_of(folder).dump();
  EXPECT_EQ(fascicle({"batch", list, "--resume"}).status, 0);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_TRUE(contains(hashes, summary_of(folder).at(k).at("last_position_hash").get<std::string>()));
}

TEST(Batch, InterruptedAndResumedIsAsIfNeverStopped) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder, three_bars);
  Program program({"batch", list, "--device", "cpu", "--at-once", "1"});
  wait_for_file(program, folder.path() / "out/bar-0.6/manifest.json");
  program.send(SIGINT);
  const Outcome stopped = program.wait();
  // On a fast machine it may have finished before.
  if (stopped.status != 0) {
    ASSERT_EQ(stopped.status, 75) << stopped.err;
    EXPECT_TRUE(contains(stopped.err, "--resume")) << stopped.err;
    EXPECT_EQ(summary_of(folder).at(0).at("status"), "done");
    EXPECT_NE(summary_of(folder).at(2).at("status"), "done");
  }
  EXPECT_EQ(fascicle({"batch", list, "--resume"}).status, 0);
  expect_what_bake_makes(folder);
}

TEST(Batch, KilledIsResumedAtOnce) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder,
                                   "format = [\"pc2\"]\n"
                                   "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=120.0\"]\n");
  Program program({"batch", list, "--device", "cpu"});
  wait_for_file(program, folder.path() / "out/bar/checkpoint");
  program.send(SIGKILL);
  ASSERT_EQ(program.wait().signal, SIGKILL);
  const Outcome resumed = fascicle({"batch", list, "--resume"});
  EXPECT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(summary_of(folder).at(0).at("status"), "done");
}

TEST(Batch, OneFailureDoesNotEndTheOthers) {
  const TemporaryFolder folder;
  write_text(folder / "light.toml", too_light);
  const std::string list = list_in(folder,
                                   "[job.light]\nscene = \"light.toml\"\n"
                                   "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=0.2\"]\n");
  const Outcome outcome = fascicle({"batch", list});
  EXPECT_EQ(outcome.status, 5) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "light on cpu: failed")) << outcome.err;
  EXPECT_EQ(summary_of(folder).at(0).at("status"), "failed");
  EXPECT_EQ(summary_of(folder).at(0).at("exit_status"), 5);
  EXPECT_EQ(summary_of(folder).at(1).at("status"), "done");
}

// A farm goes on with a batch that says it was interrupted, and with no other.
TEST(Batch, InterruptedAfterAFailureIsInterrupted) {
  const TemporaryFolder folder;
  write_text(folder / "light.toml", too_light);
  const std::string list = list_in(folder,
                                   "[job.light]\nscene = \"light.toml\"\n"
                                   "[job.long]\nscene = \"bar-beta-1\"\nset = [\"scene.end=600\"]\n"
                                   "[job.later]\nscene = \"bar-beta-1\"\nset = [\"scene.end=0.1\"]\n");
  Program program({"batch", list, "--device", "cpu", "--at-once", "1"});
  wait_for_file(program, folder.path() / "out/long/checkpoint");
  program.send(SIGTERM);
  const Outcome stopped = program.wait();
  EXPECT_EQ(stopped.status, 75) << stopped.err;
  EXPECT_EQ(summary_of(folder).at(0).at("status"), "failed");
  EXPECT_EQ(summary_of(folder).at(1).at("status"), "interrupted");
}

// Programs that ignore the ends of their children pass that on.
TEST(Batch, SeesTheEndsOfItsBakesUnderAnyParent) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder, "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=0.1\"]\n");
  struct sigaction before {};
  ::sigaction(SIGCHLD, nullptr, &before);
  ::signal(SIGCHLD, SIG_IGN);
  Program program({"batch", list, "--device", "cpu"});
  ::sigaction(SIGCHLD, &before, nullptr);
  EXPECT_EQ(program.wait().status, 0);
  EXPECT_EQ(summary_of(folder).at(0).at("status"), "done");
}

// The last foreign line has no newline, so the first line of the bake's own log follows it directly.
TEST(Batch, PassesOnLinesThatAreNotItsOwn) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder, "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=0.2\"]\n");
  const Outcome outcome = fascicle({"batch", list}, {std::string("LD_PRELOAD=") + FASCICLE_FOREIGN_LINES,
                                                     "ASAN_OPTIONS=verify_asan_link_order=0"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* line : {"bar: {\"level\": 3, \"message\": {\"code\": 7}}\n", "bar: [1, 2]\n",
                           "bar: {\"level\": \"error\", \"message\": \"of the driver alone\"}\n",
                           "bar: plain words without an end"})
    EXPECT_TRUE(contains(outcome.err, line)) << outcome.err;
  EXPECT_EQ(summary_of(folder).at(0).at("status"), "done");
  EXPECT_EQ(summary_of(folder).at(0).at("error"), "");
}

TEST(Batch, RefusesBeforeItBegins) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& jobs, int status, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"batch", list_in(folder, jobs)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = fascicle(arguments);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out")) << outcome.err;
    return outcome.err;
  };
  const std::string good = "[job.good]\nscene = \"bar-beta-1\"\n";
  EXPECT_TRUE(contains(refusal(good + "[job.bad]\nscene = \"bar-beta-2\"\n", 3), "job.bad: bar-beta-2"));
  EXPECT_TRUE(
      contains(refusal(good + "[job.bad]\nscene = \"arm\"\nset = [\"layers.fat.alpa=1\"]\n", 3), "alpha"));
  EXPECT_TRUE(contains(refusal(good + "[job.bad]\nscene = \"arm\"\nformat = [\"pc3\"]\n", 3), "pc2"));
  EXPECT_TRUE(contains(refusal(good + "[job.bad]\nscene = \"arm\"\nkeep_frames = false\n", 3),
                       "job.bad: --keep-frames false without --format"));
  EXPECT_TRUE(contains(refusal(good, 2, {"--device", "cpu,gpu"}), "gpu"));
  EXPECT_TRUE(contains(refusal(good, 4, {"--device", "cpu,vulkan:99"}), "vulkan:99"));
  const Outcome plan = fascicle({"batch", list_in(folder, good), "--dry-run"});
  EXPECT_EQ(plan.status, 0) << plan.err;
  EXPECT_TRUE(contains(plan.out, "fascicle bake bar-beta-1")) << plan.out;
  EXPECT_FALSE(contains(plan.out, "--keep-frames")) << plan.out;
  const std::string metrics = "format = [\"none\"]\nkeep_frames = false\n";
  const Outcome bare = fascicle({"batch", list_in(folder, metrics + good), "--dry-run"});
  EXPECT_EQ(bare.status, 0) << bare.err;
  EXPECT_TRUE(contains(bare.out, "--format=none") && contains(bare.out, "--keep-frames=false")) << bare.out;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

// Parallel bakes equal those run alone. They run long enough for the overlap to be observed.
TEST(Batch, BakesAtOnceAsOneAfterTheOther) {
  const TemporaryFolder folder;
  const std::string list = list_in(folder,
                                   "[job.bar]\nscene = \"bar-beta-1\"\nset = [\"scene.end=20\"]\n"
                                   "[job.bar.vary]\n\"layers.body.alpha\" = [0.4, 0.8]\n");
  const Outcome outcome = fascicle({"batch", list, "--at-once", "2", "--threads", "1", "--verbose"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::size_t second = outcome.err.find("bar-0.8 starts"), first_end = outcome.err.find("[1/2]");
  ASSERT_NE(second, std::string::npos) << outcome.err;
  EXPECT_LT(second, first_end) << outcome.err;
  const std::vector<std::string> one_by_one{"batch", list, "--at-once", "1", "--overwrite", "--verbose"};
  const json hashes = summary_of(folder);
  const Outcome slow = fascicle(one_by_one);
  ASSERT_EQ(slow.status, 0) << slow.err;
  EXPECT_GT(slow.err.find("bar-0.8 starts"), slow.err.find("[1/2]")) << slow.err;
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(hashes.at(k).at("last_position_hash"), summary_of(folder).at(k).at("last_position_hash"));
}

const std::vector<std::string> coarse_bear{
    "bake", "crouch", "--set", "character.resolution=0.12", "--end", "0.05", "--set=motion.hold=0.0"};

std::vector<std::string> coarse_bear_with(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = coarse_bear;
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(BakeClips, MakesWhatBakeMakesOfEach) {
  const TemporaryFolder folder;
  const std::vector<std::string> options{
      "--format", "pc2,obj", "--fps=48", "--set=scene.gravity=[0.0,-3.0,0.0]", "--softness", "1.5"};
  std::vector<std::string> all =
      coarse_bear_with({"--clips", "all", "-o", folder / "out", "--device", "cpu"});
  all.insert(all.end(), options.begin(), options.end());
  const Outcome outcome = fascicle(all);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* clip : {"jump", "bump"}) {
    std::vector<std::string> one =
        coarse_bear_with({"--clip", clip, "-o", folder / (std::string("one-") + clip), "--device", "cpu"});
    one.insert(one.end(), options.begin(), options.end());
    ASSERT_EQ(fascicle(one).status, 0);
    for (const char* file : {"/frames.fascicle", "/surface.pc2", "/metrics.csv", "/model.fascicle"})
      EXPECT_TRUE(read_text(folder / (std::string("one-") + clip + file)) ==
                  read_text(folder / (std::string("out/") + clip + file)))
          << clip << file;
    EXPECT_TRUE(contains(outcome.out, clip)) << outcome.out;
  }
  EXPECT_EQ(summary_of(folder).size(), 2u);
  const Outcome again = fascicle(all);
  EXPECT_EQ(again.status, 2);
  EXPECT_TRUE(contains(again.err, "--resume")) << again.err;
  all.push_back("--resume");
  EXPECT_EQ(fascicle(all).status, 0);
}

TEST(BakeClips, RefusesBeforeItBegins) {
  const TemporaryFolder folder;
  const auto refusal = [&](std::vector<std::string> arguments, int status) {
    arguments.insert(arguments.end(), {"-o", folder / "out"});
    const Outcome outcome = fascicle(arguments);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out")) << outcome.err;
    return outcome.err;
  };
  EXPECT_TRUE(contains(refusal(coarse_bear_with({"--clips", "jumq"}), 3), "jump"));
  EXPECT_TRUE(contains(refusal(coarse_bear_with({"--clips", "all", "--clip", "jump"}), 2), "--clip"));
  EXPECT_TRUE(contains(refusal({"bake", "bar-beta-1", "--clips", "all"}, 2), "bar-beta-1"));
  EXPECT_TRUE(contains(refusal({"bake", "two-bears", "--clips", "all"}, 2), "two-bears"));
  EXPECT_TRUE(contains(refusal({"bake", "--clips", "all"}, 2), "character"));
  EXPECT_TRUE(contains(refusal({"bake", "bar-beta-1", "--at-once", "2"}, 2), "--clips"));
  EXPECT_TRUE(
      contains(refusal(coarse_bear_with({"--clips", "all", "--device", "cpu,vulkan:99"}), 4), "vulkan:99"));
  std::vector<std::string> plan = coarse_bear_with({"--clips", "all", "--dry-run"});
  EXPECT_TRUE(contains(fascicle(plan).out, "--clip=bump")) << fascicle(plan).out;
}

}  // namespace
}  // namespace fascicle::tests
