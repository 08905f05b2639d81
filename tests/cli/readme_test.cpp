// README, --help and the code agree: the README's commands are run, its scene file is parsed, and the
// subcommands of ./do it names exist.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "host/scene/scene.h"

namespace fascicle::tests {

namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// The lines of all fenced blocks of one language.
std::vector<std::string> fenced(const std::string& language) {
  std::istringstream readme(text_of(std::filesystem::path(FASCICLE_SOURCE_DIR) / "README.md"));
  std::vector<std::string> lines;
  bool inside = false;
  for (std::string line; std::getline(readme, line);) {
    if (line.rfind("```", 0) == 0)
      inside = !inside && line == "```" + language;
    else if (inside)
      lines.push_back(line);
  }
  return lines;
}

class Readme : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("fascicle-readme-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_ / "out");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(Readme, CommandsRun) {
  // The list that the batch command names.
  std::ofstream jobs(folder_ / "jobs.toml");
  bool is_jobs = false;
  for (const std::string& line : fenced("toml")) {
    is_jobs = (is_jobs && line != "[scene]" && line != "[bar]" && line != "[character]") ||
              line.starts_with("output = ");
    if (is_jobs) jobs << line << "\n";
  }
  jobs.close();
  std::size_t ran = 0;
  for (const std::string& line : fenced("sh")) {
    if (line.rfind("fascicle ", 0) != 0) continue;
    const std::string command = "cd '" + folder_.string() + "' && PATH='" + FASCICLE_BINARY_DIR +
                                "':\"$PATH\" && { " + line.substr(0, line.find("  #")) + "; } > log 2>&1";
    if (line.find("vulkan") != std::string::npos && !std::getenv("FASCICLE_REQUIRE_VULKAN") &&
        std::system((std::string(FASCICLE_BINARY_DIR) + "/fascicle devices | grep -q vulkan:").c_str()) !=
            0) {
      ADD_FAILURE() << "no Vulkan device: README's '" << line << "' was NOT run";
      continue;
    }
    const int status = std::system(command.c_str());
    EXPECT_EQ(status, 0) << line << "\n" << text_of(folder_ / "log");
    ++ran;
  }
  EXPECT_GE(ran, 8u) << "README's commands were not found";
}

TEST_F(Readme, ScriptKnowsItsSubcommands) {
  const std::string script = text_of(std::filesystem::path(FASCICLE_SOURCE_DIR) / "do");
  std::size_t seen = 0;
  for (const std::string& line : fenced("sh")) {
    if (line.rfind("./do ", 0) != 0) continue;
    std::istringstream words(line.substr(5));
    std::string subcommand;
    words >> subcommand;
    EXPECT_NE(script.find("\n  " + subcommand + ")"), std::string::npos) << line;
    ++seen;
  }
  EXPECT_EQ(seen, 2u) << "the first screen shows two commands";
}

TEST_F(Readme, SceneFilesAreSome) {
  // A new file begins with [scene], or with a second body.
  std::vector<std::string> texts;
  bool has_body = true;
  bool is_jobs = false;
  for (const std::string& line : fenced("toml")) {
    const bool is_body = line.starts_with("[bar]") || line.starts_with("[character]");
    // The list of a batch is none.
    is_jobs = (is_jobs && !is_body && line != "[scene]") || line.starts_with("output = ");
    if (is_jobs) continue;
    if (line == "[scene]" || (is_body && has_body)) {
      texts.emplace_back();
      has_body = false;
    }
    has_body = has_body || is_body;
    ASSERT_FALSE(texts.empty()) << line;
    texts.back() += line + "\n";
  }
  std::vector<scene::Scene> scenes;
  for (const std::string& text : texts) {
    std::ofstream(folder_ / "readme.toml") << text;
    scenes.push_back(scene::load_scene((folder_ / "readme.toml").string()));
  }
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].layers.size(), 2u);
  EXPECT_EQ(scenes[0].forces.size(), 1u);
  EXPECT_EQ(scenes[1].layers.size(), 3u);
  EXPECT_EQ(scenes[1].muscles.size(), 1u);
}

}  // namespace

}  // namespace fascicle::tests
