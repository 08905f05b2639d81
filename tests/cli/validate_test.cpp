// fascicle validate and fascicle inspect as a user runs them.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <variant>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cpu_reference/solver/simd.h"
#include "host/scene/scene.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

TEST(Validate, CpuAndVulkanAreIdentical) {
  NEEDS_VULKAN();
  const Outcome text = fascicle({"validate", "bar-hang-along", "--devices", "cpu,vulkan", "--frames", "4"});
  EXPECT_EQ(text.status, 0) << text.out << text.err;
  EXPECT_TRUE(contains(text.out, "identical")) << text.out;
  EXPECT_TRUE(contains(text.out, "the oracle: within the bound over 4 frames")) << text.out;

  const Outcome outcome = fascicle(
      {"validate", "bar-hang-along", "--devices", "cpu,vulkan", "--frames", "4", "--json", "--no-oracle"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const json result = json::parse(outcome.out);
  EXPECT_TRUE(result.at("holds").get<bool>());
  EXPECT_TRUE(result.at("oracle").empty());
  const json& comparison = result.at("comparisons").at(0);
  EXPECT_TRUE(comparison.at("identical").get<bool>());
  EXPECT_TRUE(comparison.at("first_difference").is_null());
  EXPECT_EQ(comparison.at("unprobed").at("frames"), 4);
  EXPECT_EQ(comparison.at("unprobed").at("last_hash_a"), comparison.at("unprobed").at("last_hash_b"));
  // A bar has no skeleton: each substep has 3 floats per vertex for predict, 16 for region, 3 for goal and 6
  // for integrate; embed adds some once a frame.
  const auto vertices = result.at("vertices").get<std::uint64_t>();
  const auto steps = 4 * result.at("substeps").get<std::uint64_t>();
  EXPECT_GE(comparison.at("values_compared").get<std::uint64_t>(), vertices * steps * (3 + 16 + 3 + 6));
}

// Needs no Vulkan: compares the float solver with the oracle, and with itself with another number of threads.
TEST(Validate, CpuKeepsToTheOracle) {
  const Outcome outcome =
      fascicle({"validate", "bar-hang-across", "--devices", "cpu,cpu", "--frames", "6", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  const json result = json::parse(outcome.out);
  ASSERT_EQ(result.at("oracle").size(), 2u);
  const json& oracle = result.at("oracle").at(0);
  EXPECT_TRUE(oracle.at("holds").get<bool>());
  EXPECT_GT(oracle.at("largest_m").get<double>(), 0.0)
      << "a float solver rounds, so a distance of zero means that nothing was compared";
  EXPECT_GE(oracle.at("largest_m").get<double>(), oracle.at("rms_m").get<double>());
  EXPECT_LE(oracle.at("relative").get<double>(), oracle.at("bound").get<double>());
}

TEST(Inspect, SaysWhatIsThere) {
  const TemporaryFolder folder;
  const Outcome outcome = fascicle({"inspect", "bar-layers-iii", "--json", "--model", folder / "model.vtu"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json result = json::parse(outcome.out);
  const scene::Bar bar = std::get<scene::Bar>(scene::load_scene("bar-layers-iii").geometry);
  const auto [nx, ny, nz] = bar.vertices;
  const std::uint32_t vertices = nx * ny * nz, tetrahedra = 6 * (nx - 1) * (ny - 1) * (nz - 1);
  EXPECT_EQ(result.at("vertices"), vertices);
  EXPECT_EQ(result.at("tetrahedra"), tetrahedra);
  // Sums of about 10,000 doubles: 1e-9 is far above their rounding error.
  EXPECT_NEAR(result.at("volume_m3").get<double>() / bar.size.prod(), 1.0, 1e-9);
  double share = 0.0;
  for (const json& layer : result.at("layers")) share += layer.at("volume_share").get<double>();
  EXPECT_NEAR(share, 1.0, 1e-9);
  EXPECT_EQ(result.at("pinned_vertices"), ny * nz);
  EXPECT_GT(result.at("solver_bytes").get<std::uint64_t>(), 0u);

  const std::string model = read_text(folder / "model.vtu");
  EXPECT_TRUE(contains(model, "NumberOfPoints=\"" + std::to_string(vertices) + "\" NumberOfCells=\"" +
                                  std::to_string(tetrahedra) + "\""));
  for (const char* name : {"layer", "alpha", "beta", "fibre", "mass", "source_vertex", "kinematic"})
    EXPECT_TRUE(contains(model, "Name=\"" + std::string(name) + "\"")) << name;
  EXPECT_TRUE(model.ends_with("</VTKFile>\n"));

  const Outcome text = fascicle({"inspect", "bar-layers-iii"});
  EXPECT_EQ(text.status, 0);
  for (const char* part :
       {"vertices", "tetrahedra", "volume", "muscle", "fat", "edges", "working unit", "tip"})
    EXPECT_TRUE(contains(text.out, part)) << part;
}

// A bare name is a file in the current folder.
TEST(Inspect, ModelByItsNameAlone) {
  const TemporaryFolder folder;
  const std::string command = "cd '" + folder.path().string() +
                              "' && '" FASCICLE_PROGRAM "' inspect bar-hang-none -q --model model.vtu > out";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(read_text(folder / "model.vtu").ends_with("</VTKFile>\n"));
}

TEST(Inspect, ModelInAFolderThatIsNotThereLeavesNothing) {
  const TemporaryFolder folder;
  const Outcome outcome = fascicle({"inspect", "bar-hang-none", "--model", folder / "no/such/model.vtu"});
  EXPECT_EQ(outcome.status, 3) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(contains(outcome.err, "model.vtu")) << outcome.err;
}

// Every SIMD level of the machine, compared with the scalar stages.
TEST(Validate, LevelsOfInstructionsAreIdentical) {
  std::string devices;
  for (const cpu_reference::Simd level : cpu_reference::available_simd())
    devices += (devices.empty() ? "cpu:" : ",cpu:") + std::string(name_of(level));
  for (const char* scene : {"bar-layers-iii", "rod-hang"}) {
    const Outcome outcome =
        fascicle({"validate", scene, "--devices", devices, "--frames", "2", "--no-oracle"});
    EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
    EXPECT_TRUE(contains(outcome.out, "cpu:scalar and cpu:baseline: identical")) << outcome.out;
  }
}

}  // namespace
}  // namespace fascicle::tests
