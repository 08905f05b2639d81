// Where a build or what comes before frame 0 takes long, it is said.
#include "host/pipeline/long_wait.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

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
  // 20, 40, 80, 160 and 320 ms, or fewer where the machine is busy.
  EXPECT_LE(said.size(), 5u);
}

// A mesher that takes longer than a user waits without a word, and then is none.
TEST(LongWaitTest, ABuildThatTakesLongSaysSo) {
  const fs::path mesher = fs::temp_directory_path() / ("fascicle-slow-mesher-" + std::to_string(::getpid()));
  std::ofstream(mesher) << "#!/bin/sh\nsleep 6\nexit 9\n";
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

}  // namespace
}  // namespace fascicle::tests
