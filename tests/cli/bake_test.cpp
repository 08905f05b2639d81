// fascicle bake as a user runs it.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "tests/bake/traced_disk.h"
#include "tests/cli/nodding_body.h"
#include "tests/cli/program.h"
#include "tests/support/assets.h"

namespace fascicle::tests {
namespace {

using nlohmann::json;

json manifest_of(const std::filesystem::path& folder) {
  return json::parse(read_text(folder / "manifest.json"), nullptr, false);
}

TEST(Bake, ResultsGoToStdoutAndSayHowToLook) {
  const TemporaryFolder folder;
  const Outcome outcome = fascicle({"bake", "bar-hang-none", "-o", folder / "bake", "--end", "0.1",
                                    "--device", "cpu", "--format", "pc2,vtu"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* part :
       {"ParaView", "Blender", "Mesh Cache", "surface.pc2", "rest.obj", "series.pvd", "metrics.csv"})
    EXPECT_TRUE(contains(outcome.out, part)) << part;
  EXPECT_TRUE(contains(outcome.out, "device: cpu"));
  EXPECT_FALSE(contains(outcome.out, "100 %"));
  EXPECT_TRUE(contains(outcome.err, "device: cpu")) << outcome.err;
  for (const char* file :
       {"manifest.json", "frames.fascicle", "metrics.csv", "surface.pc2", "rest.obj", "vtu/series.pvd"})
    EXPECT_TRUE(std::filesystem::is_regular_file(folder.path() / "bake" / file)) << file;
  const json manifest = manifest_of(folder.path() / "bake");
  EXPECT_EQ(manifest.at("status"), "complete");
  EXPECT_EQ(manifest.at("frames"), 6);  // 0.1 s at 60 fps
  EXPECT_EQ(manifest.at("position_hashes").size(), 7u);
}

// The commands of the section "to look at it", with the program's path.
std::vector<std::string> commands_to_look(const std::string& out) {
  std::vector<std::string> commands;
  for (std::size_t at = out.find("to look at it"); (at = out.find(": fascicle ", at)) != std::string::npos;) {
    at += 11;
    const std::string line = out.substr(at, out.find('\n', at) - at);
    commands.push_back("'" FASCICLE_PROGRAM "' " + line.substr(0, line.find("  (")));
  }
  return commands;
}

TEST(Bake, CommandsThatItNamesForPicturesWork) {
  const TemporaryFolder folder;
  // A name that a shell reads differently, and none at all.
  for (const auto& [scene, output] : {std::pair{"jump", "a man's/"}, std::pair{"bar-hang-none", "."}}) {
    const std::filesystem::path place = folder.path() / scene;
    std::filesystem::create_directories(place);
    const auto in_place = [&](const std::string& command) {
      return std::system(("cd '" + place.string() + "' && " + command + " >'" + (folder / "out") + "' 2>'" +
                          (folder / "err") + "'")
                             .c_str());
    };
    ASSERT_EQ(in_place(std::string("'" FASCICLE_PROGRAM "' bake ") + scene + " -o \"" + output +
                       "\" --end 0.05 --preroll 0s --device cpu"),
              0)
        << read_text(folder / "err");
    std::set<std::string> shown;
    for (const std::string& command : commands_to_look(read_text(folder / "out"))) {
      // The studio runs until it is closed; exports are tested elsewhere.
      if (contains(command, " studio ") || contains(command, " export ")) continue;
      shown.insert(command.substr(command.find("' ") + 2, 4));
      // A report takes seconds, and its command is made alike for both.
      if (contains(command, " report ") && output != std::string(".")) continue;
      EXPECT_EQ(in_place(command), 0) << command << "\n" << read_text(folder / "err");
    }
    EXPECT_EQ(shown, (std::set<std::string>{"rend", "repo", "view"})) << scene;
  }
}

TEST(Bake, NamesBlenderWhereItsScriptLoadsWhatWasWritten) {
  const TemporaryFolder folder;
  for (const auto& [format, is_loaded] : {std::pair{"obj", false}, {"abc", true}, {"usda", true}}) {
    const Outcome outcome = fascicle(
        {"bake", "arm", "-o", folder / format, "--end", "0.05", "--device", "cpu", "--format", format});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(contains(outcome.out, "blender --python"), is_loaded) << outcome.out;
  }
}

TEST(Bake, CpuAndVulkanGiveTheSameHashes) {
  NEEDS_VULKAN();
  const TemporaryFolder folder;
  for (const char* device : {"cpu", "vulkan"}) {
    const Outcome outcome = fascicle({"bake", "bar-layers-iii", "-o", folder / device, "--end", "0.1",
                                      "--device", device, "--format", "pc2"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, std::string("device: ") + device)) << outcome.err;
  }
  const json cpu = manifest_of(folder.path() / "cpu"), vulkan = manifest_of(folder.path() / "vulkan");
  EXPECT_EQ(cpu.at("device").at("solver"), "cpu");
  EXPECT_EQ(vulkan.at("device").at("solver"), "vulkan");
  ASSERT_EQ(cpu.at("position_hashes").size(), 7u);
  EXPECT_EQ(cpu.at("position_hashes"), vulkan.at("position_hashes"));
  EXPECT_EQ(read_text(folder.path() / "cpu/surface.pc2"), read_text(folder.path() / "vulkan/surface.pc2"));
}

TEST(Bake, ThreadsChangeNothing) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "3"}) {
    const Outcome outcome = fascicle({"bake", "bar-hang-none", "-o", folder / threads, "--end", "0.1",
                                      "--device", "cpu", "--threads", threads});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(manifest_of(folder.path() / threads).at("device").at("threads"), std::stoi(threads));
  }
  EXPECT_EQ(manifest_of(folder.path() / "1").at("position_hashes"),
            manifest_of(folder.path() / "3").at("position_hashes"));
}

TEST(Bake, SetReachesTheManifestAndTheMotion) {
  const TemporaryFolder folder;
  const std::vector<std::string> common{"--end", "0.1", "--device", "cpu"};
  const auto bake = [&](const std::string& name, std::vector<std::string> extra) {
    std::vector<std::string> arguments{"bake", "bar-hang-none", "-o", folder / name};
    arguments.insert(arguments.end(), common.begin(), common.end());
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    const Outcome outcome = fascicle(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return manifest_of(folder.path() / name);
  };
  const json plain = bake("plain", {});
  const json set = bake("set", {"--set", "layers.body.alpha=0.25", "--set", "layers.body.damping=1.5"});
  const json& layer = set.at("scene").at("layers").at(0);
  EXPECT_EQ(layer.at("alpha"), 0.25);
  EXPECT_EQ(layer.at("damping"), 1.5);
  EXPECT_NE(plain.at("position_hashes"), set.at("position_hashes"));
  const json fps = bake("fps", {"--fps", "30"});
  EXPECT_EQ(fps.at("frames"), 3);
}

TEST(Bake, FramesThatAreNotKeptAreNotThere) {
  const TemporaryFolder folder;
  const auto bake = [&](const std::string& name, const std::vector<std::string>& extra) {
    std::vector<std::string> arguments{"bake",  "bar-hang-none", "-o",       folder / name,
                                       "--end", "0.05",          "--device", "cpu"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    return fascicle(arguments);
  };
  const std::vector<std::string> pc2{"--format", "pc2", "--keep-frames", "false"};
  const Outcome outcome = bake("a", pc2);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "surface.pc2") && contains(outcome.out, "the frames were not kept"));
  EXPECT_FALSE(contains(outcome.out, "frames.fascicle")) << outcome.out;
  ASSERT_EQ(bake("kept", {"--format", "pc2"}).status, 0);
  for (const char* file : {"surface.pc2", "metrics.csv"})
    EXPECT_TRUE(read_text(folder.path() / "a" / file) == read_text(folder.path() / "kept" / file)) << file;
  EXPECT_FALSE(std::filesystem::exists(folder / "a/frames.fascicle"));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"render", folder / "a", "-o", folder / "a.png"},
        {"export", folder / "a", "--to", "mdd"}}) {
    const Outcome refused = fascicle(command);
    EXPECT_EQ(refused.status, 3);
    EXPECT_TRUE(contains(refused.err, "were not kept (--keep-frames false); bake again with --overwrite"))
        << refused.err;
  }
  EXPECT_EQ(fascicle({"bake", "bar-hang-none", "-o", folder / "a", "--end", "0.05", "--device", "cpu",
                      "--format", "pc2", "--keep-frames", "false", "--resume"})
                .status,
            0);
}

TEST(Bake, IsVerified) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  ASSERT_EQ(fascicle({"bake", "arm", "-o", out, "--end", "0.05", "--device", "cpu"}).status, 0);
  const Outcome good = fascicle({"verify", out});
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_TRUE(contains(good.out, "4 frames, all good") && contains(good.out, "the bake is complete"))
      << good.out;
  std::string bytes = read_text(out + "/frames.fascicle");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_text(out + "/frames.fascicle", bytes);
  const Outcome bad = fascicle({"verify", out, "--json"});
  EXPECT_EQ(bad.status, 3);
  EXPECT_TRUE(contains(bad.out, "damaged: frame ") && contains(bad.out, "\"good\": false")) << bad.out;
  EXPECT_TRUE(contains(bad.err, "bake again with --overwrite")) << bad.err;
  EXPECT_EQ(fascicle({"verify", folder / "nowhere"}).status, 3);
}

TEST(Bake, WritesNoFormatWhereThatIsSaid) {
  const TemporaryFolder folder;
  const auto bake = [&](const std::string& name, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "bake");
    arguments.insert(arguments.end(), {"-o", folder / name, "--end", "0.05", "--device", "cpu"});
    return fascicle(arguments);
  };
  // Also for the default scene, which otherwise writes two formats.
  const Outcome none = bake("none", {"--format", "none"});
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_TRUE(manifest_of(folder.path() / "none").at("formats").empty());
  EXPECT_TRUE(std::filesystem::exists(folder / "none/frames.fascicle"));
  EXPECT_TRUE(contains(none.out, "fascicle export")) << none.out;
  const Outcome metrics = bake("metrics", {"bar-hang-none", "--format", "none", "--keep-frames", "false"});
  ASSERT_EQ(metrics.status, 0) << metrics.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "metrics/metrics.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "metrics/frames.fascicle"));
  for (const auto& [arguments, reason] :
       {std::pair{std::vector<std::string>{"bar-hang-none", "--keep-frames", "false"},
                  "would leave no motion"},
        {std::vector<std::string>{"bar-hang-none", "--format", "pc2,none"}, "exclude each other"},
        {std::vector<std::string>{"crouch", "--clips", "all", "--keep-frames", "false"},
         "would leave no motion"}}) {
    const Outcome refused = bake("refused", arguments);
    EXPECT_EQ(refused.status, 2) << refused.err;
    EXPECT_TRUE(contains(refused.err, reason)) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "refused"));
  }
}

// tests/bake/durability_test.cpp simulates power cuts; this checks the program itself, with timed
// checkpoints.
TEST(Bake, IsWrittenInASafeOrder) {
  if (const std::string without = why_no_strace(); !without.empty())
    GTEST_SKIP() << "SKIPPED, NOT TESTED: " << without;
  const TemporaryFolder folder;
  const std::vector<DiskCall> calls =
      traced(FASCICLE_PROGRAM " bake arm --end 0.2 --format pc2,obj --device cpu --keep-frames false -o " +
                 (folder / "out"),
             folder / "out");
  std::string wrong;
  for (const std::string& one :
       wrong_orders(calls, folder / "out", [](const std::string&, bool) { return true; }))
    wrong += one + "\n";
  EXPECT_EQ(wrong, "");
  // The frames are removed only after the manifest that says so is written.
  const auto is_last = [&](DiskCall::Kind kind, const std::string& to) {
    const auto found = std::find_if(calls.rbegin(), calls.rend(), [&](const DiskCall& call) {
      return call.kind == kind && (kind == DiskCall::Kind::rename ? call.to : call.path) == to;
    });
    return calls.rend() - found;
  };
  EXPECT_LT(is_last(DiskCall::Kind::rename, folder / "out/manifest.json"),
            is_last(DiskCall::Kind::remove, folder / "out/frames.fascicle"));
}

TEST(Bake, FolderInUseIsRefused) {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments{"bake",  "bar-hang-none", "-o",       folder / "bake",
                                           "--end", "0.05",          "--device", "cpu"};
  ASSERT_EQ(fascicle(arguments).status, 0);
  const std::string before = read_text(folder.path() / "bake/manifest.json");
  const Outcome again = fascicle(arguments);
  EXPECT_EQ(again.status, 2);
  EXPECT_EQ(again.out, "");
  EXPECT_TRUE(contains(again.err, "--overwrite") && contains(again.err, "--resume")) << again.err;
  EXPECT_EQ(read_text(folder.path() / "bake/manifest.json"), before);
  std::vector<std::string> overwrite = arguments;
  overwrite.push_back("--overwrite");
  EXPECT_EQ(fascicle(overwrite).status, 0);
}

TEST(Bake, ResumeOfAnotherBakeIsBadInput) {
  const TemporaryFolder folder;
  const std::vector<std::string> arguments{"bake",  "bar-hang-none", "-o",       folder / "bake",
                                           "--end", "0.05",          "--device", "cpu"};
  ASSERT_EQ(fascicle(arguments).status, 0);
  std::vector<std::string> other = arguments;
  other.insert(other.end(), {"--resume", "--set", "layers.body.alpha=0.5"});
  const Outcome outcome = fascicle(other);
  EXPECT_EQ(outcome.status, 3) << outcome.err;
}

// 7,200 substeps, so the bake is far from its end when the signal arrives.
const std::vector<std::string> long_bake{
    "bake",     "bar-hang-none", "--end",    "2",  "--set", "solver.substeps=60",
    "--device", "cpu",           "--format", "pc2"};

TEST(Bake, InterruptedAndResumedIsAsIfNeverStopped) {
  const TemporaryFolder folder;
  const auto arguments = [&](const std::string& name, bool resume) {
    std::vector<std::string> list = long_bake;
    list.insert(list.end(), {"-o", folder / name});
    if (resume) list.push_back("--resume");
    return list;
  };
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string name = std::to_string(signal);
    Outcome stopped;
    int tries = 0;
    do {
      std::filesystem::remove_all(folder.path() / name);
      Program program(arguments(name, false));
      wait_until(program, [&] { return std::filesystem::exists(folder.path() / name / "manifest.json"); });
      program.send(signal);
      stopped = program.wait();
      // If this test has to wait for a processor, the bake may end before the signal.
    } while (stopped.status == 0 && ++tries < 10);
    ASSERT_EQ(stopped.status, 75) << stopped.err;
    EXPECT_EQ(stopped.out, "");
    EXPECT_TRUE(contains(stopped.err, "--resume")) << stopped.err;
    const json manifest = manifest_of(folder.path() / name);
    EXPECT_EQ(manifest.at("status"), "interrupted");
    EXPECT_LT(manifest.at("frames_done"), manifest.at("frames"));
    const Outcome resumed = fascicle(arguments(name, true));
    ASSERT_EQ(resumed.status, 0) << resumed.err;
    EXPECT_EQ(manifest_of(folder.path() / name).at("status"), "complete");
  }
  const Outcome whole = fascicle(arguments("whole", false));
  ASSERT_EQ(whole.status, 0) << whole.err;
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::filesystem::path stopped = folder.path() / std::to_string(signal),
                                reference = folder.path() / "whole";
    for (const char* file : {"frames.fascicle", "metrics.csv", "surface.pc2", "rest.obj"})
      EXPECT_TRUE(read_text(stopped / file) == read_text(reference / file)) << file;
    EXPECT_EQ(manifest_of(stopped).at("position_hashes"), manifest_of(reference).at("position_hashes"));
  }
}

// The program is stopped while both signals are sent, so it cannot finish a frame between them.
TEST(Bake, SecondSignalEndsItAtOnce) {
  const TemporaryFolder folder;
  Program program({"bake", "bar-layers-iii", "-o", folder / "bake", "--device", "cpu"});
  ASSERT_TRUE(
      wait_until(program, [&] { return std::filesystem::exists(folder.path() / "bake/manifest.json"); }));
  for (const int signal : {SIGSTOP, SIGINT, SIGTERM, SIGCONT}) program.send(signal);
  const Outcome outcome = program.wait();
  EXPECT_TRUE(outcome.signal == SIGINT || outcome.signal == SIGTERM) << outcome.status << " " << outcome.err;
}

TEST(Bake, DryRunWritesNothing) {
  const TemporaryFolder folder;
  const Outcome outcome =
      fascicle({"bake", "bar-hang-none", "-o", folder / "bake", "--device", "cpu", "--dry-run"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* part : {"vertices", "solver memory", "output", "time", "device"})
    EXPECT_TRUE(contains(outcome.out, part)) << part;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "bake"));
}

// A frame has twelve substeps here, more than the estimate runs: solids move and clips are cut in any of
// them.
TEST(Bake, DryRunTakesScenesWithSolidsAndCuts) {
  for (const std::vector<std::string>& scene :
       {std::vector<std::string>{"squeeze", "--set", "solver.substeps=12"},
        std::vector<std::string>{"arm", "--set", "motion.cuts=[0.0153]"}}) {
    std::vector<std::string> command{"bake", "--device", "cpu", "--dry-run", "--end", "0.1"};
    command.insert(command.end(), scene.begin(), scene.end());
    const Outcome outcome = fascicle(command);
    EXPECT_EQ(outcome.status, 0) << scene[0] << ": " << outcome.err;
  }
}

// The clip of this scene has keys from 0 to 4 s.
TEST(Bake, FramesOutsideTheClipsKeysAreSaid) {
  const auto said = [](const std::vector<std::string>& range) {
    std::vector<std::string> command{
        "bake", "arm", "--device", "cpu", "--dry-run", "--set", "character.resolution=0.06"};
    command.insert(command.end(), range.begin(), range.end());
    const Outcome outcome = fascicle(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  const std::string keys = "the clip has keys from 0 to 4 s: its last pose is held for ";
  EXPECT_TRUE(contains(said({"--end", "10"}), keys + "360 frames; --end 4 leaves them out"));
  EXPECT_TRUE(contains(said({"--start", "5", "--end", "6"}), keys + "60 frames"));
  // The controls: the clip as it is, one frame more, and handles, which are meant to lie outside.
  for (const std::vector<std::string>& range :
       {std::vector<std::string>{}, {"--end", "4.1"}, {"--handles", "60"}})
    EXPECT_FALSE(contains(said(range), "the clip has keys"));
}

// Until its first key, at 0.04 s, the clip holds a pose, and then the skeleton moves at once. The limit, half
// the default, is between that and the accelerations of the walk.
TEST(Bake, AMotionThatBeginsLateIsTold) {
  FASCICLE_NEEDS_ASSET(asset("CesiumMan.glb"));
  const std::string man = asset("CesiumMan.glb").string();
  const auto said = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{"bake", man, "--device=cpu", "--dry-run", "--end=0.3"};
    command.insert(command.end(), {"--resolution=800", "--set=motion.acceleration_limit=150"});
    command.insert(command.end(), more.begin(), more.end());
    return fascicle(command).err;
  };
  EXPECT_TRUE(contains(said({}), "--start 0.04167 begins with the motion"));
  EXPECT_FALSE(contains(said({"--start", "0.0417"}), "acceleration_limit"));
}

// A floor of 20 m in the character's file, whose carrier is larger than the body, is no part of its volume,
// its mass and its stiffness.
TEST(Bake, MeasuresABodyWithoutItsFloor) {
  const TemporaryFolder folder;
  std::vector<double> volumes, masses, at_rest, ratios;
  for (const double floor : {0.0, 10.0}) {
    write_text(folder / "body.gltf", nodding_body(12, 10, floor));
    const Outcome shown = fascicle({"inspect", folder / "body.gltf", "--resolution=300", "--json"});
    ASSERT_EQ(shown.status, 0) << shown.err;
    const json report = json::parse(shown.out);
    volumes.push_back(report["volume_m3"]);
    masses.push_back(report["mass_kg"]);
    const Outcome baked = fascicle({"bake", folder / "body.gltf", "-o", folder / "bake", "--overwrite",
                                    "--end=0.2", "--resolution=300", "--device=cpu", "-q"});
    ASSERT_EQ(baked.status, 0) << baked.err;
    std::istringstream rows(read_text(folder / "bake/metrics.csv"));
    std::string row;
    std::getline(rows, row);
    EXPECT_TRUE(row.starts_with("frame,time,kinetic_energy,volume,volume_ratio,")) << row;
    double least = 1.0;
    while (std::getline(rows, row)) {
      std::istringstream cells(row);
      std::vector<double> values;
      for (std::string cell; values.size() < 5 && std::getline(cells, cell, ',');)
        values.push_back(std::stod(cell));
      if (values.at(0) == 0.0) at_rest.push_back(values.at(3));
      least = std::min(least, values.at(4));
    }
    ratios.push_back(least);
  }
  // The two bodies are filled apart, and the floor holds the flesh next to it.
  EXPECT_NEAR(volumes[1], volumes[0], 0.01 * volumes[0]);
  EXPECT_NEAR(masses[1], masses[0], 0.01 * masses[0]);
  EXPECT_NEAR(at_rest[1], at_rest[0], 0.01 * at_rest[0]);
  EXPECT_LT(ratios[0], 0.999) << "the flesh is pressed, or there is nothing to see";
  EXPECT_NEAR(1.0 - ratios[1], 1.0 - ratios[0], 0.5 * (1.0 - ratios[0]));
}

TEST(Bake, DryRunCountsThePreroll) {
  const auto frames = [](const char* preroll) {
    const Outcome outcome = fascicle({"bake", "arm", "--device", "cpu", "--dry-run", "--end", "0.1", "--set",
                                      "character.resolution=0.06", "--preroll", preroll});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_TRUE(contains(frames("2s"), ", after 120 of preroll"));
  EXPECT_FALSE(contains(frames("0"), "preroll"));
}

// The body is so light that the force's acceleration overflows floats.
TEST(Bake, LeavingTheFiniteNumbersIsFive) {
  const TemporaryFolder folder;
  write_text(folder / "heavy.toml",
             "[bar]\nsize = [4e-9, 1e-9, 1e-9]\nvertices = [5, 3, 3]\n"
             "[layers.body]\ndensity = 0.001\n"
             "[pin.wall]\nwhere = { below = { axis = \"x\", fraction = 0.0 } }\n"
             "[force.push]\nkind = \"point\"\nvector = [0.0, -1e9, 0.0]\nwhere = { everywhere = true }\n");
  const Outcome outcome = fascicle({"bake", folder / "heavy.toml", "-o", folder / "bake", "--device", "cpu"});
  EXPECT_EQ(outcome.status, 5) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(contains(outcome.err, "frame 1")) << outcome.err;
  EXPECT_EQ(manifest_of(folder.path() / "bake").at("status"), "not-finite");
  EXPECT_EQ(fascicle({"validate", folder / "heavy.toml", "--devices", "cpu,cpu", "--frames", "2"}).status, 5);
}

TEST(Bake, UnwritableFolderIsOneMessage) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  const Outcome outcome =
      fascicle({"bake", "bar-hang-none", "-o", folder / "file/bake", "--end", "0.05", "--device", "cpu"});
  EXPECT_TRUE(outcome.status == 1 || outcome.status == 3) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "fascicle: error: ")) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

}  // namespace
}  // namespace fascicle::tests
