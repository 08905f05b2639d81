// Untrusted input: inputs that are not regular files, names with terminal escapes, values with shell
// commands.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "host/cli/shown_output.h"
#include "host/cli/text.h"
#include "host/gltf/gltf.h"
#include "host/gltf/gltf_rig.h"
#include "tests/cli/changed_glb.h"
#include "tests/cli/program.h"
#include "tests/gltf/gltf_viewer.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// Killed after some seconds; then `signal` is SIGKILL.
Outcome within_seconds(const std::vector<std::string>& arguments) {
  constexpr std::chrono::seconds patience{120};
  Program program(arguments);
  const auto start = std::chrono::steady_clock::now();
  while (program.is_running()) {
    if (std::chrono::steady_clock::now() - start > patience) program.send(SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return program.wait();
}

void expect_no_input(const std::vector<std::string>& arguments, const std::string& file) {
  const Outcome outcome = within_seconds(arguments);
  EXPECT_EQ(outcome.signal, 0) << arguments[0] << " " << file;
  EXPECT_EQ(outcome.status, 3) << arguments[0] << " " << file << ": " << outcome.err;
  EXPECT_TRUE(contains(outcome.err, file)) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "is not a regular file")) << outcome.err;
}

// A direction override and a control character that begins a terminal's commands, in a name that a message
// repeats.
TEST(Strangers, NamesInJsonLogsAreEscaped) {
  const Outcome outcome = fascicle({"bake", "\xE2\x80\xAE\xC2\x9B.glb", "--log-format", "json", "--dry-run"});
  EXPECT_NE(outcome.status, 0);
  EXPECT_TRUE(contains(outcome.err, "\\u202e\\u009b.glb")) << outcome.err;
  for (const char c : outcome.err) EXPECT_TRUE(c == '\n' || (c >= ' ' && c <= '~')) << static_cast<int>(c);
}

void make_pipe(const std::string& path) {
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0) << path;
}

TEST(Strangers, PipesFoldersAndDevicesAreNoInputs) {
  for (const std::string_view kind : {"pipe", "folder", "device"}) {
    const TemporaryFolder folder;
    const auto make = [&](const std::string& name) {
      const std::string path = folder / name;
      if (kind == "pipe") make_pipe(path);
      if (kind == "folder") fs::create_directory(path);
      if (kind == "device") fs::create_symlink("/dev/zero", path);
      return path;
    };
    for (const char* name : {"a.toml", "a.obj", "a.mesh", "a.ele", "a.glb", "a.gltf"}) {
      if (std::string(name) == "a.ele") write_text(folder / "a.node", "4 3 0 0\n");
      const std::string path = make(name);
      expect_no_input({"inspect", path}, name);
    }
    write_text(folder / "scene.toml", "[mesh]\nfile = \"a.obj\"\n[layers.fat]\n");
    expect_no_input({"inspect", folder / "scene.toml"}, "a.obj");
    write_text(folder / "b.gltf",
               "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"b.bin\", \"byteLength\": 4}]}");
    make("b.bin");
    // A symbolic link that leads out of the folder is never opened.
    if (kind != "device") expect_no_input({"inspect", folder / "b.gltf"}, "b.bin");
    expect_no_input({"batch", "--dry-run", folder / "a.toml"}, "a.toml");
    expect_no_input({"bench", "--against", make("bench.json")}, "bench.json");
  }
}

TEST(Strangers, FoldersOfBakesHoldFiles) {
  for (const char* name : {"manifest.json", "batch.json"}) {
    const TemporaryFolder folder;
    make_pipe(folder / name);
    if (std::string(name) == "batch.json") {
      expect_no_input({"batch", "status", folder.path()}, name);
      continue;
    }
    expect_no_input({"bake", "bar-beta-1", "--end", "0.1", "-o", folder.path()}, name);
    expect_no_input({"render", folder.path(), "-o", folder / "a.png"}, name);
    expect_no_input({"export", folder.path(), "--to", "pc2"}, name);
  }
}

TEST(Strangers, FilesInAFolderOfABakeAreFiles) {
  const TemporaryFolder folder;
  const std::string bake = folder / "bake";
  ASSERT_EQ(fascicle({"bake", "bar-beta-1", "--end", "0.1", "--device", "cpu", "-o", bake}).status, 0);
  for (const char* name : {"frames.fascicle", "model.fascicle", "metrics.csv"}) {
    fs::rename(bake + "/" + name, bake + "/kept");
    make_pipe(bake + "/" + name);
    const bool is_metrics = std::string(name) == "metrics.csv";
    std::vector<std::string> command{"render", bake, "-o", folder / "a.png"};
    if (is_metrics) command.insert(command.end(), {"--worst", "2"});
    expect_no_input(command, name);
    fs::remove(bake + "/" + name);
    fs::rename(bake + "/kept", bake + "/" + name);
  }
}

// In centimetres or the size of a doll: the generated scene adapts to the size.
TEST(Strangers, CharactersOfAnySizeAreBaked) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle({"bake", "arm", "--end", "0.05", "--device", "cpu", "-o", folder / "arm"}).status, 0);
  const auto scaled = [&](double scale) {
    const std::string path = folder / "scaled.glb";
    fs::copy_file(folder / "arm/character.glb", path, fs::copy_options::overwrite_existing);
    change_glb(path, [&](nlohmann::json& document) {
      nlohmann::json& roots = document["scenes"][0]["nodes"];
      document["nodes"].push_back(
          {{"name", "scaled"}, {"children", roots}, {"scale", {scale, scale, scale}}});
      roots = {document["nodes"].size() - 1};
    });
    return fascicle({"bake", path, "--end", "0.05", "--device", "cpu", "--overwrite", "-o", folder / "out"});
  };
  for (const double scale : {0.0008, 0.04, 0.2, 300.0}) {
    const Outcome outcome = scaled(scale);
    EXPECT_EQ(outcome.status, 0) << scale << ": " << outcome.err;
  }
  const Outcome huge = scaled(1e6);
  EXPECT_EQ(huge.status, 3);
  EXPECT_TRUE(contains(huge.err, "the character is ") && contains(huge.err, "scale it to metres"))
      << huge.err;
}

// Area-weighted, of the triangles of a file's only primitive.
std::vector<Eigen::Vector3d> geometric_normals(const std::string& glb,
                                               const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> normals(points.size(), Eigen::Vector3d::Zero());
  const gltf::Rig rig = gltf::read_rig(glb);
  const rig::Character character = gltf::read_gltf(glb);
  EXPECT_EQ(rig.parts.size(), 1u);
  for (const auto& [a, b, c] : character.surface.triangles) {
    const Eigen::Vector3d normal = (points[b] - points[a]).cross(points[c] - points[a]);
    for (const std::uint32_t corner : {a, b, c}) normals[corner] += normal;
  }
  for (Eigen::Vector3d& normal : normals) normal.normalize();
  return normals;
}

// An armature that is scaled unevenly, as artists leave it: viewers turn normals with the joints' transforms.
TEST(Strangers, UnevenlyScaledCharactersAreShadedAsTheyAre) {
  const TemporaryFolder folder;
  ASSERT_EQ(fascicle({"bake", "arm", "--end", "0.05", "--device", "cpu", "-o", folder / "arm"}).status, 0);
  const std::string scaled = folder / "scaled.glb";
  fs::copy_file(folder / "arm/character.glb", scaled);
  change_glb(scaled, [](nlohmann::json& document) {
    nlohmann::json& roots = document["scenes"][0]["nodes"];
    document["nodes"].push_back({{"name", "armature"}, {"children", roots}, {"scale", {1.0, 1.5, 0.8}}});
    roots = {document["nodes"].size() - 1};
    document["animations"][0].erase("extras");  // the mark of a baked clip
  });
  const Outcome outcome = fascicle({"bake", scaled, "--end", "0.1", "--device", "cpu", "--format", "glb",
                                    "--set", "motion.rest=\"weightless\"", "-o", folder / "out"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string glb = folder / "out/surface.glb";
  const GltfViewer viewer(glb);
  for (const double time : {0.0, 0.1}) {
    const std::vector<Eigen::Vector3d> wanted = geometric_normals(glb, viewer.shown(0, time)),
                                       seen = viewer.normals(0, time);
    ASSERT_EQ(seen.size(), wanted.size());
    std::vector<double> angles;
    for (std::size_t i = 0; i < seen.size(); ++i)
      angles.push_back(std::acos(std::clamp(seen[i].dot(wanted[i]), -1.0, 1.0)));
    std::nth_element(angles.begin(), angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2),
                     angles.end());
    // Normals that are off by 0.004 are not stored, and the file's own are not quite those of its triangles.
    EXPECT_LT(angles[angles.size() / 2], 0.02) << time;
  }
}

TEST(Strangers, DeepKeysAreBadInput) {
  const TemporaryFolder folder;
  std::string key = "a";
  for (int k = 0; k < 200'000; ++k) key += ".a";
  write_text(folder / "deep.toml", key + " = 1\n");
  for (const char* command : {"inspect", "batch"}) {
    const Outcome outcome = fascicle({command, folder / "deep.toml"});
    EXPECT_EQ(outcome.signal, 0) << command;
    EXPECT_EQ(outcome.status, 3) << command << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "deep.toml:1: TOML: column 64: ")) << outcome.err;
  }
}

void expect_harmless(const std::string& text) {
  for (const char* obeyed : {"\x1b", "\u202e", "\x07", "\r", "\u009b"})
    EXPECT_FALSE(contains(text, obeyed)) << text;
}

TEST(Strangers, NamesAreShownEscaped) {
  const TemporaryFolder folder;
  const std::string name = "e\x1b[31m\u202e\nfascicle: error: vil";
  const std::string shown = "e\\x1b[31m\\u202e\\nfascicle: error: vil";
  fs::copy_file(fs::path(FASCICLE_SOURCE_DIR) / "scenes/bar-beta-1.toml", folder / (name + ".toml"));
  const Outcome inspected = fascicle({"inspect", folder / (name + ".toml")});
  EXPECT_EQ(inspected.status, 0) << inspected.err;
  EXPECT_TRUE(inspected.out.starts_with(shown + "\n")) << inspected.out;
  expect_harmless(inspected.out + inspected.err);

  const Outcome refused = fascicle({"inspect", name});
  EXPECT_EQ(refused.status, 3);
  EXPECT_TRUE(refused.err.starts_with("fascicle: error: " + shown + ": no such scene")) << refused.err;
  expect_harmless(refused.err);
}

// A name with a line break is one field of one line, so that a resumed bake counts its lines rightly.
TEST(Strangers, JointNamesLeaveTheMetricsWhole) {
  const TemporaryFolder folder;
  const std::string file = folder / "named.glb";
  ASSERT_EQ(fascicle({"bake", "arm", "--end", "0.05", "--device", "cpu", "-o", folder / "arm"}).status, 0);
  fs::copy_file(folder / "arm/character.glb", file);
  change_glb(file, [](nlohmann::json& document) {
    document["animations"][0].erase("extras");  // the mark of a baked clip
    for (nlohmann::json& node : document["nodes"])
      if (node.contains("name")) node["name"] = "=1\n" + node["name"].get<std::string>();
  });
  const auto baked = [&](const std::string& out, const std::string& end, const std::string& more) {
    return fascicle({"bake", file, "-o", folder / out, "--device", "cpu", "--exaggerate", "4", "--format",
                     "pc2", "--end", end, more});
  };
  Outcome outcome = baked("whole", "0.2", "--overwrite");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_TRUE(contains(read_text(folder / "whole/metrics.csv"), ",'=1\\n")) << "no frame names a joint";
  ASSERT_EQ(baked("resumed", "0.1", "--overwrite").status, 0);
  outcome = baked("resumed", "0.2", "--resume");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_text(folder / "resumed/metrics.csv"), read_text(folder / "whole/metrics.csv"));
  outcome = fascicle({"verify", folder / "whole"});
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  outcome = fascicle({"render", folder / "whole", "--worst", "1", "-o", folder / "a.png"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST(Strangers, NamesInTablesAreShownEscaped) {
  EXPECT_EQ(cli::columns_text({{"a\nb", "1\x1b[2J"}, {"c", "\u2066"}}),
            "  a\\nb  1\\x1b[2J\n  c     \\u2066\n");
}

TEST(Strangers, OutputIsShownLineByLine) {
  std::ostringstream out;
  {
    const cli::ShownOutput shown(out);
    out << "a\x1b" << 'b' << "\xe2\x80"
        << "\xae"
        << "\n\tc" << std::flush << "d";
  }
  out << "\x1b";
  EXPECT_EQ(out.str(), "a\\x1bb\\u202e\n\tcd\x1b");
}

TEST(Strangers, DryRunsPrintCommandsThatMeanWhatTheyDo) {
  const TemporaryFolder folder;
  const std::string evil = "it's \"$(touch pwned)\" `touch pwned` \\ & ; \u202e ! ~ {a,b}";
  write_text(folder / "jobs.toml",
             "output = '''" + (folder / "out") + "\n  fascicle'''\n" +
                 "[job.a]\nscene = \"bar-beta-1\"\nset = ['''scene.description=" + evil + "''']\n");
  const Outcome outcome = fascicle({"batch", "--dry-run", "--device", "cpu", folder / "jobs.toml"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_harmless(outcome.out);
  std::istringstream printed(outcome.out);
  std::string head, command, more;
  std::getline(printed, head);
  std::getline(printed, command);
  EXPECT_FALSE(std::getline(printed, more)) << more;
  // bash reports which words it parses.
  write_text(folder / "script", "cd '" + folder.path().string() +
                                    "'\nfascicle() { printf '%s\\0' \"$@\" > words; }\n" + command + "\n");
  ASSERT_EQ(std::system(("bash '" + (folder / "script") + "'").c_str()), 0);
  const std::string words = read_text(folder / "words");
  EXPECT_TRUE(contains(words, std::string("--set=scene.description=") + evil + '\0')) << words;
  EXPECT_TRUE(contains(words, (folder / "out") + "\n  fascicle")) << words;
  EXPECT_FALSE(fs::exists(folder / "pwned"));
}

TEST(Strangers, WordsOfAShellAreWhatTheyWere) {
  const TemporaryFolder folder;
  std::vector<std::string> words{"",
                                 "plain",
                                 "=ls",
                                 "~",
                                 "a b",
                                 "it's",
                                 "$(x)",
                                 "\x1b[2J",
                                 "\n",
                                 "'\\\n",
                                 "\xff'",
                                 "\u202ea1",
                                 "\\\x01"
                                 "2",
                                 "*?",
                                 "a=$HOME",
                                 "#",
                                 "-n",
                                 "{a,b}",
                                 "!!"};
  std::string script = "printf '%s\\0'", expected;
  for (const std::string& word : words) {
    script += " " + cli::shell_word(word);
    expected += word + '\0';
  }
  expect_harmless(script);
  EXPECT_FALSE(contains(script, "\n"));
  write_text(folder / "script", script + " > '" + (folder / "words") + "'\n");
  ASSERT_EQ(std::system(("bash '" + (folder / "script") + "'").c_str()), 0);
  EXPECT_EQ(read_text(folder / "words"), expected);
}

}  // namespace
}  // namespace fascicle::tests
