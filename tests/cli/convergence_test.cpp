// fascicle validate --converged measures the distance between two bakes.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

constexpr std::size_t pc2_header = 32;

// Positions of all frames except frame 0, from surface.pc2.
std::vector<float> positions_of(const std::string& scene, const std::vector<std::string>& options) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments{"bake",     scene, "-o",       folder / "bake",
                                     "--format", "pc2", "--device", "cpu"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome outcome = fascicle(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const std::string bytes = read_text(folder / "bake/surface.pc2");
  std::int32_t vertices = 0;
  std::memcpy(&vertices, bytes.data() + 16, sizeof vertices);
  const std::size_t first = pc2_header + 12 * static_cast<std::size_t>(vertices);
  EXPECT_GT(bytes.size(), first);
  std::vector<float> positions((bytes.size() - first) / sizeof(float));
  std::memcpy(positions.data(), bytes.data() + first, bytes.size() - first);
  return positions;
}

double rms_distance(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  double squares = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) squares += std::pow(double{a[k]} - double{b[k]}, 2);
  return std::sqrt(squares / (static_cast<double>(a.size()) / 3.0));
}

json measured(const std::string& scene, std::vector<std::string> options) {
  std::vector<std::string> arguments{"validate", scene, "--converged", "--json", "--devices", "cpu"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome outcome = fascicle(arguments);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return json::parse(outcome.out);
}

TEST(Convergence, IsTheDistanceOfTwoBakes) {
  const std::string scene = "squeeze";
  const json result = measured(scene, {"--end=0.05"});
  ASSERT_EQ(result.at("qualities").size(), 3u) << result.dump();
  const auto bake = [&](const std::string& substeps, const std::string& iterations) {
    return positions_of(
        scene, {"--end=0.05", "--set=solver.substeps=" + substeps, "--set=solver.iterations=" + iterations});
  };
  const auto steps = [](const json& of, const char* key) { return std::to_string(of.at(key).get<int>()); };
  const json& reference = result.at("reference");
  const std::vector<float> exact = bake(steps(reference, "substeps"), steps(reference, "iterations"));
  for (const json& quality : result.at("qualities")) {
    const double rms = quality.at("rms_m").get<double>();
    // Positions in the file are floats in metres, about 0.1 m and so rounded at 4e-9 m; final is 1e-6 m away.
    EXPECT_NEAR(rms_distance(bake(steps(quality, "substeps"), steps(quality, "iterations")), exact) / rms,
                1.0, 1e-2)
        << quality.dump();
    EXPECT_GE(quality.at("largest_m").get<double>(), rms);
  }
}

TEST(Convergence, FinerQualitiesAreNearerAndTheScenesOwnIsMarked) {
  const std::vector<std::string> options{"--frames", "6"};
  const json result = measured("rod-cantilever", options);
  double last = 1.0;
  int scenes = 0;
  for (const json& quality : result.at("qualities")) {
    EXPECT_LT(quality.at("rms_m").get<double>(), last) << quality.dump();
    last = quality.at("rms_m").get<double>();
    scenes += quality.at("is_the_scenes").get<bool>() ? 1 : 0;
  }
  EXPECT_GT(last, 0.0) << "nothing was compared";
  EXPECT_EQ(scenes, 1);
  EXPECT_EQ(result.at("frames"), 6);

  // A scene with its own substeps gets its own line.
  const json stated =
      measured("rod-cantilever", {"--frames", "2", "--set=solver.substeps=2", "--set=solver.iterations=4"});
  ASSERT_EQ(stated.at("qualities").size(), 4u);
  EXPECT_EQ(stated.at("qualities").at(0).at("quality"), "as stated");
  EXPECT_TRUE(stated.at("qualities").at(0).at("is_the_scenes").get<bool>());
}

TEST(Convergence, IsRefusedWhereSubstepsAreAPartOfTheStiffness) {
  const Outcome outcome =
      fascicle({"validate", "bar-beta-1", "--converged", "--devices", "cpu", "--frames", "2"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(contains(outcome.err, "explicit integrator")) << outcome.err;
}

}  // namespace
}  // namespace fascicle::tests
