// Bits do not depend on anything they should not: every built-in scene, a surface mesh and a walking man are
// stepped by programs and devices that differ, and each frame's hashes of positions, velocities and surface
// are compared with those of the release build's scalar stages on one thread.
//
// The cost is the lavapipe runs (8 times a CPU run each) and the code at -O0. To stay within two minutes on
// two cores, bars run 20 frames, the largest of them 10, and characters 6; only the solver is compiled at
// -O0, and only small bodies run on it and on narrow vectors of lavapipe; scenes that only add contact
// between bears are skipped. `do soak` builds the bodies at -O0 too, and runs everything for a minute of
// scene time.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "cpu_reference/solver/simd.h"
#include "host/scene/scene.h"
#include "tests/exactness/process.h"
#include "tests/support/assets.h"

namespace fascicle::tests {

namespace {

namespace fs = std::filesystem;

constexpr int characters_frames = 6;

// FASCICLE_EXACTNESS_FRAMES sets the number of frames of all runs.
bool soaks() {
  return std::getenv("FASCICLE_EXACTNESS_FRAMES") != nullptr;
}

int frames_or(int usual) {
  const char* text = std::getenv("FASCICLE_EXACTNESS_FRAMES");
  return text ? std::atoi(text) : usual;
}

// The environment for one width of lavapipe's vectors, in bits. Mesa's cache of compiled shaders does not
// tell widths apart: of two that share it, the second gets the first one's code. So the cache of each is a
// folder of its own, with a file for each shader.
std::string lavapipe_of(int width, const fs::path& cache) {
  const std::string bits = std::to_string(width);
  return "LP_NATIVE_VECTOR_WIDTH=" + bits +
         " MESA_DISK_CACHE_DATABASE=0 MESA_DISK_CACHE_SINGLE_FILE=0 MESA_SHADER_CACHE_DIR='" +
         cache.string() + "-" + bits + "'";
}

// A temporary folder, removed when the test ends.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "fascicle-exactness-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("mkdtemp: " + name);
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// One input and the runs to compare.
class Runs {
 public:
  using Devices = std::vector<std::string>;

  Runs(std::string scene, int frames) : scene_(std::move(scene)), frames_(frames) {
    Devices all{"cpu:1:scalar"};
    for (const cpu_reference::Simd level : cpu_reference::available_simd()) {
      levels_.push_back(std::string("cpu:2:") + name_of(level));
      all.push_back(levels_.back());
    }
    all.push_back("cpu:8");
    const std::vector<std::string> found = hashes(kept_model(), "frame_hashes", all, frames_);
    reference_ = found.at(0);
    for (std::size_t i = 1; i < all.size(); ++i)
      EXPECT_EQ(first_difference(reference_, found.at(i), frames_), "")
          << scene_ << ": levels and threads, " << all[i];
    // The body must move: identical frames would prove nothing.
    EXPECT_EQ(std::count(reference_.begin(), reference_.end(), '\n'), frames_) << scene_;
    EXPECT_NE(positions_in_line(0), positions_in_line(frames_ - 1)) << scene_;
  }

  // The devices of one run share a model too, as building takes longer than stepping.
  void expect_same(const std::string& what, const std::string& environment, const std::string& program,
                   const Devices& devices) const {
    const std::vector<std::string> found = hashes(environment, program, devices, frames_);
    for (std::size_t i = 0; i < devices.size(); ++i)
      EXPECT_EQ(first_difference(reference_, found.at(i), frames_), "")
          << scene_ << ": " << what << ", " << devices[i];
  }

  void all_programs() const {
    // The reference, the release build, is -O2. All levels of lanes come from one source, so -O0 runs only
    // the widest lanes and none.
    if (soaks())
      expect_same("-O0", "", "frame_hashes_O0", {"cpu:2", "cpu:2:scalar"});
    else if (is_small())
      expect_same("solver at -O0", kept_model(), "frame_hashes_O0_solver", {"cpu:2", "cpu:2:scalar"});
    if (soaks())
      expect_same("-O3 -march=native", "", "frame_hashes_O3_native", levels_);
    else
      expect_same("solver at -O3 -march=native", kept_model(), "frame_hashes_O3_native_solver", levels_);
    expect_same("C library without FMA and AVX2", "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA",
                "frame_hashes", {"cpu:2"});
  }
  void all_vulkan() const {
    const fs::path cache = fs::path(FASCICLE_BINARY_DIR) / "tests/exactness/shaders";
    for (const int width : {256, 128}) {
      // The narrow vectors take longer, for the same shaders.
      if (width == 128 && !is_small() && !soaks()) continue;
      expect_same("Vulkan, lavapipe of " + std::to_string(width) + " bits",
                  kept_model() + " " + lavapipe_of(width, cache), "frame_hashes", {"vulkan:0"});
    }
  }

  // The first of `frames` lines in which two outputs differ; empty if none does.
  static std::string first_difference(const std::string& a, const std::string& b, int frames) {
    std::istringstream lines_a(a), lines_b(b);
    std::string line_a, line_b;
    for (int k = 0; k < frames; ++k) {
      if (!std::getline(lines_a, line_a) || !std::getline(lines_b, line_b)) return "one of them ends early";
      if (line_a != line_b)
        return "frame and hashes of positions, velocities, surface " + line_a + " against " + line_b;
    }
    return "";
  }

  // The output of a run, per device.
  std::vector<std::string> hashes(const std::string& environment, const std::string& program,
                                  const Devices& devices, int frames) const {
    std::string command = environment + " " + FASCICLE_BINARY_DIR + "/" + program + " '" + scene_ + "' " +
                          std::to_string(frames);
    for (const std::string& device : devices) command += " " + device;
    const Output output = run(command);
    EXPECT_EQ(output.status, 0) << command << ": " << output.text;
    std::vector<std::string> by_device;
    std::istringstream lines(output.text);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("on ", 0) == 0) {
        EXPECT_EQ(line, by_device.size() < devices.size() ? "on " + devices[by_device.size()] : "no more");
        by_device.emplace_back();
      } else if (!by_device.empty()) {
        by_device.back() += line + "\n";
      }
    }
    // A run that ended early printed nothing for the remaining devices.
    by_device.resize(devices.size());
    return by_device;
  }

  const std::string& reference() const { return reference_; }

 private:
  // For programs that differ in the solver alone; others build the model again.
  std::string kept_model() const { return "FASCICLE_KEPT_MODEL='" + folder_.path().string() + "'"; }

  bool is_small() const {
    return scene_.rfind("bar-", 0) == 0 || scene_.rfind("rod-", 0) == 0 || scene_ == "cheek" ||
           scene_ == "stack";
  }

  std::string positions_in_line(int line) const {
    std::istringstream in(reference_);
    std::string text;
    for (int k = 0; k <= line; ++k) std::getline(in, text);
    std::istringstream words(text);
    std::string frame, positions;
    words >> frame >> positions;
    return positions;
  }

  Folder folder_;
  std::string scene_;
  int frames_;
  Devices levels_;  // those of this processor
  std::string reference_;
};

bool vulkan_is_there() {
  return run(std::string(FASCICLE_BINARY_DIR) + "/frame_hashes bar-hang-none 1 vulkan:0").status == 0;
}

// The CPU runs are compared first, so a test skipped here has compared those.
#define FASCICLE_NEEDS_VULKAN()                                                                       \
  if (!vulkan_is_there()) {                                                                           \
    if (std::getenv("FASCICLE_REQUIRE_VULKAN"))                                                       \
      FAIL() << "FASCICLE_REQUIRE_VULKAN is set and no Vulkan device works";                          \
    GTEST_SKIP()                                                                                      \
        << "SKIPPED: no Vulkan device; the CPU runs agree, bit identity with the GPU is NOT checked"; \
  }                                                                                                   \
  static_assert(true)

class Exactness : public testing::TestWithParam<std::string> {};

TEST_P(Exactness, NothingThatMustNotMatterDoes) {
  const bool large = GetParam().rfind("bar-layers", 0) == 0, bar = GetParam().rfind("bar-", 0) == 0;
  const int frames = large ? 10 : bar ? 20 : characters_frames;
  const Runs runs(GetParam(), frames_or(frames));
  runs.all_programs();
  FASCICLE_NEEDS_VULKAN();
  runs.all_vulkan();
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const scene::BuiltinScene& builtin : scene::builtin_scenes())
    if (soaks() || (builtin.name != "crouch" && builtin.name != "two-bears")) names.push_back(builtin.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Exactness, testing::ValuesIn(scene_names()), [](const auto& scene) {
  std::string name = scene.param;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

// The mesher, three layers by distance from bones, and an embedded surface. It is docs/examples/bunny.toml
// with another path to the mesh and 6 instead of 60 substeps, which runs the same code in a tenth of the
// time.
TEST(ExactnessRealInputs, Bunny) {
  const fs::path mesh = asset("bunny.off");
  FASCICLE_NEEDS_ASSET(mesh);
  std::ifstream in(std::string(FASCICLE_SOURCE_DIR) + "/docs/examples/bunny.toml");
  std::stringstream example;
  example << in.rdbuf();
  std::string text = example.str();
  const auto replace = [&](const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    text.replace(at, what.size(), with);
  };
  replace("\"bunny.off\"", "\"" + fs::absolute(mesh).string() + "\"");
  replace("substeps = 60", "substeps = 6");
  const Folder folder;
  const fs::path scene = folder.path() / "bunny.toml";
  std::ofstream(scene) << text;
  const Runs runs(scene.string(), frames_or(characters_frames));
  runs.all_programs();
  FASCICLE_NEEDS_VULKAN();
  runs.all_vulkan();
}

// A skeleton, its clip, skinning, interior weights, and a moving origin; coarse, to run the same code in a
// fifth of the time.
TEST(ExactnessRealInputs, WalkingMan) {
  const fs::path man = asset("CesiumMan.glb");
  FASCICLE_NEEDS_ASSET(man);
  const Folder folder;
  const fs::path scene = folder.path() / "man.toml";
  std::ofstream(scene) << "[character]\nfile = \"" << fs::absolute(man).string()
                       << "\"\n[body]\nresolution = \"2000\"\n";
  const Runs runs(scene.string(), frames_or(characters_frames));
  runs.all_programs();
  FASCICLE_NEEDS_VULKAN();
  runs.all_vulkan();
}

// The control: a build in which the compiler may contract a*b+c is detected. Otherwise the comparisons above
// could pass because nothing they vary has any effect.
TEST(ExactnessControl, ContractionIsSeen) {
  if (run("grep -qw fma /proc/cpuinfo").status != 0)
    GTEST_SKIP() << "SKIPPED: this CPU has no fused multiply-add, contraction cannot be planted";
  const Runs runs("bar-hang-along", 60);
  std::vector<std::string> devices{"cpu:1:scalar"};
  for (const cpu_reference::Simd level : cpu_reference::available_simd())
    if (std::string(name_of(level)) == "avx2") devices.emplace_back("cpu:1:avx2");
  const std::vector<std::string> contracted = runs.hashes("", "frame_hashes_contracted", devices, 60);
  for (std::size_t i = 0; i < devices.size(); ++i)
    EXPECT_NE(Runs::first_difference(runs.reference(), contracted.at(i), 60), "") << devices[i];
}

// Path below a cache of shaders -> bytes. Its index says when a file was used.
std::map<std::string, std::string> shaders_in(const fs::path& cache) {
  std::map<std::string, std::string> found;
  if (!fs::exists(cache)) return found;
  for (const auto& entry : fs::recursive_directory_iterator(cache)) {
    if (!entry.is_regular_file() || entry.path().filename() == "index") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    std::stringstream bytes;
    bytes << in.rdbuf();
    found[entry.path().lexically_relative(cache).string()] = bytes.str();
  }
  return found;
}

// The control of the widths: each compiles the shaders itself, to other code.
TEST(ExactnessControl, WidthsOfLavapipeRunCodeOfTheirOwn) {
  FASCICLE_NEEDS_VULKAN();
  if (run(std::string(FASCICLE_BINARY_DIR) + "/fascicle devices | grep -q 'vulkan:0.*llvmpipe'").status != 0)
    GTEST_SKIP() << "SKIPPED: the first Vulkan device is not lavapipe, and has no width of its own";
  const Folder folder;
  const fs::path cache = folder.path() / "shaders";
  for (const int width : {128, 256}) {
    const Output output =
        run(lavapipe_of(width, cache) + " " + FASCICLE_BINARY_DIR + "/frame_hashes bar-hang-none 1 vulkan:0");
    ASSERT_EQ(output.status, 0) << output.text;
  }
  const auto narrow = shaders_in(cache.string() + "-128"), wide = shaders_in(cache.string() + "-256");
  ASSERT_FALSE(narrow.empty() || wide.empty()) << "lavapipe kept no shaders";
  for (const auto& [name, bytes] : narrow)
    EXPECT_TRUE(!wide.count(name) || wide.at(name) != bytes) << name << " is the same at both widths";
}

}  // namespace

}  // namespace fascicle::tests
