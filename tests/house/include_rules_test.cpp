// Include rules: the room table of docs/architecture.md as data, checked against every #include of the
// repository.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace fascicle::tests {
namespace {

struct Room {
  std::string folder;
  std::vector<std::string> may_see;    // our folders and files, besides its own
  std::vector<std::string> libraries;  // names of `libraries` below
};

const std::vector<std::string> every_room{
    "host/base/",   "shaders/",    "host/mesh/",       "host/rig/",   "host/gltf/",     "host/made/",
    "host/scene/",  "host/build/", "host/model/",      "host/drive/", "host/formats/",  "host/bake/",
    "host/render/", "host/page/",  "cpu_reference/",   "gpu/",        "host/pipeline/", "host/studio/",
    "host/api/",    "host/cli/",   "include/fascicle/"};
const std::vector<std::string> every_library{
    "Eigen", "JSON",  "xxHash",        "Vulkan", "GoogleTest", "RapidCheck", "CLI11", "SIMD",   "PNG",
    "JPEG",  "Draco", "meshoptimizer", "zlib",   "C",          "fascicle",   "Boost", "pugixml"};

// The first matching folder applies. host/mesher is a separate program under another licence: it uses nothing
// of ours but the sandbox and its file, and only tests of it may use TetGen or CGAL. host/convert is a
// separate program too.
const std::vector<Room>& rooms() {
  static const std::vector<Room> table{
      {"shaders/", {}, {"SPIR-V"}},
      {"host/base/", {}, {"xxHash"}},
      {"host/mesh/", {"host/base/"}, {"Eigen", "pugixml"}},
      {"host/rig/", {"host/base/", "host/mesh/"}, {"Eigen"}},
      {"host/gltf/",
       {"host/base/", "host/mesh/", "host/rig/"},
       {"Eigen", "tinygltf", "JSON", "Draco", "meshoptimizer"}},
      {"host/made/", {"host/base/", "host/mesh/", "host/rig/"}, {"Eigen"}},
      {"host/scene/",
       {"host/base/", "host/mesh/", "host/rig/", "host/gltf/", "host/made/"},
       {"Eigen", "toml++", "JSON", "xxHash"}},
      {"host/mesher/", {"host/base/pending_output.h", "host/base/sandbox.h"}, {"TetGen", "CGAL"}},
      {"host/convert/", {"host/base/pending_output.h", "host/base/sandbox.h"}, {"assimp", "Eigen", "JSON"}},
      {"host/build/", {"host/base/", "host/mesh/", "host/rig/", "host/scene/", "host/model/"}, {"Eigen"}},
      {"host/model/",
       {"host/base/fields.h", "host/base/flat.h", "host/base/names.h", "host/base/stepping.h",
        "shaders/shared.h", "shaders/buffers.h"},
       {"xxHash"}},
      {"host/drive/", {"host/base/", "host/rig/", "host/scene/", "host/model/"}, {"Eigen"}},
      {"host/formats/",
       {"host/base/", "host/mesh/", "host/rig/", "host/gltf/", "host/scene/", "host/model/"},
       {"Eigen", "JSON", "zlib"}},
      {"host/bake/",
       {"host/base/", "host/mesh/", "host/rig/", "host/scene/", "host/model/", "host/drive/",
        "host/formats/"},
       {"Eigen", "JSON", "xxHash"}},
      {"host/render/", {"host/base/", "host/model/"}, {"Eigen", "PNG", "JPEG"}},
      {"host/page/",
       {"host/base/", "host/gltf/", "host/model/", "host/formats/", "host/bake/", "host/render/"},
       {"JSON"}},
      // The public headers include nothing of ours, only the C library.
      {"include/fascicle/", {"export.h", "version.h", "solver.h", "fascicle.h"}, {"C"}},
      {"host/pipeline/",
       {"host/base/", "host/rig/", "host/scene/", "host/build/", "host/model/", "host/drive/",
        "host/formats/", "host/bake/", "cpu_reference/solver/", "gpu/"},
       {}},
      {"host/studio/",
       {"host/base/", "host/rig/", "host/gltf/", "host/scene/", "host/build/", "host/model/", "host/drive/",
        "host/formats/", "host/bake/", "host/render/", "host/pipeline/"},
       {"Boost", "Eigen", "JSON"}},
      {"host/api/",
       {"host/base/", "host/rig/", "host/scene/", "host/build/", "host/model/", "host/drive/",
        "host/formats/", "host/bake/", "host/pipeline/", "include/fascicle/"},
       {}},
      {"python/", {}, {"pybind11", "fascicle"}},
      {"host/cli/", every_room, {"CLI11", "JSON", "Eigen"}},
      {"cpu_reference/solver/", {"host/base/fields.h", "host/model/", "shaders/"}, {"SIMD"}},
      {"cpu_reference/oracle/", {"host/model/"}, {"Eigen"}},
      {"gpu/", {"host/base/fields.h", "host/model/", "shaders/"}, {"Vulkan"}},
      {"tests/", every_room, every_library},
      {"bench/", every_room, {"Bullet", "Google Benchmark", "CLI11", "JSON", "Eigen"}},
  };
  return table;
}

// Third-party headers, by prefix.
const std::vector<std::pair<std::string, std::string>>& libraries() {
  static const std::vector<std::pair<std::string, std::string>> table{{"Eigen/", "Eigen"},
                                                                      {"tetgen.h", "TetGen"},
                                                                      {"CGAL/", "CGAL"},
                                                                      {"assimp/", "assimp"},
                                                                      {"boost/", "Boost"},
                                                                      {"volk.h", "Vulkan"},
                                                                      {"vulkan/", "Vulkan"},
                                                                      {"spirv/", "SPIR-V"},
                                                                      {"CLI/", "CLI11"},
                                                                      {"toml++/", "toml++"},
                                                                      {"tiny_gltf.h", "tinygltf"},
                                                                      {"nlohmann/", "JSON"},
                                                                      {"xxhash.h", "xxHash"},
                                                                      {"gtest/", "GoogleTest"},
                                                                      {"gmock/", "GoogleTest"},
                                                                      {"rapidcheck", "RapidCheck"},
                                                                      {"pugixml.hpp", "pugixml"},
                                                                      {"immintrin.h", "SIMD"},
                                                                      {"xmmintrin.h", "SIMD"},
                                                                      {"Bullet", "Bullet"},
                                                                      {"btBullet", "Bullet"},
                                                                      {"benchmark/", "Google Benchmark"},
                                                                      {"png.h", "PNG"},
                                                                      {"jpeglib.h", "JPEG"},
                                                                      {"draco/", "Draco"},
                                                                      {"zlib.h", "zlib"},
                                                                      {"stddef.h", "C"},
                                                                      {"stdint.h", "C"},
                                                                      {"stdio.h", "C"},
                                                                      {"fascicle/fascicle.h", "fascicle"},
                                                                      {"pybind11/", "pybind11"},
                                                                      {"meshoptimizer.h", "meshoptimizer"}};
  return table;
}

// C++ library headers have no dot. Also the POSIX headers in use, some of which share C's names, malloc.h of
// glibc, and headers of Linux and the compiler's sanitizers.
bool is_system_header(const std::string& header) {
  static const std::set<std::string> posix{"arpa/inet.h", "netinet/in.h", "dlfcn.h",   "fcntl.h", "link.h",
                                           "malloc.h",    "poll.h",       "pthread.h", "sched.h", "signal.h",
                                           "spawn.h",     "stdlib.h",     "string.h",  "unistd.h"};
  if (header.find('.') == std::string::npos) return header.find('/') == std::string::npos;
  return posix.contains(header) || header.starts_with("sys/") || header.starts_with("linux/") ||
         header.starts_with("sanitizer/");
}

bool starts_with_any(const std::string& path, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string& p) { return path.starts_with(p); });
}

std::string check_own(const Room& room, const std::string& header) {
  if (header.starts_with(room.folder) || starts_with_any(header, room.may_see)) return "";
  return "may not include \"" + header + "\"";
}

std::string check_foreign(const Room& room, const std::string& header) {
  if (is_system_header(header)) return "";
  for (const auto& [start, library] : libraries())
    if (header.starts_with(start))
      return std::count(room.libraries.begin(), room.libraries.end(), library) > 0
                 ? ""
                 : "may not include <" + header + ">: " + library + " belongs to other rooms";
  return "includes <" + header + ">, which no line of the library table names";
}

// All violations in a file, as "path:line: room ...".
std::vector<std::string> breaches(const Source& source) {
  const auto room = std::find_if(rooms().begin(), rooms().end(),
                                 [&](const Room& r) { return source.path.starts_with(r.folder); });
  if (room == rooms().end()) return {source.path + ": lies in no room"};
  static const std::regex own(R"re(^\s*#\s*include\s*"([^"]+)")re"),
      foreign(R"re(^\s*#\s*include\s*<([^>]+)>)re");
  std::vector<std::string> found;
  const std::vector<std::string> lines = lines_of(without_comments(source.text));
  for (std::size_t k = 0; k < lines.size(); ++k) {
    std::smatch match;
    std::string wrong;
    if (std::regex_search(lines[k], match, own))
      wrong = check_own(*room, match[1]);
    else if (std::regex_search(lines[k], match, foreign))
      wrong = check_foreign(*room, match[1]);
    if (!wrong.empty())
      found.push_back(source.path + ":" + std::to_string(k + 1) + ": " + room->folder + " " + wrong);
  }
  return found;
}

TEST(IncludeRules, EveryFileKeepsToItsRoom) {
  const std::vector<Source> sources = read_sources(FASCICLE_SOURCE_DIR);
  ASSERT_GT(sources.size(), 50u) << "the sources were not found";
  for (const Source& source : sources)
    for (const std::string& breach : breaches(source)) ADD_FAILURE() << breach;
}

TEST(IncludeRules, QuotedIncludesAreRootedAtTheRepository) {
  static const std::regex own(R"re(^\s*#\s*include\s*"([^"]+)")re");
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR)) {
    if (source.path.starts_with("include/")) continue;  // public headers, installed side by side
    for (const std::string& line : lines_of(without_comments(source.text))) {
      std::smatch match;
      if (!std::regex_search(line, match, own)) continue;
      EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(FASCICLE_SOURCE_DIR) / match[1].str()))
          << source.path << ": \"" << match[1] << "\" is not a path from the repository's root";
    }
  }
}

// Headers shared with GLSL must not include anything, or they could not compile there.
TEST(IncludeRules, SharedHeaderIncludesNothingOfOurs) {
  for (const Source& source : read_sources(FASCICLE_SOURCE_DIR)) {
    if (source.path != "shaders/shared.h") continue;
    EXPECT_EQ(source.text.find("#include \""), std::string::npos);
    return;
  }
  FAIL() << "shaders/shared.h is not there";
}

// The controls: each kind of planted violation is found.
TEST(IncludeRules, PlantedBreachesAreSeen) {
  const std::vector<std::pair<std::string, std::string>> planted{
      {"gpu/bad.cpp", "#include \"cpu_reference/solver/cpu_solver.h\"\n"},
      {"cpu_reference/solver/bad.cpp", "#include \"gpu/device.h\"\n"},
      {"cpu_reference/oracle/bad.cpp", "#include \"cpu_reference/solver/stages.h\"\n"},
      {"cpu_reference/bad.cpp", ""},
      {"gpu/bad.h", "  #  include \"host/scene/scene.h\"\n"},
      {"cpu_reference/solver/bad.cpp", "#include \"host/build/build.h\"\n"},
      {"host/build/bad.cpp", "#include <tetgen.h>\n"},
      {"host/model/bad.h", "#include <Eigen/Core>\n"},
      {"host/bake/bad.cpp", "#include \"host/cli/log.h\"\n"},
      {"host/formats/bad.cpp", "#include \"host/bake/bake.h\"\n"},
      {"host/drive/bad.cpp", "#include \"host/bake/bake.h\"\n"},
      {"host/gltf/bad.cpp", "#include \"host/scene/scene.h\"\n"},
      {"host/mesh/bad.cpp", "#include \"host/rig/character.h\"\n"},
      {"host/bake/bad.cpp", "#include <zlib.h>\n"},
      {"host/model/bad.h", "#include \"shaders/kernel/scalar.inc\"\n"},
      {"host/base/bad.h", "#include \"host/model/model.h\"\n"},
      {"host/mesher/bad.cpp", "#include \"host/scene/scene.h\"\n"},
      {"host/scene/bad.cpp", "#include <boost/any.hpp>\n"},
      {"host/cli/bad.cpp", "#include <benchmark/benchmark.h>\n"},
      {"shaders/bad.comp", "#include \"host/model/model.h\"\n"},
      {"host/pipeline/bad.cpp", "#include \"host/cli/log.h\"\n"},
      {"host/page/bad.cpp", "#include \"host/cli/log.h\"\n"},
      {"host/api/bad.cpp", "#include \"gpu/device.h\"\n"},
      {"include/fascicle/bad.h", "#include \"host/model/model.h\"\n"},
      {"include/fascicle/bad.hpp", "#include <Eigen/Core>\n"},
      {"python/bad.cpp", "#include \"host/model/model.h\"\n"},
      {"host/api/bad.cpp", "#include <pybind11/pybind11.h>\n"},
      {"elsewhere/bad.cpp", ""},
  };
  for (const auto& [path, text] : planted)
    EXPECT_EQ(breaches({path, text}).size(), 1u) << path << ": " << text;
  EXPECT_TRUE(breaches({"gpu/good.cpp",
                        "// #include \"host/scene/scene.h\"\n/*\n#include <tetgen.h>\n*/\n"
                        "#include <vector>\n#include <sys/stat.h>\n#include \"gpu/device.h\"\n"})
                  .empty());
}

}  // namespace
}  // namespace fascicle::tests
