// fascicle batch status: what it makes of the files in a folder, whoever wrote them, and what --merge
// replaces.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using StatusJson = nlohmann::json;
namespace fs = std::filesystem;

const std::string one_short_bar =
    "[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\"]\nformat = [\"pc2\"]\n";

// A list, the folder `out` of its bakes and the folder `job` of its plan.
struct ListedBar {
  ListedBar() { write_list(one_short_bar); }
  void write_list(const std::string& jobs) const {
    write_text(list(), "output = \"" + output() + "\"\n" + jobs);
  }
  void write_plan(const std::string& name, const std::string& output_of_plan) const {
    const StatusJson none = StatusJson::array();
    const StatusJson row{{"job", name},
                         {"scene", "bar-hang-none"},
                         {"clip", ""},
                         {"set", {"scene.end=0.2"}},
                         {"format", {"pc2"}}};
    fs::create_directories(job());
    write_text(
        job() + "/plan.json",
        StatusJson{{"list", list()}, {"output", output_of_plan}, {"jobs", StatusJson::array({row})}}.dump());
  }
  void write_summary(const std::string& name, const StatusJson& exit_status) const {
    const StatusJson none = StatusJson::array();
    const StatusJson row{{"job", name},    {"scene", "arm"},   {"clip", ""},
                         {"set", none},    {"format", none},   {"device", "cpu"},
                         {"error", "bad"}, {"warnings", none}, {"exit_status", exit_status}};
    fs::create_directories(output());
    write_text(summary(), StatusJson{{"jobs", StatusJson::array({row})}}.dump());
  }
  static void write_record(const std::string& output, const StatusJson& exit_status) {
    fs::create_directories(output + "/.outcomes");
    write_text(output + "/.outcomes/bar.json", StatusJson{{"host", "node7"},
                                                          {"process", 42},
                                                          {"device", "cpu"},
                                                          {"exit_status", exit_status},
                                                          {"error", ""},
                                                          {"warnings", StatusJson::array()}}
                                                   .dump());
  }
  std::string list() const { return folder / "jobs.toml"; }
  std::string output() const { return folder / "out"; }
  std::string summary() const { return folder / "out/batch.json"; }
  std::string job() const { return folder / "job"; }

  TemporaryFolder folder;
};

Outcome status_of(const std::string& batch, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"batch", "status", batch};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return fascicle(arguments);
}

// The bake that was refused leaves the manifest of the earlier one as it is.
TEST(BatchStatus, ARefusalAfterABakeStaysAFailure) {
  const ListedBar bar;
  ASSERT_EQ(fascicle({"batch", bar.list()}).status, 0);
  bar.write_list(
      "[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=0.2\", \"scene.fps=30\"]\nformat = "
      "[\"pc2\"]\n");
  const Outcome refused = fascicle({"batch", bar.list(), "--resume"});
  ASSERT_EQ(refused.status, 3) << refused.err;
  const auto expect_failure = [&](const std::string& batch, const std::vector<std::string>& more) {
    const Outcome outcome = status_of(batch, more);
    EXPECT_EQ(outcome.status, 3) << batch << outcome.out << outcome.err;
    EXPECT_TRUE(contains(outcome.out, ": 1 failed\n")) << batch << outcome.out;
    EXPECT_TRUE(contains(outcome.out, "bar  failed: ")) << batch << outcome.out;
  };
  expect_failure(bar.output(), {});
  expect_failure(bar.list(), {});
  expect_failure(bar.output(), {"--merge"});
  const StatusJson row = StatusJson::parse(read_text(bar.summary())).at("jobs").at(0);
  EXPECT_EQ(row.at("status"), "failed");
  EXPECT_EQ(row.at("exit_status"), 3);
  EXPECT_NE(row.at("error"), "");
  expect_failure(bar.list(), {"--merge"});
  expect_failure(bar.output(), {});

  // What is newer than batch.json counts more: a bake alone, and a process for this job.
  const Outcome alone = fascicle({"bake", "bar-hang-none", "--set=scene.end=0.2", "--format=pc2", "--device",
                                  "cpu", "--overwrite", "-o", bar.output() + "/bar"});
  ASSERT_EQ(alone.status, 0) << alone.err;
  EXPECT_EQ(status_of(bar.output()).status, 0);
  ASSERT_EQ(fascicle({"batch", bar.list(), "--job", "bar", "--resume"}).status, 3);
  expect_failure(bar.output(), {});
  bar.write_list(one_short_bar);
  ASSERT_EQ(fascicle({"batch", bar.list(), "--resume"}).status, 0);
  const Outcome done = status_of(bar.output());
  EXPECT_EQ(done.status, 0) << done.out;
  EXPECT_TRUE(contains(done.out, ": 1 done\n")) << done.out;
}

TEST(BatchStatus, ABakeWhoseFolderIsGoneIsNotDone) {
  const ListedBar bar;
  ASSERT_EQ(fascicle({"batch", bar.list()}).status, 0);
  fs::remove_all(bar.output() + "/bar");
  for (const std::string& batch : {bar.list(), bar.output()}) {
    const Outcome outcome = status_of(batch);
    EXPECT_EQ(outcome.status, 75) << outcome.out;
    EXPECT_TRUE(contains(outcome.out, "bar  not begun")) << outcome.out;
  }
}

TEST(BatchStatus, AJobWhoseFolderIsGoneIsNotDone) {
  const ListedBar bar;
  ASSERT_EQ(fascicle({"batch", bar.list(), "--job", "bar"}).status, 0);
  EXPECT_EQ(status_of(bar.list()).status, 0);
  fs::remove_all(bar.output() + "/bar");
  const auto expect_not_begun = [&] {
    const Outcome outcome = status_of(bar.list());
    EXPECT_EQ(outcome.status, 75) << outcome.out;
    EXPECT_TRUE(contains(outcome.out, "bar  not begun")) << outcome.out;
  };
  expect_not_begun();
  // A failure that is older than the record says nothing either.
  bar.write_summary("bar", 1);
  ListedBar::write_record(bar.output(), 0);
  expect_not_begun();
}

TEST(BatchStatus, ExitsAsTheFirstFailureDid) {
  const ListedBar bar;
  ASSERT_EQ(fascicle({"batch", bar.list(), "--job", "bar"}).status, 0);
  for (const auto& [exit_status, wanted] :
       std::vector<std::pair<int, int>>{{0, 0}, {75, 75}, {1, 1}, {5, 5}, {6, 6}, {7, 7}, {8, 1}, {137, 1}}) {
    ListedBar::write_record(bar.output(), exit_status);
    const Outcome outcome = status_of(bar.list());
    EXPECT_EQ(outcome.status, wanted) << exit_status << outcome.out;
  }
}

// A name from a file becomes a path: it must not lead out of the folder.
TEST(BatchStatus, TakesOnlyNamesThatAListCanMake) {
  const ListedBar bar;
  const auto expect_refusal = [](const Outcome& outcome, const std::string& name, const std::string& file) {
    EXPECT_EQ(outcome.status, 3) << name << outcome.out;
    EXPECT_TRUE(contains(outcome.err, file + ": is damaged")) << name << outcome.err;
  };
  for (const std::string& name :
       {std::string("../../secret/bake"), bar.folder / "secret", std::string(".."), std::string(".outcomes"),
        std::string("a/b"), std::string(), std::string("a b"), std::string("a\x1b"),
        std::string("batch.json"), std::string(201, 'a')}) {
    bar.write_plan(name, bar.output());
    expect_refusal(status_of(bar.job()), name, "plan.json");
    bar.write_summary(name, 0);
    expect_refusal(status_of(bar.output()), name, "batch.json");
  }
  const std::string honest = "Bar-walk_2-0.5";
  bar.write_plan(honest, bar.output());
  bar.write_summary(honest, 5);
  for (const std::string& batch : {bar.job(), bar.output()}) {
    const Outcome outcome = status_of(batch);
    EXPECT_EQ(outcome.status, 5) << outcome.err;
    EXPECT_TRUE(contains(outcome.out, honest + "  failed: bad")) << outcome.out;
  }
}

TEST(BatchStatus, TakesOnlyExitStatusesThatAProcessHas) {
  const ListedBar bar;
  for (const StatusJson& value : {StatusJson(-1), StatusJson(-256), StatusJson(256),
                                  StatusJson(std::int64_t{1} << 32), StatusJson(~std::uint64_t{0}),
                                  StatusJson(0.5), StatusJson(1e300), StatusJson(true), StatusJson("0")}) {
    bar.write_summary("bar", value);
    const Outcome outcome = status_of(bar.output());
    EXPECT_EQ(outcome.status, 3) << value << outcome.out;
    EXPECT_TRUE(contains(outcome.err, "batch.json: is damaged: the exit status of bar")) << outcome.err;
  }
  fs::remove(bar.summary());
  for (const StatusJson& value : {StatusJson(-256), StatusJson(std::int64_t{1} << 32), StatusJson(0.5)}) {
    ListedBar::write_record(bar.output(), value);
    const Outcome outcome = status_of(bar.list());
    EXPECT_EQ(outcome.status, 75) << value << outcome.out;
    EXPECT_TRUE(contains(outcome.out, "bar  not begun")) << outcome.out;
    EXPECT_TRUE(contains(outcome.err, ".outcomes/bar.json: is damaged")) << outcome.err;
  }
  for (const int value : {75, 255}) {
    bar.write_summary("bar", value);
    fs::remove_all(bar.output() + "/.outcomes");
    EXPECT_EQ(status_of(bar.output()).status, value == 75 ? 75 : 1) << value;
  }
}

// The list was changed after the bake. Of both kinds of batch: with batch.json, and with records to merge.
TEST(BatchStatus, ABakeOfOtherSettingsIsNotDone) {
  for (const bool is_part : {false, true}) {
    const ListedBar bar;
    const auto list = [&](const std::string& end) {
      bar.write_list("[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=" + end + "\"]\n");
    };
    list("0.1");
    std::vector<std::string> words{"batch", bar.list()};
    if (is_part) words.insert(words.end(), {"--job", "bar"});
    ASSERT_EQ(fascicle(words).status, 0);
    EXPECT_TRUE(contains(status_of(bar.list()).out, "bar  done"));
    list("0.2");
    const Outcome other = status_of(bar.list(), {"--merge"});
    EXPECT_EQ(other.status, 75) << other.out;
    EXPECT_TRUE(contains(other.out, "bar  not begun: its folder holds a bake of other settings"))
        << other.out;
    const StatusJson row = StatusJson::parse(read_text(bar.summary())).at("jobs").at(0);
    EXPECT_EQ(row.at("status"), "not begun");
    EXPECT_EQ(row.at("last_position_hash"), "");
    EXPECT_EQ(status_of(bar.list()).out, other.out) << "the merge has not made it one of these settings";
    list("0.1");
    EXPECT_TRUE(contains(status_of(bar.list()).out, "bar  done"));
    list("0.2");
    words.push_back("--overwrite");
    ASSERT_EQ(fascicle(words).status, 0);
    EXPECT_TRUE(contains(status_of(bar.list()).out, "bar  done"));
  }
}

// A run that is ended before it begins a job does not make that job's older bake one of the new settings.
TEST(BatchStatus, WhatARunHasNotBegunStaysWhatItWas) {
  const ListedBar bar;
  const auto list = [&](const std::string& end_of_first, const std::string& end) {
    bar.write_list("[job.first]\nscene = \"bar-hang-none\"\nset = [\"scene.end=" + end_of_first +
                   "\"]\n[job.bar]\nscene = \"bar-hang-none\"\nset = [\"scene.end=" + end + "\"]\n");
  };
  list("0.1", "0.1");
  ASSERT_EQ(fascicle({"batch", bar.list()}).status, 0);
  list("20000", "0.2");
  Program run({"batch", bar.list(), "--overwrite", "--at-once", "1", "--device", "cpu"});
  wait_until(run, [&] {
    const std::string manifest = bar.output() + "/first/manifest.json";
    return fs::exists(manifest) && contains(read_text(manifest), "1200000");
  });
  run.send(SIGTERM);
  EXPECT_EQ(run.wait().status, 75);
  const Outcome after = status_of(bar.list());
  EXPECT_TRUE(contains(after.out, "bar    not begun: its folder holds a bake of other settings"))
      << after.out;
}

// Folders may be all that tells two versions of a scene apart.
TEST(BatchStatus, ASceneOfAnotherFolderIsAnotherScene) {
  const ListedBar bar;
  for (const char* version : {"v1", "v2"}) {
    fs::create_directories(bar.folder / version);
    write_text(bar.folder / version + "/bar.toml", "[bar]\n[layers.body]\nalpha = 0.5\n[scene]\nend = 0.1\n");
  }
  bar.write_list("[job.bar]\nscene = \"v1/bar.toml\"\n");
  ASSERT_EQ(fascicle({"batch", bar.list()}).status, 0);
  EXPECT_TRUE(contains(status_of(bar.list()).out, "bar  done"));
  bar.write_list("[job.bar]\nscene = \"v2/bar.toml\"\n");
  EXPECT_TRUE(
      contains(status_of(bar.list()).out, "bar  not begun: its folder holds a bake of other settings"));
}

TEST(BatchStatus, OnlyABatchOfOursIsReplaced) {
  const ListedBar bar;
  fs::create_directories(bar.output());
  for (const std::string foreign : {"{\"mine\": 1}\n", "{\"jobs\": []}\n", "mine\n"}) {
    write_text(bar.summary(), foreign);
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"batch", bar.list()},
                                                      {"batch", bar.list(), "--resume"},
                                                      {"batch", "status", bar.list(), "--merge"}}) {
      const Outcome outcome = fascicle(arguments);
      EXPECT_EQ(outcome.status, 3) << outcome.err;
      EXPECT_TRUE(contains(outcome.err, "batch.json: would be replaced, but ")) << outcome.err;
      EXPECT_EQ(read_text(bar.summary()), foreign);
      EXPECT_FALSE(fs::exists(bar.output() + "/bar")) << outcome.err;
    }
  }
  // One process for a part of the batch does not write it.
  EXPECT_EQ(fascicle({"batch", bar.list(), "--job", "bar"}).status, 0);
  EXPECT_EQ(read_text(bar.summary()), "mine\n");
  ASSERT_EQ(fascicle({"batch", bar.list(), "--overwrite"}).status, 0);
  EXPECT_EQ(StatusJson::parse(read_text(bar.summary())).at("jobs").at(0).at("status"), "done");
  EXPECT_EQ(fascicle({"batch", bar.list(), "--resume"}).status, 0);
}

// A plan from a stranger may name the folder of another batch.
TEST(BatchStatus, APlanIsMergedOnlyWhereItsJobsHaveBegun) {
  const ListedBar bar;
  ASSERT_EQ(fascicle({"batch", bar.list()}).status, 0);
  const std::string before = read_text(bar.summary());
  bar.write_plan("bar", bar.output());
  const Outcome refused = status_of(bar.job(), {"--merge"});
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_TRUE(contains(refused.err, "plan.json: none of its jobs has begun in ")) << refused.err;
  EXPECT_TRUE(contains(refused.err, "--output")) << refused.err;
  EXPECT_EQ(read_text(bar.summary()), before);
  EXPECT_FALSE(fs::exists(bar.job() + "/report.txt"));
  bar.write_plan("bar", bar.folder / "nowhere");
  EXPECT_EQ(status_of(bar.job(), {"--merge"}).status, 2);
  EXPECT_FALSE(fs::exists(bar.folder / "nowhere"));

  const Outcome named = status_of(bar.job(), {"--merge", "--output", bar.output()});
  EXPECT_EQ(named.status, 0) << named.err;
  EXPECT_TRUE(fs::exists(bar.job() + "/report.txt"));
}

TEST(BatchStatus, APlanOfOursIsMergedAfterItsTasks) {
  const ListedBar bar;
  const Outcome emitted = fascicle({"batch", bar.list(), "--emit", "slurm", "-o", bar.job()});
  ASSERT_EQ(emitted.status, 0) << emitted.err;
  ASSERT_EQ(fascicle({"batch", bar.list(), "--job", "bar", "--output", bar.output()}).status, 0);
  const Outcome merged = status_of(bar.job(), {"--merge"});
  EXPECT_EQ(merged.status, 0) << merged.err;
  EXPECT_TRUE(fs::exists(bar.summary()));
  EXPECT_TRUE(contains(read_text(bar.job() + "/report.txt"), ": 1 done\n"));
}

TEST(BatchStatus, ReportsShowTheFolderEscaped) {
  const ListedBar bar;
  const std::string output = bar.folder / "a\x1b[31m\nb";
  ListedBar::write_record(output, 75);
  bar.write_plan("bar", output);
  const Outcome merged = status_of(bar.job(), {"--merge"});
  EXPECT_EQ(merged.status, 75) << merged.err;
  const std::string report = read_text(bar.job() + "/report.txt");
  EXPECT_TRUE(contains(report, "a\\x1b[31m\\nb: 1 interrupted\n")) << report;
  EXPECT_EQ(std::count(report.begin(), report.end(), '\n'), 2) << report;
}

}  // namespace
}  // namespace fascicle::tests
