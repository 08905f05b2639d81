// A long build or lead-in reports that it is running.
#include "host/pipeline/long_wait.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/base/helper_program.h"
#include "host/pipeline/bake_scene.h"
#include "host/pipeline/build_scene.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(LongWaitTest, SaysItWhenItIsDueAndEverMoreRarely) {
  std::vector<std::string> said;
  pipeline::LongWait wait([&](pipeline::Severity, const std::string& text) { said.push_back(text); }, 20ms);
  wait.go_on("still at it");
  EXPECT_TRUE(said.empty());
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < 400ms) {
    wait.go_on("still at it");
    std::this_thread::sleep_for(1ms);
  }
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said[0].rfind("still at it: ", 0), 0u) << said[0];
  // 20, 40, 80, 160 and 320 ms, or fewer if the machine is busy.
  EXPECT_LE(said.size(), 5u);
}

// A mesher that outlasts the time until the first message, and then fails.
TEST(LongWaitTest, ABuildThatTakesLongSaysSo) {
  const fs::path mesher = fs::temp_directory_path() / ("fascicle-slow-mesher-" + std::to_string(::getpid()));
  std::ofstream(mesher) << "#!/bin/sh\nsleep 6\nexit 7\n";
  fs::permissions(mesher, fs::perms::owner_all);
  build::BuildOptions options;
  options.mesher = mesher;
  std::string said;
  EXPECT_THROW(
      pipeline::build_scene(scene::load_scene("jump"), options,
                            [&](pipeline::Severity, const std::string& text) { said += text + "\n"; }),
      scene::SceneError);
  fs::remove(mesher);
  EXPECT_NE(said.find("still building the body: "), std::string::npos) << said;
}

// A lead-in of which one frame takes longer than that.
TEST(LongWaitTest, ALongLeadInSaysSo) {
  const base::TemporaryFolder folder;
  scene::SceneOverrides overrides;
  overrides.set = {"character.resolution=0.12", "motion.preroll=0.05", "motion.settle=0.0", "scene.end=0.02"};
  pipeline::BakeRequest request;
  request.output.folder = folder.path();
  request.output.overwrite = true;
  request.build.mesher = fs::path(FASCICLE_BINARY_DIR) / "fascicle-mesher";
  request.devices = pipeline::parse_device_order("cpu");
  int frames = 0;
  request.on_lead_in = [&] {
    if (++frames == 1) std::this_thread::sleep_for(5100ms);
  };
  std::string said;
  const pipeline::Say say = [&](pipeline::Severity, const std::string& text) { said += text + "\n"; };
  const auto prepared = pipeline::prepare_bake(scene::load_scene("jump", overrides), request, say);
  const bake::BakeResult result = pipeline::run_bake(*prepared, request, say);
  EXPECT_FALSE(result.interrupted);
  EXPECT_GE(frames, 3) << "the caller's own callback runs too";
  EXPECT_NE(said.find("still before frame 0, frame "), std::string::npos) << said;
}

}  // namespace
}  // namespace fascicle::tests
