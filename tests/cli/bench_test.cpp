// fascicle bench as a user runs it, and how two of its results are compared. Times are not judged here.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cpu_reference/solver/simd.h"
#include "host/bake/bake.h"
#include "host/cli/bench_measure.h"
#include "host/cli/bench_results.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

TEST(Bench, WritesEveryRowOnceWithItsNumbers) {
  const TemporaryFolder folder;
  const Outcome outcome =
      fascicle({"bench", "--quick", "--vertices", "300", "--rounds", "2", "--threads", "1,2", "--devices",
                "cpu,cpu:scalar", "--no-peers", "--json", folder / "a.json", "--csv", folder / "a.csv"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json results = json::parse(read_text(folder / "a.json"));
  EXPECT_FALSE(results.at("machine").at("processor").get<std::string>().empty());
  EXPECT_EQ(results.at("machine").at("levels").size(), cpu_reference::available_simd().size());
  for (const char* threads : {"1", "2"}) EXPECT_GT(results.at("triad_gb_s").at(threads).get<double>(), 0.0);
  // Two devices, two integrators, two numbers of threads.
  ASSERT_EQ(results.at("results").size(), 8u);
  for (const json& row : results.at("results")) {
    EXPECT_EQ(row.at("solver"), "cpu");
    EXPECT_EQ(row.at("samples").size(), 2u);
    EXPECT_GT(row.at("ns_per_vertex_substep").get<double>(), 0.0);
    EXPECT_LE(row.at("ns_least").get<double>(), row.at("ns_per_vertex_substep").get<double>());
    EXPECT_EQ(row.at("passes"), row.at("integrator") == "implicit" ? 20 : 1);
    EXPECT_GE(row.at("peak_bytes_per_vertex").get<double>(), 0.0);
    EXPECT_EQ(row.at("bytes_per_vertex_substep").is_null(), row.at("device") == "cpu:scalar");
    EXPECT_EQ(row.at("triad_fraction").is_null(), row.at("device") == "cpu:scalar");
  }
  std::istringstream csv(read_text(folder / "a.csv"));
  int lines = 0;
  for (std::string line; std::getline(csv, line); ++lines)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 11);
  EXPECT_EQ(lines, 9);

  const Outcome again = fascicle({"bench", "--quick", "--vertices", "300", "--rounds", "1", "--threads", "1",
                                  "--integrator", "explicit", "--no-peers", "--against", folder / "a.json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(contains(again.out, "cpu, explicit, ")) << again.out;
  EXPECT_TRUE(contains(again.out, ", 1 thread: median x ")) << again.out;
}

// A symbolic link at the result's path is replaced; its target is unchanged.
TEST(Bench, WritesThroughNoLink) {
  const TemporaryFolder folder;
  std::ofstream(folder / "kept") << "kept";
  std::filesystem::create_symlink(folder / "kept", folder / "a.json");
  const Outcome outcome =
      fascicle({"bench", "--vertices", "300", "--rounds", "1", "--threads", "1", "--devices", "cpu",
                "--integrator", "explicit", "--no-peers", "--json", folder / "a.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_text(folder / "kept"), "kept");
  EXPECT_FALSE(std::filesystem::is_symlink(std::filesystem::path(folder / "a.json")));
  EXPECT_TRUE(json::accept(read_text(folder / "a.json")));
}

// The same bar filled by the mesher has its own row in a comparison.
TEST(Bench, TimesAFilledBarTooAndTellsItFromARegularOne) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.json";
  const Outcome outcome =
      fascicle({"bench", "--vertices", "600", "--meshes", "regular,filled", "--rounds", "1", "--threads", "1",
                "--integrator", "explicit", "--no-peers", "--json", file});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json rows = json::parse(read_text(file)).at("results");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].at("mesh"), "regular");
  EXPECT_EQ(rows[1].at("mesh"), "filled");
  EXPECT_NEAR(rows[1].at("vertices").get<double>(), 600.0,
              300.0);  // only a target, which the mesher meets roughly
  EXPECT_NE(rows[0].at("vertices"), rows[1].at("vertices"));
  const Outcome again =
      fascicle({"bench", "--vertices", "600", "--meshes", "filled", "--rounds", "1", "--threads", "1",
                "--integrator", "explicit", "--no-peers", "--against", file});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(contains(again.out, "cpu, explicit, filled, ")) << again.out;
  EXPECT_EQ(fascicle({"bench", "--meshes", "round"}).status, 2);
}

// For a Vulkan device, copies, bytes and stages are listed with the times.
TEST(Bench, CountsAVulkanDevicesBytesAgainstItsCopies) {
  NEEDS_VULKAN();
  const TemporaryFolder folder;
  const std::string file = folder / "a.json";
  const Outcome outcome = fascicle({"bench", "--quick", "--vertices", "300", "--rounds", "1", "--threads",
                                    "1", "--devices", "vulkan", "--no-peers", "--json", file});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json results = json::parse(read_text(file));
  for (const json& row : results.at("results")) {
    const std::string device = row.at("device");
    EXPECT_EQ(row.at("solver"), "vulkan");
    EXPECT_FALSE(results.at("machine").at("gpus").at(device).get<std::string>().empty());
    // By definition; the file's numbers are not rounded.
    EXPECT_DOUBLE_EQ(row.at("triad_fraction").get<double>(),
                     row.at("bytes_per_vertex_substep").get<double>() /
                         row.at("ns_per_vertex_substep").get<double>() /
                         results.at("copy_gb_s").at(device).get<double>());
    std::vector<std::string> stages;
    for (const auto& [stage, time] : row.at("ns_by_stage").items()) {
      stages.push_back(stage);
      EXPECT_GT(time.get<double>(), 0.0) << stage;
    }
    using Names = std::vector<std::string>;
    EXPECT_EQ(stages, row.at("integrator") == "explicit"
                          ? Names({"region", "update"})
                          : Names({"integrate", "iterate", "predict", "region"}));
  }
}

TEST(Bench, BadUsageIsToldApart) {
  const TemporaryFolder folder;
  EXPECT_EQ(fascicle({"bench", "--against", folder / "none.json"}).status, 3);
  write_text(folder / "other.json", "{\"results\": 3}");
  EXPECT_EQ(fascicle({"bench", "--against", folder / "other.json"}).status, 3);
  EXPECT_EQ(fascicle({"bench", "--devices", "cpu:mmx"}).status, 2);
  EXPECT_EQ(fascicle({"bench", "--integrator", "euler"}).status, 2);
}

cli::BenchResults results_of(std::vector<double> samples) {
  cli::BenchRow row;
  row.solver = row.device = "cpu";
  row.integrator = "explicit";
  row.vertices = 19456;
  row.samples = std::move(samples);
  cli::BenchResults results;
  results.rows.push_back(row);
  return results;
}

TEST(Bench, OnlyWhatMovedAsAWholeIsCalledSlower) {
  const TemporaryFolder folder;
  write_bench_json(folder / "before.json", results_of({100, 110, 120}));
  const auto before = cli::read_bench_json(folder / "before.json");
  EXPECT_EQ(compare_bench(results_of({112, 125, 140}), before).slower, 1u);
  EXPECT_TRUE(contains(compare_bench(results_of({112, 125, 140}), before).text, "SLOWER"));
  // The median of a disturbed run, or its best sample, proves nothing by itself.
  EXPECT_EQ(compare_bench(results_of({100, 180, 190}), before).slower, 0u);
  EXPECT_EQ(compare_bench(results_of({115, 116, 117}), before).slower, 0u);
  EXPECT_TRUE(contains(compare_bench(results_of({80, 81, 82}), before).text, "faster"));
  cli::BenchResults other = results_of({500});
  other.rows[0].threads = 2;
  EXPECT_EQ(compare_bench(other, before).text, "");
}

TEST(Bench, MedianIsTheMiddleOrBetweenTheTwoOfIt) {
  EXPECT_EQ(results_of({3, 1, 2}).rows[0].median(), 2.0);
  EXPECT_EQ(results_of({4, 1, 2, 3}).rows[0].median(), 2.5);
  EXPECT_EQ(results_of({3, 1, 2}).rows[0].least(), 1.0);
}

TEST(Bench, TheBarHasAboutTheVerticesAskedFor) {
  for (const std::uint32_t vertices : {300U, 5000U, 19000U}) {
    const cli::BenchBody body = cli::bench_body(vertices, model::Integrator::explicit_step);
    EXPECT_EQ(body.grid[0] * body.grid[1] * body.grid[2], body.model.vertex_count);
    // From k = 3 on, neighbouring sizes (k+1)^2 (5k+1) are within a factor of 1.75.
    EXPECT_NEAR(static_cast<double>(body.model.vertex_count) / vertices, 1.0, 0.4);
  }
}

}  // namespace
}  // namespace fascicle::tests
