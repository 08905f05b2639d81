// If any call of a device fails, completed work is kept, and the next device continues with the same bits.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

// Values of VkResult; VK_TIMEOUT is positive and so not formally an error.
const std::map<int, std::string> results{{-4, "VK_ERROR_DEVICE_LOST"},
                                         {-2, "VK_ERROR_OUT_OF_DEVICE_MEMORY"},
                                         {-1, "VK_ERROR_OUT_OF_HOST_MEMORY"},
                                         {-3, "VK_ERROR_INITIALIZATION_FAILED"},
                                         {2, "VK_TIMEOUT"}};

std::vector<std::string> layer(const std::string& fault, const std::string& count_file = {}) {
  std::vector<std::string> environment{"VK_INSTANCE_LAYERS=VK_LAYER_FASCICLE_faults",
                                       "VK_LAYER_PATH=" FASCICLE_FAULT_LAYER_FOLDER,
                                       // Mesa's layer that sorts devices crashes if one of its queries fails.
                                       "NODEVICE_SELECT=1", "FASCICLE_FAULT=" + fault};
  if (!count_file.empty()) environment.push_back("FASCICLE_FAULT_COUNT=" + count_file);
  return environment;
}

std::vector<std::string> bake(const std::string& folder, const std::string& device,
                              const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"bake",      "bar-hang-along", "-o",  folder,     "--end",
                                     "0.1",       "--format",       "pc2", "--device", device,
                                     "--no-cache"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

json manifest_in(const std::string& folder) {
  return json::parse(read_text(folder + "/manifest.json"));
}

// A soak sets 200.
long wanted_points() {
  const char* text = std::getenv("FASCICLE_FAULT_POINTS");
  return text == nullptr ? 10 : std::atol(text);
}

class DeviceFaults : public testing::Test {
 protected:
  void SetUp() override {
    NEEDS_VULKAN();
    const Outcome plain = fascicle(bake(folder / "plain", "cpu"));
    ASSERT_EQ(plain.status, 0) << plain.err;
    // The layer without a fault changes nothing and reports the number of calls. A device that has to wait
    // for a processor gets more submissions; the smaller of two numbers is reached by other runs too.
    for (const char* name : {"counted", "counted-again"}) {
      const Outcome counted = fascicle(bake(folder / name, "vulkan:0"), layer("0 0", folder / "count"));
      ASSERT_EQ(counted.status, 0) << counted.err;
      expect_same(name);
      long found = 0;
      std::ifstream(folder / "count") >> found;
      calls = calls == 0 ? found : std::min(calls, found);
    }
    ASSERT_GT(calls, 60) << "the layer is not loaded";
  }

  void expect_same(const std::string& name) const {
    EXPECT_EQ(manifest_in(folder / name).at("position_hashes"),
              manifest_in(folder / "plain").at("position_hashes"))
        << name;
    EXPECT_EQ(read_text(folder / (name + "/surface.pc2")), read_text(folder / "plain/surface.pc2")) << name;
  }

  // Calls spread over the whole bake, each with one of the results.
  template <class Visit>
  void for_each_fault(const Visit& visit) const {
    const long points = wanted_points();
    auto result = results.begin();
    for (long k = 0; k < points; ++k) {
      visit(1 + k * (calls - 1) / points, result->first, result->second);
      if (++result == results.end()) result = results.begin();
    }
  }

  TemporaryFolder folder;
  long calls = 0;
};

TEST_F(DeviceFaults, TheNextDeviceGoesOnToTheSameBits) {
  long handed_over = 0;
  for_each_fault([&](long call, int result, const std::string& name) {
    SCOPED_TRACE("call " + std::to_string(call) + " of " + std::to_string(calls) + ": " + name);
    const std::string baked = "goes-on-" + std::to_string(call);
    const Outcome outcome = fascicle(bake(folder / baked, "vulkan:0,cpu"),
                                     layer(std::to_string(call) + " " + std::to_string(result)));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    expect_same(baked);
    // Without a readable pipeline cache a bake still works, and most calls ignore TIMEOUT; then the GPU
    // continues.
    const bool has_changed = manifest_in(folder / baked).at("device").at("solver") == "cpu";
    handed_over += has_changed ? 1 : 0;
    EXPECT_EQ(has_changed, contains(outcome.err, name)) << outcome.err;
  });
  EXPECT_GT(handed_over, wanted_points() / 2);
}

TEST_F(DeviceFaults, WithoutAnotherDeviceResumingGoesOn) {
  long failed = 0, begun = 0;
  for_each_fault([&](long call, int result, const std::string& name) {
    SCOPED_TRACE("call " + std::to_string(call) + " of " + std::to_string(calls) + ": " + name);
    const std::string baked = "alone-" + std::to_string(call);
    const Outcome outcome = fascicle(bake(folder / baked, "vulkan:0"),
                                     layer(std::to_string(call) + " " + std::to_string(result)));
    if (outcome.status == 0) return;
    ++failed;
    EXPECT_TRUE(outcome.status == 7 || outcome.status == 4) << outcome.status << ": " << outcome.err;
    EXPECT_TRUE(contains(outcome.err, name)) << outcome.err;
    if (outcome.status == 7) {
      EXPECT_TRUE(contains(outcome.err, "--resume")) << outcome.err;
    }
    if (std::filesystem::exists(folder / (baked + "/manifest.json"))) {
      ++begun;
      EXPECT_EQ(manifest_in(folder / baked).at("status"), "failed");
    }
    const Outcome resumed = fascicle(bake(folder / baked, "cpu", {"--resume"}));
    ASSERT_EQ(resumed.status, 0) << resumed.err;
    expect_same(baked);
  });
  EXPECT_GT(failed, wanted_points() / 2);
  EXPECT_GT(begun, 0);
}

// An earlier bake is replaced even if the device fails before the new one begins.
TEST_F(DeviceFaults, WhatIsOverwrittenIsNotGoneOnWith) {
  const auto write_jobs = [&](const std::string& end) {
    write_text(folder / "jobs.toml", "output = \"" + folder / "batch" +
                                         "\"\nformat = [\"pc2\"]\n[job.one]\nscene = \"bar-hang-along\"\n"
                                         "set = [\"scene.end=" +
                                         end + "\"]\n");
  };
  write_jobs("0.05");
  ASSERT_EQ(fascicle({"batch", folder / "jobs.toml"}).status, 0);
  write_jobs("0.1");
  // The batch itself only lists the devices; its child opens one.
  const Outcome outcome = fascicle({"batch", folder / "jobs.toml", "--overwrite", "--device", "vulkan:0,cpu"},
                                   layer("vkCreateDevice -3"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_same("batch/one");
  const json job = json::parse(read_text(folder / "batch/batch.json")).at("jobs").at(0);
  EXPECT_EQ(job.at("device"), "cpu");
  EXPECT_TRUE(contains(job.at("warnings").dump(), "retrying on another device")) << job.dump();
}

TEST_F(DeviceFaults, ABatchGivesTheJobToAnotherDevice) {
  write_text(folder / "jobs.toml",
             "output = \"" + folder / "batch" +
                 "\"\nformat = [\"pc2\"]\n"
                 "[job.one]\nscene = \"bar-hang-along\"\nset = [\"scene.end=0.1\"]\n"
                 "[job.two]\nscene = \"bar-hang-along\"\nset = [\"scene.end=0.1\"]\n"
                 "[job.three]\nscene = \"bar-hang-along\"\nset = [\"scene.end=0.1\"]\n");
  // Fails in the middle of the GPU's frames. After two failures the GPU gets no more jobs.
  const Outcome outcome =
      fascicle({"batch", folder / "jobs.toml", "--device", "vulkan:0,cpu", "--at-once", "1"},
               layer(std::to_string(calls * 3 / 4) + " -4"));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "retrying on another device")) << outcome.err;
  const json jobs = json::parse(read_text(folder / "batch/batch.json")).at("jobs");
  ASSERT_EQ(jobs.size(), 3u);
  for (const json& job : jobs) {
    EXPECT_EQ(job.at("status"), "done") << job.dump();
    EXPECT_EQ(job.at("device"), "cpu") << job.dump();
    expect_same("batch/" + job.at("job").get<std::string>());
  }

  // With only that device each job fails and gives the reason.
  const Outcome alone = fascicle({"batch", folder / "jobs.toml", "--device", "vulkan:0", "--overwrite"},
                                 layer(std::to_string(calls * 3 / 4) + " -4"));
  EXPECT_EQ(alone.status, 7) << alone.err;
  const json alone_jobs = json::parse(read_text(folder / "batch/batch.json")).at("jobs");
  ASSERT_EQ(alone_jobs.size(), 3u);
  for (const json& job : alone_jobs) {
    EXPECT_EQ(job.at("status"), "failed") << job.dump();
    EXPECT_TRUE(contains(job.at("error").get<std::string>(), "VK_ERROR_DEVICE_LOST")) << job.dump();
  }
}

// `auto` takes no software device, so this one claims to be a GPU.
TEST(AutomaticDevice, IsLeftIfItFails) {
  NEEDS_VULKAN();
  const TemporaryFolder folder;
  const auto on_a_gpu = [&](long call, const std::string& count_file = {}) {
    std::vector<std::string> environment = layer(std::to_string(call) + " -4", count_file);
    environment.push_back("FASCICLE_FAULT_DISCRETE=1");
    return environment;
  };
  const Outcome plain = fascicle(bake(folder / "plain", "auto"), on_a_gpu(0, folder / "count"));
  ASSERT_EQ(plain.status, 0) << plain.err;
  EXPECT_EQ(manifest_in(folder / "plain").at("device").at("solver"), "vulkan");
  long calls = 0;
  std::ifstream(folder / "count") >> calls;
  ASSERT_GT(calls, 60);

  long left = 0;
  for (long call = 20; call < calls; call += calls / 8) {
    SCOPED_TRACE("call " + std::to_string(call) + " of " + std::to_string(calls));
    const Outcome outcome = fascicle(bake(folder / std::to_string(call), "auto"), on_a_gpu(call));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    left += manifest_in(folder / std::to_string(call)).at("device").at("solver") == "cpu" ? 1 : 0;
  }
  EXPECT_GT(left, 4);
}

}  // namespace
}  // namespace fascicle::tests
