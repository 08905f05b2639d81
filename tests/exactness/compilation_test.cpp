// The preconditions of the exactness tests: the flavours of frame_hashes contain all code whose numbers reach
// a result, compiled with their flags, and no object with kernel arithmetic contains a fused multiply-add
// (rule 3).
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/exactness/process.h"

namespace fascicle::tests {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, '|');) parts.push_back(part);
  return parts;
}

bool cpu_has_fma() {
  return run("grep -qw fma /proc/cpuinfo").status == 0;
}

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// The last -O of a command takes effect.
std::string optimisation(const std::string& command) {
  std::istringstream words(command);
  std::string last;
  for (std::string word; words >> word;)
    if (word.rfind("-O", 0) == 0) last = word;
  return last;
}

// The sources included by a file of a unity build, relative to the project's folder; none for any other file.
std::vector<std::string> united_sources(const fs::path& file) {
  std::vector<std::string> found;
  if (file.parent_path().filename() != "Unity") return found;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t open = line.find('"'), close = line.rfind('"');
    if (line.rfind("#include", 0) != 0 || open == close) continue;
    found.push_back(
        fs::path(line.substr(open + 1, close - open - 1)).lexically_relative(FASCICLE_SOURCE_DIR));
  }
  return found;
}

// Every source that turns input into numbers is compiled into every flavour at its optimisation level.
TEST(ExactnessFlavours, HoldAllCodeThatReachesAResult) {
  std::ifstream file(std::string(FASCICLE_BINARY_DIR) + "/compile_commands.json");
  const nlohmann::json commands = nlohmann::json::parse(file);
  const std::vector<std::string> sources = split(FASCICLE_EXACT_SOURCES);
  // Files that any correct list contains: one for each step that the numbers pass through.
  const std::set<std::string> listed(sources.begin(), sources.end());
  for (const char* name :
       {"cpu_reference/solver/stages.cpp", "host/build/shares.cpp", "host/build/fibre.cpp",
        "host/build/where.cpp", "host/build/bones.cpp", "host/build/weld.cpp", "host/build/skin_weights.cpp",
        "host/build/tetrahedralize.cpp", "host/drive/drive_source.cpp", "host/rig/pose_interpolation.cpp",
        "host/base/flat.cpp", "host/base/trigonometry.cpp", "host/made/made_shape.cpp",
        "host/made/made_bear_motion.cpp"})
    EXPECT_TRUE(listed.count(name)) << name;
  for (const auto& [flavour, level] : {std::pair{"O0", "-O0"}, std::pair{"O3_native", "-O3"}}) {
    const std::string output =
        std::string(" -o tests/exactness/CMakeFiles/frame_hashes_") + flavour + ".dir/";
    std::set<std::string> compiled;
    for (const auto& entry : commands) {
      const std::string command = entry["command"];
      if (command.find(output) == std::string::npos) continue;
      EXPECT_EQ(optimisation(command), level) << entry["file"];
      EXPECT_NE(command.find("-ffp-contract=off"), std::string::npos) << entry["file"];
      const fs::path compiled_file(entry["file"].get<std::string>());
      compiled.insert(compiled_file.lexically_relative(FASCICLE_SOURCE_DIR));
      for (const std::string& source : united_sources(compiled_file)) compiled.insert(source);
    }
    for (const std::string& source : sources)
      EXPECT_TRUE(compiled.count(source)) << source << " is not compiled into frame_hashes_" << flavour;
  }
}

// Sources outside the tests with kernel arithmetic: they include a kernel, or a header that does.
std::vector<std::string> kernel_sources() {
  std::vector<std::pair<std::string, std::string>> files;  // path and text
  for (const char* room : {"cpu_reference", "gpu", "host"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(FASCICLE_SOURCE_DIR) / room)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path());
      std::stringstream text;
      text << in.rdbuf();
      files.emplace_back(entry.path().lexically_relative(FASCICLE_SOURCE_DIR), text.str());
    }
  std::vector<std::string> kernels{"#include \"shaders/kernel/"};
  for (const auto& [path, text] : files)
    if (fs::path(path).extension() == ".h" && text.find(kernels.front()) != std::string::npos)
      kernels.push_back("#include \"" + path + "\"");
  std::vector<std::string> found;
  for (const auto& [path, text] : files) {
    const auto is_in = [&of = text](const std::string& kernel) {
      return of.find(kernel) != std::string::npos;
    };
    if (fs::path(path).extension() == ".cpp" && std::any_of(kernels.begin(), kernels.end(), is_in))
      found.push_back(path);
  }
  return found;
}

// Finds "cpu_reference/solver/stages.cpp" as .../cpu_reference/solver/CMakeFiles/ROOM.dir/stages.cpp.o, as
// .../FLAVOUR.dir/__/__/cpu_reference/solver/stages.cpp.o, or in an object of a unity build.
std::vector<std::string> objects_of(const std::string& source, const std::string& all) {
  const fs::path path(source);
  std::vector<std::string> found;
  for (const std::string& object : split(all)) {
    const bool own = ends_with(object, "/" + path.filename().string() + ".o") &&
                     object.find("/" + path.parent_path().string() + "/CMakeFiles/") != std::string::npos;
    const std::vector<std::string> united = united_sources(fs::path(object).replace_extension());
    const bool is_united = std::find(united.begin(), united.end(), source) != united.end();
    if (own || is_united || ends_with(object, "/__/" + source + ".o")) found.push_back(object);
  }
  return found;
}

int fused_instructions(const std::string& object) {
  const Output output = run("objdump -d '" + object + "' | grep -c 'vfn\\{0,1\\}m[as]'");
  return std::atoi(output.text.c_str());
}

TEST(ExactnessFlavours, KernelObjectsHoldNoFusedMultiplyAdd) {
  ASSERT_EQ(run("objdump --version").status, 0) << "objdump is missing (package binutils)";
  const std::vector<std::string> sources = kernel_sources();
  EXPECT_GE(sources.size(), 4u)
      << "expected at least the CPU's stages, the contact stages and the GPU's self-test";
  for (const std::string& source : sources) {
    for (const char* objects : {FASCICLE_BUILD_OBJECTS, FASCICLE_NATIVE_OBJECTS}) {
      const std::vector<std::string> of_source = objects_of(source, objects);
      ASSERT_FALSE(of_source.empty())
          << source << " has kernel arithmetic, but none of its objects is checked";
      for (const std::string& object : of_source) {
        ASSERT_TRUE(fs::exists(object)) << object;
        EXPECT_EQ(fused_instructions(object), 0) << object;
      }
    }
    // The control: the same source compiled with contraction; of the lanes, which share a text, those of
    // AVX2.
    if (source.find("/lane_stages_") != std::string::npos && !ends_with(source, "_avx2.cpp")) continue;
    const std::vector<std::string> contracted = objects_of(source, FASCICLE_CONTRACTED_OBJECTS);
    ASSERT_EQ(contracted.size(), 1u) << source;
    EXPECT_TRUE(!cpu_has_fma() || fused_instructions(contracted[0]) > 0) << "the grep finds nothing at all";
  }
}

// Code for one instruction set must not replace code that runs everywhere: if two objects contain the same
// inline function, the linker keeps either.
TEST(ExactnessFlavours, ObjectsInLanesShareNoFunction) {
  const auto shared_functions = [](const std::string& object) {
    return std::atoi(run("nm --defined-only '" + object + "' | grep -c ' [WVu] '").text.c_str());
  };
  for (const char* level : {"baseline", "sse4", "avx2", "avx512"}) {
    const std::string source = std::string("cpu_reference/solver/lane_stages_") + level + ".cpp";
    const std::vector<std::string> objects = objects_of(source, FASCICLE_BUILD_OBJECTS);
    ASSERT_EQ(objects.size(), 1u) << source << " must be compiled into exactly one object";
    EXPECT_FALSE(objects[0].find("/Unity/") != std::string::npos) << objects[0];
    EXPECT_EQ(shared_functions(objects[0]), 0) << objects[0];
  }
  // The control: an ordinary object has some.
  const std::vector<std::string> ordinary =
      objects_of("cpu_reference/solver/cpu_solver.cpp", FASCICLE_BUILD_OBJECTS);
  ASSERT_FALSE(ordinary.empty());
  EXPECT_GT(shared_functions(ordinary[0]), 0) << "the grep finds nothing at all";
}

}  // namespace

}  // namespace fascicle::tests
