// The executable's interface: help, errors and their exit codes, the commands that only print, the log.
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/scene/scene.h"
#include "tests/cli/changed_glb.h"
#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) found.push_back(line);
  return found;
}

// One line on stderr that names the error, nothing on stdout.
void expect_error(const Outcome& outcome, int status, const std::string& part) {
  EXPECT_EQ(outcome.status, status) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  const std::vector<std::string> said = lines(outcome.err);
  ASSERT_FALSE(said.empty());
  EXPECT_TRUE(said.back().starts_with("fascicle: error: ")) << outcome.err;
  EXPECT_TRUE(contains(said.back(), part)) << outcome.err;
}

// Options that are numbers take neither NaN nor infinity, and nothing out of their range. A command that
// refuses one begins nothing: none of these folders exists.
TEST(CommandLine, NumbersAreFiniteAndInRange) {
  const auto refuses = [](const std::string& command, const std::string& option, const std::string& text) {
    expect_error(fascicle({command, "nowhere", "-o", command == "view" ? "page.html" : "picture.png",
                           option + "=" + text}),
                 2, option);
  };
  for (const char* text : {"nan", "-nan", "inf", "-inf", "1e999", "1e300", "x"}) {
    for (const char* option : {"--turn", "--tilt", "--zoom", "--lag-scale"}) refuses("render", option, text);
    refuses("view", "--error", text);
    for (const char* option : {"--glb-error", "--glb-tolerance", "--glb-compress"})
      expect_error(fascicle({"export", "nowhere", "--to", "glb", std::string(option) + "=" + text}), 2,
                   option);
  }
  refuses("render", "--tilt", "80.5");
  refuses("render", "--zoom", "0.09");
  refuses("render", "--lag-scale", "0");
  refuses("view", "--error", "-1");
  // The control: what is in range is refused only because there is no such bake.
  expect_error(fascicle({"render", "nowhere", "-o", "picture.png", "--turn=-400", "--tilt=80", "--zoom=1e2",
                         "--lag-scale=1e-3"}),
               3, "nowhere");
}

TEST(CommandLine, HelpListsEveryFlag) {
  const std::vector<std::string> log{"--quiet", "--verbose", "--log-format"};
  const std::vector<std::string> scene{"--set", "--fps", "--start", "--end", "--clip"};
  std::map<std::string, std::vector<std::string>> flags{
      {"bake", {"--output", "--format", "--device", "--threads", "--overwrite", "--resume", "--dry-run"}},
      {"batch", {"--device", "--threads", "--overwrite", "--resume", "--dry-run"}},
      {"validate",
       {"--devices", "--frames", "--threads", "--json", "--oracle", "--no-oracle", "--converged"}},
      {"render",
       {"--output", "--frame", "--mode", "--tets", "--clip", "--view", "--turn", "--zoom", "--size"}},
      {"inspect", {"--model", "--json"}},
      {"devices", {"--json"}},
      {"scenes", {}},
      {"schema", {}}};
  for (const char* name : {"bake", "validate", "inspect"})
    flags[name].insert(flags[name].end(), scene.begin(), scene.end());
  const Outcome whole = fascicle({"--help"});
  EXPECT_EQ(whole.status, 0);
  for (auto& [command, expected] : flags) {
    EXPECT_TRUE(contains(whole.out, command)) << command;
    expected.insert(expected.end(), log.begin(), log.end());
    const Outcome help = fascicle({command, "--help"});
    EXPECT_EQ(help.status, 0) << command;
    EXPECT_EQ(help.err, "") << command;
    for (const std::string& flag : expected) EXPECT_TRUE(contains(help.out, flag)) << command << " " << flag;
  }
}

TEST(CommandLine, VersionIsTheProjects) {
  const Outcome outcome = fascicle({"--version"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, std::string("fascicle ") + FASCICLE_VERSION + "\n");
}

TEST(CommandLine, BadUsageIsTwo) {
  expect_error(fascicle({}), 2, "subcommand");
  expect_error(fascicle({"bake", "--frobnicate"}), 2, "--frobnicate");
  expect_error(fascicle({"bakke"}), 2, "did you mean bake?");
  expect_error(fascicle({"bake", "bar-hang-none", "--format", "fbx"}), 2, "fbx");
  expect_error(fascicle({"bake", "bar-hang-none", "--overwrite", "--resume"}), 2, "--resume");
  expect_error(fascicle({"bake", "bar-hang-none", "--threads", "-1"}), 2, "--threads");
  expect_error(fascicle({"bake", "bar-hang-none", "--fps", "0"}), 2, "--fps");
  expect_error(fascicle({"bake", "bar-hang-none", "--set", "layers.body.alpha"}), 2, "KEY=VALUE");
  expect_error(fascicle({"bake", "bar-hang-none", "--device", "abacus"}), 2, "abacus");
  expect_error(fascicle({"bake", "bar-hang-none", "--device", "vulkan:1x"}), 2, "vulkan:1x");
  expect_error(fascicle({"validate", "bar-hang-none", "--devices", "cpu,"}), 2, "device");
  expect_error(fascicle({"validate", "bar-hang-none", "--devices", "auto,cpu"}), 2, "not auto");
  expect_error(fascicle({"validate", "bar-hang-none", "--devices", "cpu", "--no-oracle"}), 2,
               "nothing to compare");
  expect_error(fascicle({"validate"}), 2, "SCENE");
  expect_error(fascicle({"inspect", "bar-hang-none", "--model", "out.stl"}), 2, ".vtu");
}

// The scene itself loads, so a bad --set is an error of the command line.
TEST(CommandLine, BadOverrideIsTwoAndNamesTheNearestKey) {
  expect_error(fascicle({"inspect", "bar-hang-none", "--set", "layers.body.alfa=0.5"}), 2, "alpha");
  expect_error(fascicle({"inspect", "bar-hang-none", "--set", "layers.body.alpha=4.1"}), 2, "alpha");
}

// Options that may be repeated take one value each time.
TEST(CommandLine, TheSceneAfterARepeatableOptionIsTheScene) {
  for (const auto& [option, value] :
       {std::pair{"--rigid", "Head"}, std::pair{"--only", "Head"}, std::pair{"--set", "scene.end=0.1"}}) {
    const Outcome outcome = fascicle({"bake", option, value, "no-such-scene"});
    EXPECT_EQ(outcome.status, 3) << option;
    EXPECT_TRUE(contains(outcome.err, "no-such-scene")) << option << ": " << outcome.err;
  }
}

TEST(CommandLine, UnknownSceneIsThreeAndSuggestsTheNearest) {
  for (const char* command : {"bake", "validate", "inspect", "scenes"})
    expect_error(fascicle({command, "bar-hang-nome"}), 3, "bar-hang-none");
}

TEST(CommandLine, BrokenSceneFileIsThreeAndNamesItsLine) {
  const TemporaryFolder folder;
  write_text(folder / "broken.toml", "[bar]\nsize = [1.0, 1.0, 1.0]\n\n[layers.body]\nalpha = \"soft\"\n");
  const Outcome outcome = fascicle({"inspect", folder / "broken.toml"});
  expect_error(outcome, 3, "broken.toml:5");
}

TEST(CommandLine, NoSuchDeviceIsFour) {
  expect_error(fascicle({"bake", "bar-hang-none", "--dry-run", "--device", "vulkan:77"}), 4, "");
  // With a loader that finds no driver, the CPU still bakes and vulkan is reported as missing.
  const std::vector<std::string> no_driver{"VK_ICD_FILENAMES=/nonexistent.json",
                                           "VK_DRIVER_FILES=/nonexistent.json"};
  expect_error(fascicle({"bake", "bar-hang-none", "--dry-run", "--device", "vulkan"}, no_driver), 4,
               "no Vulkan device");
  const Outcome automatic = fascicle({"bake", "bar-hang-none", "--dry-run", "--end", "0.1"}, no_driver);
  EXPECT_EQ(automatic.status, 0) << automatic.err;
  EXPECT_TRUE(contains(automatic.err, "device: cpu")) << automatic.err;
}

TEST(CommandLine, ScenesAreListedAndPrinted) {
  const Outcome list = fascicle({"scenes"});
  EXPECT_EQ(list.status, 0);
  EXPECT_EQ(list.err, "");
  ASSERT_EQ(lines(list.out).size(), scene::builtin_scenes().size());
  for (const scene::BuiltinScene& scene : scene::builtin_scenes())
    EXPECT_TRUE(contains(list.out, scene.name));
  EXPECT_TRUE(contains(list.out, "(default)"));

  // The output is a scene file with the same content.
  const Outcome one = fascicle({"scenes", "bar-hang-along"});
  EXPECT_EQ(one.status, 0);
  const TemporaryFolder folder;
  write_text(folder / "copy.toml", one.out);
  nlohmann::json original = nlohmann::json::parse(fascicle({"inspect", "bar-hang-along", "--json"}).out);
  nlohmann::json copy = nlohmann::json::parse(fascicle({"inspect", folder / "copy.toml", "--json"}).out);
  for (const char* key : {"scene", "source", "build_seconds"}) {
    original.erase(key);
    copy.erase(key);
  }
  EXPECT_EQ(original, copy);
}

TEST(CommandLine, SchemaIsJson) {
  const Outcome outcome = fascicle({"schema"});
  EXPECT_EQ(outcome.status, 0);
  const nlohmann::json schema = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(contains(schema.at("$schema").get<std::string>(), "2020-12"));
}

TEST(CommandLine, DevicesNamesTheCpuAndEveryVulkanDevice) {
  const Outcome text = fascicle({"devices"}), as_json = fascicle({"devices", "--json"});
  EXPECT_EQ(text.status, 0);
  EXPECT_EQ(as_json.status, 0);
  const nlohmann::json devices = nlohmann::json::parse(as_json.out);
  EXPECT_TRUE(contains(text.out, devices.at("cpu").at("name").get<std::string>()));
  EXPECT_GE(devices.at("cpu").at("threads").get<unsigned>(), 1u);
  for (const nlohmann::json& device : devices.at("vulkan")) {
    EXPECT_TRUE(contains(text.out, device.at("name").get<std::string>()));
    EXPECT_GT(device.at("max_storage_buffer_range").get<std::uint64_t>(), 0u);
    // It is either exact or comes with a reason why not.
    EXPECT_NE(device.at("exact").get<bool>(), !device.at("why_not").get<std::string>().empty());
  }
}

TEST(CommandLine, QuietSaysNothing) {
  const Outcome outcome =
      fascicle({"bake", "bar-hang-none", "--dry-run", "--end", "0.1", "--device", "cpu", "-q"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_NE(outcome.out, "");
  // Errors are still reported.
  expect_error(fascicle({"inspect", "bar-hang-nome", "-q"}), 3, "bar-hang-none");
}

TEST(CommandLine, JsonLogIsOneObjectALine) {
  const TemporaryFolder folder;
  const Outcome good = fascicle({"bake", "bar-hang-none", "-o", folder / "bake", "--end", "0.1", "--device",
                                 "cpu", "-v", "--log-format", "json"});
  EXPECT_EQ(good.status, 0) << good.err;
  const Outcome usage = fascicle({"bake", "--frobnicate", "--log-format", "json"});
  const Outcome input = fascicle({"inspect", "bar-hang-nome", "--log-format=json"});
  EXPECT_EQ(usage.status, 2);
  EXPECT_EQ(input.status, 3);
  int progress = 0;
  for (const Outcome& outcome : {good, usage, input}) {
    ASSERT_FALSE(outcome.err.empty());
    for (const std::string& line : lines(outcome.err)) {
      const nlohmann::json object = nlohmann::json::parse(line, nullptr, false);
      ASSERT_TRUE(object.is_object()) << line;
      EXPECT_TRUE(object.contains("time") && object.contains("level") && object.contains("message")) << line;
      if (object["level"] == "progress") ++progress;
    }
  }
  EXPECT_GE(progress, 1);
  EXPECT_EQ(nlohmann::json::parse(lines(usage.err).back())["level"], "error");
}

// stderr is a file here: no progress bar and no colour, with or without NO_COLOR.
TEST(CommandLine, NoEscapesAndNoCarriageReturnsOffTheTerminal) {
  for (const char* variable : {"NO_COLOR=1", "NO_COLOR="}) {
    const TemporaryFolder folder;
    const Outcome outcome =
        fascicle({"bake", "bar-hang-none", "-o", folder / "bake", "--end", "0.1", "--device", "cpu"},
                 {variable, "TERM=xterm"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "100 %")) << outcome.err;
    EXPECT_FALSE(contains(outcome.err + outcome.out, "\x1b"));
    EXPECT_FALSE(contains(outcome.err + outcome.out, "\r"));
  }
}

TEST(CommandLine, ResultsThatCannotBeWrittenAreAnError) {
  // Uses the shell only to redirect stdout to a full device.
  const std::string command = std::string(FASCICLE_PROGRAM) + " schema >/dev/full 2>/dev/null";
  const int status = std::system(command.c_str());
  EXPECT_EQ(status, 1 << 8);
}

TEST(CommandLine, InspectTellsWhatMusclesHaveBecome) {
  const nlohmann::json muscles =
      nlohmann::json::parse(fascicle({"inspect", "arm", "--json"}).out).at("muscles");
  ASSERT_EQ(muscles.size(), 2u);
  EXPECT_EQ(muscles[0].at("name"), "biceps");
  EXPECT_EQ(muscles[0].at("bone"), "upper_arm");
  EXPECT_GT(muscles[0].at("bulging_regions"), 300);
  EXPECT_GT(muscles[0].at("regions"), muscles[0].at("bulging_regions"));
}

TEST(CommandLine, InspectCountsOneInTheSingular) {
  const TemporaryFolder folder;
  // A closed tetrahedron whose triangles all face inward.
  write_text(folder / "inside_out.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n");
  const std::string turned = fascicle({"inspect", folder / "inside_out.obj"}).out;
  EXPECT_TRUE(contains(turned, "1, at vertex 0\n")) << turned;
  const std::string arm = fascicle({"inspect", "arm"}).out;
  EXPECT_TRUE(contains(arm, "bone layer: 1 connected part\n")) << arm;
  EXPECT_TRUE(contains(arm, "1 round of ")) << arm;
  EXPECT_FALSE(contains(arm, "(s)")) << arm;
}

TEST(CommandLine, InspectNamesThePartsOfACharacter) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle({"bake", "arm", "--end", "0.05", "--device", "cpu", "-o", folder / "arm"}).status, 0);
  const std::string file = folder / "named.glb";
  std::filesystem::copy_file(folder / "arm/character.glb", file);
  change_glb(file, [](nlohmann::json& document) {
    document["materials"] = {{{"name", "skin\x1b[31m"}}};
    for (nlohmann::json& mesh : document["meshes"])
      for (nlohmann::json& primitive : mesh["primitives"]) primitive["material"] = 0;
  });
  const Outcome text = fascicle({"inspect", file});
  EXPECT_TRUE(contains(text.out, "objects\n  body\nmaterials\n  skin\\x1b[31m\n")) << text.out << text.err;
  const nlohmann::json report = nlohmann::json::parse(fascicle({"inspect", file, "--json"}).out);
  EXPECT_EQ(report["objects"], nlohmann::json({"body"}));
  EXPECT_EQ(report["materials"], nlohmann::json({"skin\x1b[31m"}));
}

}  // namespace
}  // namespace fascicle::tests
