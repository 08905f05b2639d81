// A batch on a farm: the content of the scripts, that any shell reads them as intended, that parallel tasks
// never write the same file, and that status derives each job's state from the folders. tests/farm runs the
// scripts on a real Slurm.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using FarmJson = nlohmann::json;
namespace fs = std::filesystem;

const std::string four_bars =
    "[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n"
    "[job.bar.vary]\n\"layers.body.alpha\" = [0.4, 0.5, 0.6, 0.7]\n";
const std::string bars_and_bears =
    "[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n"
    "[job.bar.vary]\n\"layers.body.alpha\" = [0.4, 0.6]\n"
    "[job.bear]\nscene = \"crouch\"\nclips = \"all\"\n"
    "set = [\"character.resolution=0.12\", \"scene.end=0.05\", \"motion.hold=0.0\"]\n";

// In a folder whose name must be quoted in scripts.
struct Farm {
  explicit Farm(const std::string& jobs = four_bars) {
    fs::create_directories(home);
    write_text(home / "the jobs.toml", "output = '''" + output() + "'''\n" + jobs);
  }
  std::string list() const { return (home / "the jobs.toml").string(); }
  std::string output() const { return (home / "out").string(); }
  std::string job() const { return (home / "job").string(); }

  TemporaryFolder folder;
  fs::path home = folder.path() / "a farm's $HOME \\ `x`, 50%a";
};

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

Outcome emit(const Farm& farm, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"batch", farm.list(), "--emit", "slurm", "-o", farm.job()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return fascicle(arguments);
}

TEST(BatchFarm, TheArrayScriptAsksForWhatABakeTakes) {
  const Farm farm(bars_and_bears);
  const Outcome outcome =
      emit(farm, {"--threads", "2", "--at-once", "3", "--slurm", "--partition=x --account=y"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string script = read_text(farm.job() + "/array.sbatch");
  // The bear's clips share their model; the bars do not.
  for (const char* line : {"#!/bin/bash\n# ", "#SBATCH --array=1-3%3\n", "#SBATCH --cpus-per-task=2\n",
                           "#SBATCH --requeue\n", "#SBATCH --signal=B:TERM@120\n",
                           "#SBATCH --open-mode=append\n", "#SBATCH --partition=x --account=y\n"})
    EXPECT_TRUE(contains(script, line)) << line << script;
  EXPECT_FALSE(contains(script, "--gres"));
  EXPECT_EQ(read_text(farm.job() + "/tasks"), "bar-0.4\nbar-0.6\nbear-jump,bear-bump\n");
  const auto number_after = [&](const std::string& name) {
    return std::atoi(script.c_str() + script.find(name) + name.size());
  };
  EXPECT_GE(number_after("--mem="), 256);
  EXPECT_LE(number_after("--mem="), 4096);
  EXPECT_GE(number_after("--time="), 10);
  EXPECT_LE(number_after("--time="), 30);
  EXPECT_FALSE(fs::exists(farm.output())) << "--emit must not bake";
  for (const char* file : {"array.sbatch", "merge.sbatch", "submit"})
    EXPECT_EQ(std::system(("bash -n " + quoted(farm.job() + "/" + file)).c_str()), 0) << file;

  ASSERT_EQ(emit(farm, {"--group", "1"}).status, 0);
  EXPECT_TRUE(contains(read_text(farm.job() + "/array.sbatch"), "#SBATCH --array=1-4\n"));
  EXPECT_TRUE(contains(read_text(farm.job() + "/array.sbatch"), "#SBATCH --cpus-per-task=4\n"));
}

TEST(BatchFarm, AGpuIsAskedForWhereOneIsNamed) {
  const Farm farm("[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n");
  ASSERT_EQ(emit(farm, {"--device", "vulkan"}).status, 0);
  const std::string script = read_text(farm.job() + "/array.sbatch");
  EXPECT_TRUE(contains(script, "#SBATCH --gres=gpu:1\n")) << script;
  EXPECT_TRUE(contains(script, "--device vulkan ")) << script;
}

// Runs the array's script as Slurm would, with replacements for Slurm's programs that record their arguments.
int run_task(const Farm& farm, const std::string& state, const std::string& around) {
  const fs::path programs = farm.home / "programs";
  fs::create_directories(programs);
  write_text(programs / "squeue", "#!/bin/sh\necho " + state + "\n");
  write_text(programs / "scontrol",
             "#!/bin/sh\necho \"$@\" >> " + quoted((farm.home / "asked").string()) + "\n");
  for (const char* name : {"squeue", "scontrol"})
    fs::permissions(programs / name, fs::perms::owner_all, fs::perm_options::add);
  write_text(farm.home / "run", "PATH=" + quoted(programs.string()) +
                                    ":$PATH\nexport PATH SLURM_ARRAY_JOB_ID=7 "
                                    "SLURM_ARRAY_TASK_ID=1 SLURM_JOB_ID=7 FASCICLE_CACHE_DIR=" +
                                    quoted((farm.home / "cache").string()) + "\nbash " +
                                    quoted(farm.job() + "/array.sbatch") + " > " +
                                    quoted((farm.home / "log").string()) + " 2>&1 " + around);
  const int status = std::system(("bash " + quoted((farm.home / "run").string())).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// A list that was emitted anew may have fewer tasks than an array that is still queued.
TEST(BatchFarm, ATaskWithoutJobsBakesNothing) {
  const Farm farm("[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.1\"]\n");
  ASSERT_EQ(emit(farm, {"--threads", "1"}).status, 0);
  write_text(farm.job() + "/tasks", "");
  EXPECT_EQ(run_task(farm, "RUNNING", ""), 1) << read_text(farm.home / "log");
  EXPECT_TRUE(contains(read_text(farm.home / "log"), "emitted anew")) << read_text(farm.home / "log");
  EXPECT_FALSE(fs::exists(farm.output() + "/bar"));
  const Outcome empty = fascicle({"batch", farm.list(), "--job", ""});
  EXPECT_EQ(empty.status, 2);
  EXPECT_TRUE(contains(empty.err, "--job: no job given")) << empty.err;
}

// Slurm's warning goes only to the script's shell, which waits for the bake to end and requeues the task by
// its array name, as its own number may be that of the whole array.
TEST(BatchFarm, ATaskThatIsWarnedIsQueuedAgainAndGoesOn) {
  const Farm farm("[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=300\"]\n");
  ASSERT_EQ(emit(farm, {"--threads", "1"}).status, 0);
  const std::string warn_at_work = "&\nuntil [ -e " + quoted(farm.output() + "/bar/manifest.json") +
                                   " ]; do sleep 0.05; done\n" + "kill -TERM $!; wait $!\n";
  EXPECT_EQ(run_task(farm, "RUNNING", warn_at_work), 0) << read_text(farm.home / "log");
  EXPECT_EQ(read_text(farm.home / "asked"), "requeue 7_1\n");
  const Outcome status = fascicle({"batch", "status", farm.job()});
  EXPECT_EQ(status.status, 75) << status.out;
  EXPECT_TRUE(contains(status.out, "1 interrupted")) << status.out;
  EXPECT_TRUE(contains(status.out, "interrupted at frame ")) << status.out;
  // A task cancelled by its user is not requeued.
  fs::remove(farm.home / "asked");
  fs::remove_all(farm.output() + "/bar");
  EXPECT_EQ(run_task(farm, "COMPLETING", warn_at_work), 75) << read_text(farm.home / "log");
  EXPECT_FALSE(fs::exists(farm.home / "asked"));
  // Undisturbed it finishes, with the same bytes as a separate bake.
  EXPECT_EQ(run_task(farm, "RUNNING", "\n"), 0) << read_text(farm.home / "log");
  ASSERT_EQ(fascicle({"bake", "bar-hang-none", "--set=scene.end=300", "--device", "cpu", "-o",
                      farm.folder / "alone"})
                .status,
            0);
  EXPECT_TRUE(read_text(farm.folder / "alone/frames.fascicle") ==
              read_text(farm.output() + "/bar/frames.fascicle"));
  EXPECT_EQ(fascicle({"batch", "status", farm.job()}).status, 0);
}

TEST(BatchFarm, RecordsOfJobsAreNotWrittenThroughALink) {
  const Farm farm("[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.1\"]\n");
  fs::create_directories(farm.folder / "others");
  fs::create_directories(farm.output());
  fs::create_directory_symlink(farm.folder / "others", farm.output() + "/.outcomes");
  const Outcome outcome = fascicle({"batch", farm.list(), "--job", "1"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "its record cannot be written")) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "symbolic link")) << outcome.err;
  EXPECT_TRUE(fs::is_empty(farm.folder / "others"));
}

TEST(BatchFarm, JobsBesideEachOtherLeaveBatchJsonToTheMerge) {
  const Farm farm;
  const Outcome first = fascicle({"batch", farm.list(), "--job", "bar-0.6"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_FALSE(fs::exists(farm.output() + "/batch.json"));
  EXPECT_FALSE(fs::exists(farm.output() + "/bar-0.4"));
  Outcome status = fascicle({"batch", "status", farm.list()});
  EXPECT_EQ(status.status, 75);
  EXPECT_TRUE(contains(status.out, "4 jobs in ")) << status.out;
  EXPECT_TRUE(contains(status.out, ": 1 done, 3 not begun\n")) << status.out;

  const Outcome others = fascicle({"batch", farm.list(), "--job", "1-2,4", "--at-once", "1"});
  ASSERT_EQ(others.status, 0) << others.err;
  status = fascicle({"batch", "status", farm.list(), "--merge"});
  EXPECT_EQ(status.status, 0) << status.out;
  const FarmJson merged = FarmJson::parse(read_text(farm.output() + "/batch.json")).at("jobs");
  ASSERT_EQ(merged.size(), 4u);
  // The same as from a single batch, except for timings.
  ASSERT_EQ(fascicle({"batch", farm.list(), "-o", farm.folder / "whole"}).status, 0);
  const FarmJson whole = FarmJson::parse(read_text(farm.folder / "whole/batch.json")).at("jobs");
  for (std::size_t k = 0; k < 4; ++k)
    for (const char* key : {"job", "scene", "clip", "set", "format", "status", "exit_status",
                            "last_position_hash", "error", "warnings"})
      EXPECT_EQ(merged.at(k).at(key), whole.at(k).at(key)) << k << key;
  status = fascicle({"batch", "status", farm.output()});
  EXPECT_EQ(status.status, 0) << status.err;
  EXPECT_TRUE(contains(status.out, ": 4 done\n")) << status.out;
}

// The record tells of a failure without a manifest, and that a killed process is gone.
TEST(BatchFarm, StatusTellsWhyAndWhatWasCutOff) {
  const Farm farm(
      "[job.long]\nscene = \"bar-hang-none\"\nset = [\"scene.end=20000\"]\n"
      "[job.used]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\n");
  fs::create_directories(farm.output() + "/used");
  write_text(farm.output() + "/used/metrics.csv", "mine\n");
  EXPECT_EQ(fascicle({"batch", farm.list(), "--job", "used"}).status, 3);
  Program task({"batch", farm.list(), "--job", "long", "--threads", "1"});
  wait_for_file(task, farm.output() + "/long/manifest.json");
  const Outcome running = fascicle({"batch", "status", farm.list()});
  EXPECT_TRUE(contains(running.out, "long  running at frame ")) << running.out;
  EXPECT_TRUE(contains(running.out, "used  failed: ")) << running.out;
  EXPECT_TRUE(contains(running.out, "metrics.csv")) << running.out;
  EXPECT_EQ(running.status, 3);
  const FarmJson record = FarmJson::parse(read_text(farm.output() + "/.outcomes/long.json"));
  EXPECT_TRUE(record.at("exit_status").is_null());
  // While the bake runs, its record stays fresh.
  const fs::path record_file = farm.output() + "/.outcomes/long.json";
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
  fs::last_write_time(record_file, long_ago);
  // The sign is due every 10 s; a minute is for a busy machine.
  const auto late = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (fs::last_write_time(record_file) == long_ago && std::chrono::steady_clock::now() < late)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_GT(fs::last_write_time(record_file), long_ago + std::chrono::minutes(30));
  const std::string process = std::to_string(record.at("process").get<long>());
  const int bake = std::atoi(read_text("/proc/" + process + "/task/" + process + "/children").c_str());
  ASSERT_GT(bake, 0);
  task.send(SIGSTOP);  // so that it does not notice the death of its bake
  EXPECT_EQ(::kill(bake, SIGKILL), 0);
  task.send(SIGKILL);
  task.wait();
  // The kernel terminates a killed process at its convenience and only then frees the folder. A minute is for
  // a busy machine.
  Outcome gone;
  const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  do {
    gone = fascicle({"batch", "status", farm.list()});
  } while (contains(gone.out, "1 running") && std::chrono::steady_clock::now() < patience);
  EXPECT_TRUE(contains(gone.out, "long  cut off at frame ")) << gone.out;
  EXPECT_TRUE(contains(gone.out, "--resume")) << gone.out;
  // A process on another host cannot be checked, so it counts as running for a while.
  std::string text = record.dump();
  const std::string host = record.at("host").dump();
  text.replace(text.find(host), host.size(), "\"another-host\"");
  write_text(record_file, text);
  EXPECT_TRUE(contains(fascicle({"batch", "status", farm.list()}).out, "1 running"));
  const auto becomes_old = [&] {
    fs::last_write_time(record_file, long_ago);
    fs::last_write_time(farm.output() + "/long/manifest.json", long_ago);
  };
  becomes_old();
  EXPECT_TRUE(contains(fascicle({"batch", "status", farm.list()}).out, "1 cut off"));
  // A number of a process of this host that is now another program's, here ours.
  FarmJson reused = record;
  reused["process"] = static_cast<long>(::getpid());
  write_text(record_file, reused.dump());
  EXPECT_TRUE(contains(fascicle({"batch", "status", farm.list()}).out, "1 running"));
  becomes_old();
  EXPECT_TRUE(contains(fascicle({"batch", "status", farm.list()}).out, "1 cut off"));
}

TEST(BatchFarm, RefusesWhatItCannotHandOver) {
  const Farm farm;
  const auto refusal = [&](std::vector<std::string> more, int status, const std::string& says) {
    more.insert(more.begin(), {"batch", farm.list()});
    const Outcome outcome = fascicle(more);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, says)) << outcome.err;
    EXPECT_FALSE(fs::exists(farm.job())) << outcome.err;
  };
  refusal({"--emit", "slurm"}, 2, "-o job");
  refusal({"--emit", "openjd", "-o", farm.job()}, 2, ".yaml");
  refusal({"--emit", "slurm", "-o", farm.job(), "--device", "cpu,vulkan"}, 2, "one device");
  refusal({"--emit", "slurm", "-o", farm.job() + "\nx"}, 2, "control character");
  refusal({"--emit", "slurm", "-o", farm.job(), "--slurm", "--partition=x\nrm -rf"}, 2, "control character");
  refusal({"--emit", "slurm", "-o", farm.job(), "--overwrite"}, 2, "--overwrite");
  refusal({"--emit", "openjd", "-o", farm.job() + ".json", "--submit"}, 2, "--submit");
  refusal({"--group", "2"}, 2, "--emit");
  refusal({"--job", "bar-0.8"}, 2, "did you mean bar-0.4?");
  refusal({"--job", "0"}, 2, "no job \"0\"");
  refusal({"--job", "3-5"}, 2, "among the 4");
  EXPECT_EQ(fascicle({"batch"}).status, 2);
  const Outcome nothing = fascicle({"batch", "status", farm.folder / "."});
  EXPECT_EQ(nothing.status, 3);
  EXPECT_TRUE(contains(nothing.err, "batch.json")) << nothing.err;

  // Without Slurm, it says how to continue.
  const Outcome no_slurm =
      fascicle({"batch", farm.list(), "--emit", "slurm", "-o", farm.job(), "--submit"}, {"PATH=/nowhere"});
  EXPECT_EQ(no_slurm.status, 1);
  EXPECT_TRUE(contains(no_slurm.err, "sbatch")) << no_slurm.err;
  // If Slurm takes the bakes and not the merge, the bakes are cancelled: a second try would bake everything
  // twice.
  const fs::path programs = farm.folder.path() / "slurm";  // dash reads a % in PATH as an option
  fs::create_directories(programs);
  write_text(programs / "sbatch",
             "#!/bin/sh\ncase \"$*\" in *merge.sbatch) echo no >&2; exit 1;; esac\necho 7\n");
  write_text(programs / "scancel",
             "#!/bin/sh\necho \"$@\" >> " + quoted((farm.home / "asked").string()) + "\n");
  for (const char* name : {"sbatch", "scancel"})
    fs::permissions(programs / name, fs::perms::owner_all, fs::perm_options::add);
  const Outcome half = fascicle({"batch", farm.list(), "--emit", "slurm", "-o", farm.job(), "--submit"},
                                {"PATH=" + programs.string() + ":/usr/bin:/bin"});
  EXPECT_EQ(half.status, 1) << half.err;
  EXPECT_EQ(read_text(farm.home / "asked"), "7\n") << half.err;
  EXPECT_FALSE(fs::exists(farm.job() + "/submitted"));
  write_text(farm.job() + "/submitted", "array 7\nmerge 8\n");
  EXPECT_EQ(emit(farm).status, 2);
  EXPECT_EQ(emit(farm, {"--resume"}).status, 0);
  EXPECT_FALSE(fs::exists(farm.job() + "/submitted"));
}

TEST(BatchFarm, ReplacesNoFileThatIsNotItsOwn) {
  const Farm farm;
  fs::create_directory(farm.job());
  for (const char* name : {"tasks", "submit", "submitted", "report.txt", "plan.json"}) {
    SCOPED_TRACE(name);
    write_text(fs::path(farm.job()) / name, "mine");
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--dry-run"}, {"--resume"}}) {
      const Outcome outcome = emit(farm, more);
      EXPECT_EQ(outcome.status, 2) << outcome.err;
      EXPECT_TRUE(contains(outcome.err, std::string("/") + name + ": --emit would replace")) << outcome.err;
    }
    EXPECT_EQ(read_text(fs::path(farm.job()) / name), "mine");
    fs::remove(fs::path(farm.job()) / name);
  }
  // Other files may stay, and its own are written again.
  write_text(farm.job() + "/notes.txt", "mine");
  EXPECT_EQ(emit(farm).status, 0);
  write_text(farm.job() + "/report.txt", "of status --merge");
  EXPECT_EQ(emit(farm).status, 0);
  EXPECT_FALSE(fs::exists(farm.job() + "/report.txt"));
  EXPECT_EQ(read_text(farm.job() + "/notes.txt"), "mine");
}

// plan.json and templates are UTF-8, so tasks and status would look in another folder.
TEST(BatchFarm, RefusesPathsThatAreNotUtf8) {
  const Farm farm;
  const std::string home = farm.folder / "caf\xe9";
  fs::create_directory(home);
  write_text(home + "/jobs.toml", four_bars);
  const auto expect_refusal = [](const std::string& list, const std::string& format, const std::string& to) {
    const Outcome outcome = fascicle({"batch", list, "--emit", format, "-o", to});
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "caf\\xe9")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "not UTF-8")) << outcome.err;
    EXPECT_FALSE(fs::exists(to)) << to;
  };
  for (const char* format : {"slurm", "openjd"}) {
    const std::string name = format == std::string("slurm") ? "/job" : "/template.json";
    expect_refusal(home + "/jobs.toml", format, farm.home.string() + name);
    expect_refusal(farm.list(), format, home + name);
  }
}

TEST(BatchFarm, ADryRunWritesNothing) {
  const Farm farm(bars_and_bears);
  const Outcome outcome = emit(farm, {"--dry-run"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "nothing is written")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "3, of at most 2 jobs")) << outcome.out;
  EXPECT_FALSE(fs::exists(farm.job()));
  EXPECT_FALSE(fs::exists(farm.output()));
}

}  // namespace
}  // namespace fascicle::tests
