// The C API: bakes and builds, their progress, their cancelling, and the helpers that they start.
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include "include/fascicle/fascicle.h"
#include "tests/library/c_api.h"
#include "tests/library/shell.h"

namespace fascicle_tests {
namespace {

fascicle_scene* parsed(const std::string& text = small_bar) {
  fascicle_scene* scene = nullptr;
  EXPECT_EQ(fascicle_scene_parse(text.c_str(), nullptr, nullptr, &scene), FASCICLE_OK) << message();
  return scene;
}

fascicle_bake_options options_for(const std::string& folder) {
  fascicle_bake_options options = fascicle_bake_options_default();
  options.folder = folder.c_str();
  options.device = "cpu";
  options.threads = 1;
  options.cache = "";
  return options;
}

struct Watch {
  std::uint64_t builds = 0, frames = 0, last = 0, total = 0, cancel_at = ~std::uint64_t{0};
  std::vector<std::string> log;
};

int watch(void* user, fascicle_phase phase, uint64_t done, uint64_t total) {
  auto& watched = *static_cast<Watch*>(user);
  if (phase == FASCICLE_PHASE_BUILD) ++watched.builds;
  if (phase != FASCICLE_PHASE_FRAMES) return watched.cancel_at == 0 ? 1 : 0;
  ++watched.frames;
  watched.last = done;
  watched.total = total;
  return done >= watched.cancel_at ? 1 : 0;
}

void listen(void* user, fascicle_severity, const char* text) {
  static_cast<Watch*>(user)->log.emplace_back(text);
}

TEST(CApi, ABakeReportsAndIsTheProgramsOwn) {
  const Folder folder;
  fascicle_scene* scene = parsed();
  Watch watched;
  const std::string out = folder / "out";
  fascicle_bake_options options = options_for(out);
  const char* formats[] = {"pc2"};
  options.formats = formats;
  options.format_count = 1;
  options.progress = watch;
  options.log = listen;
  options.progress_user = options.log_user = &watched;
  fascicle_bake* bake = nullptr;
  ASSERT_EQ(fascicle_bake_run(scene, &options, &bake), FASCICLE_OK) << message();
  EXPECT_GE(watched.builds, 2u);
  EXPECT_EQ(watched.frames, 6u);
  EXPECT_EQ(watched.last, 6u);
  EXPECT_EQ(watched.total, 6u);
  EXPECT_FALSE(watched.log.empty());
  EXPECT_EQ(fascicle_bake_frames(bake), 6u);
  bool has_pc2 = false;
  for (std::size_t k = 0; k < fascicle_bake_file_count(bake); ++k) {
    EXPECT_TRUE(std::filesystem::exists(fascicle_bake_file(bake, k)));
    has_pc2 = has_pc2 || std::string(fascicle_bake_file(bake, k)).ends_with("surface.pc2");
  }
  EXPECT_TRUE(has_pc2);

  // The program bakes the same scene text to the same bytes.
  std::ofstream(folder / "bar.toml") << small_bar;
  const Ran ran = run_in_shell(std::string(FASCICLE_PROGRAM) + " bake " + (folder / "bar.toml") + " -o " +
                               (folder / "program") + " --format pc2 --no-cache --device cpu");
  ASSERT_EQ(ran.status, 0) << ran.out;
  EXPECT_NE(
      ran.out.find("position hash of the last frame: " + std::string(fascicle_bake_position_hash(bake))),
      std::string::npos)
      << ran.out;
  for (const char* name : {"surface.pc2", "frames.fascicle", "metrics.csv"}) {
    std::ostringstream a, b;
    a << std::ifstream(out + "/" + name, std::ios::binary).rdbuf();
    b << std::ifstream(folder / "program/" + name, std::ios::binary).rdbuf();
    EXPECT_FALSE(a.str().empty()) << name;
    EXPECT_TRUE(a.str() == b.str()) << name;
  }

  // A second bake into the same folder needs `overwrite`.
  EXPECT_FAILS(fascicle_bake_run(scene, &options, nullptr), FASCICLE_BAD_ARGUMENT, "holds a bake");
  options.overwrite = 1;
  EXPECT_EQ(fascicle_bake_run(scene, &options, nullptr), FASCICLE_OK) << message();
  fascicle_bake_destroy(bake);
  fascicle_scene_destroy(scene);
}

TEST(CApi, ACancelledBakeGoesOnToTheSameBits) {
  const Folder folder;
  fascicle_scene* scene = parsed();
  const std::string whole = folder / "whole", parts = folder / "parts";
  fascicle_bake* bake = nullptr;
  fascicle_bake_options options = options_for(whole);
  ASSERT_EQ(fascicle_bake_run(scene, &options, &bake), FASCICLE_OK) << message();
  const std::string hash = fascicle_bake_position_hash(bake);
  fascicle_bake_destroy(bake);

  Watch watched;
  options.folder = parts.c_str();
  options.progress = watch;
  options.progress_user = &watched;
  watched.cancel_at = 0;
  EXPECT_FAILS(fascicle_bake_run(scene, &options, &bake), FASCICLE_CANCELLED, "before the model was built");
  EXPECT_EQ(bake, nullptr);
  watched.cancel_at = 3;
  EXPECT_FAILS(fascicle_bake_run(scene, &options, &bake), FASCICLE_CANCELLED,
               " of 6; the same bake with options.resume");
  ASSERT_NE(bake, nullptr);
  // The next frame may be in progress when a frame is reported.
  EXPECT_GE(fascicle_bake_frames(bake), 3u);
  EXPECT_LT(fascicle_bake_frames(bake), 6u);
  EXPECT_NE(fascicle_bake_position_hash(bake), hash);
  fascicle_bake_destroy(bake);
  watched.cancel_at = ~std::uint64_t{0};
  options.resume = 1;
  ASSERT_EQ(fascicle_bake_run(scene, &options, &bake), FASCICLE_OK) << message();
  EXPECT_EQ(fascicle_bake_position_hash(bake), hash);
  fascicle_bake_destroy(bake);
  fascicle_scene_destroy(scene);
}

TEST(CApi, ABakeNeedNotKeepFrames) {
  const Folder folder;
  fascicle_scene* scene = parsed();
  const std::string out = folder / "out";
  fascicle_bake_options options = options_for(out);
  EXPECT_EQ(options.keep_frames, 1);
  const char* formats[] = {"none"};
  options.formats = formats;
  options.format_count = 1;
  options.keep_frames = 0;
  ASSERT_EQ(fascicle_bake_run(scene, &options, nullptr), FASCICLE_OK) << message();
  EXPECT_TRUE(std::filesystem::exists(out + "/metrics.csv"));
  EXPECT_FALSE(std::filesystem::exists(out + "/frames.fascicle"));
  // Programs compiled before the option existed keep the frames.
  const std::string old = folder / "old";
  options = options_for(old);
  options.struct_size = offsetof(fascicle_bake_options, keep_frames);
  ASSERT_EQ(fascicle_bake_run(scene, &options, nullptr), FASCICLE_OK) << message();
  EXPECT_TRUE(std::filesystem::exists(old + "/frames.fascicle"));
  fascicle_scene_destroy(scene);
}

TEST(CApi, BadBakeOptionsAreRefused) {
  const Folder folder;
  fascicle_scene* scene = parsed();
  const std::string out = folder / "out";
  const auto refused = [&](fascicle_status status, const char* part, auto change) {
    fascicle_bake_options options = options_for(out);
    change(options);
    EXPECT_FAILS(fascicle_bake_run(scene, &options, nullptr), status, part);
    EXPECT_FALSE(std::filesystem::exists(out)) << "a refused bake writes nothing: " << part;
  };
  const char* formats[] = {"mp3"};
  using Options = fascicle_bake_options;
  refused(FASCICLE_BAD_ARGUMENT, "folder", [](Options& o) { o.folder = nullptr; });
  refused(FASCICLE_BAD_ARGUMENT, "mp3", [&](Options& o) { o.formats = formats, o.format_count = 1; });
  refused(FASCICLE_BAD_ARGUMENT, "would leave no motion", [](Options& o) { o.keep_frames = 0; });
  const char* both[] = {"none", "pc2"};
  refused(FASCICLE_BAD_ARGUMENT, "exclude each other",
          [&](Options& o) { o.formats = both, o.format_count = 2; });
  refused(FASCICLE_BAD_ARGUMENT, "formats is null", [](Options& o) { o.format_count = 1; });
  refused(FASCICLE_BAD_ARGUMENT, "exclude", [](Options& o) { o.overwrite = o.resume = 1; });
  refused(FASCICLE_BAD_ARGUMENT, "glb_stride", [](Options& o) { o.glb_stride = 0; });
  refused(FASCICLE_BAD_ARGUMENT, "first_frame is -7", [](Options& o) { o.first_frame = -7; });
  refused(FASCICLE_BAD_ARGUMENT, "glb_error", [](Options& o) { o.glb_error = -1.0; });
  refused(FASCICLE_BAD_ARGUMENT, "\"gpu\"", [](Options& o) { o.device = "gpu"; });
  refused(FASCICLE_BAD_ARGUMENT, "options.threads is 1025", [](Options& o) { o.threads = 1025; });
  refused(FASCICLE_NO_SUCH_DEVICE, "", [](Options& o) { o.device = "vulkan:77"; });
  refused(FASCICLE_BAD_ARGUMENT, "struct_size", [](Options& o) { o.struct_size = 3; });
  std::ofstream(folder / "file") << "no folder";
  const std::string below = folder / "file/out";
  refused(FASCICLE_BAD_INPUT, "options.folder", [&](Options& o) { o.folder = below.c_str(); });
  fascicle_scene_destroy(scene);
}

void write_cube(const std::string& file) {
  std::ofstream(file) << "OFF\n8 12 0\n0 0 0\n.1 0 0\n.1 .1 0\n0 .1 0\n0 0 .1\n.1 0 .1\n.1 .1 .1\n0 .1 .1\n"
                         "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n"
                         "3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
}

// Mesher and cache are parameters: neither the program's folder nor the user's cache is used.
TEST(CApi, MesherAndCacheAreParameters) {
  const Folder folder;
  write_cube(folder / "cube.off");
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_load((folder / "cube.off").c_str(), nullptr, &scene), FASCICLE_OK) << message();
  fascicle_build_options options = fascicle_build_options_default();
  const std::string cache = folder / "cache", mesher = folder / "mesher";
  options.cache = "";
  options.mesher = "/no/such/mesher";
  fascicle_model* model = nullptr;
  EXPECT_FAILS(fascicle_model_build(scene, &options, &model), FASCICLE_BAD_INPUT, "/no/such/mesher");
  std::filesystem::copy_file(FASCICLE_MESHER, mesher);
  options.mesher = mesher.c_str();
  ASSERT_EQ(fascicle_model_build(scene, &options, &model), FASCICLE_OK) << message();
  fascicle_model_destroy(model);
  EXPECT_FALSE(std::filesystem::exists(cache));
  options.cache = cache.c_str();
  ASSERT_EQ(fascicle_model_build(scene, &options, &model), FASCICLE_OK) << message();
  EXPECT_GT(fascicle_model_tetrahedron_count(model), 0u);
  EXPECT_EQ(fascicle_model_surface_vertex_count(model), 8u);
  EXPECT_FALSE(std::filesystem::is_empty(cache));
  fascicle_model_destroy(model);
  fascicle_scene_destroy(scene);
}

// The given converter runs when the character is read, and again when it is baked.
TEST(CApi, TheConverterIsAParameter) {
  const Folder folder;
  const std::string made = folder / "made", out = folder / "out", converter = folder / "converter",
                    calls = folder / "calls", character = folder / "man.fbx";
  ASSERT_EQ(
      run_in_shell(std::string(FASCICLE_PROGRAM) + " bake arm --no-cache --device cpu --end 0.05 -o " + made)
          .status,
      0);
  std::ofstream(character) << "not read by this test's converter";
  std::ofstream(converter) << "#!/bin/sh\necho called >> " << calls << "\ncp " << made
                           << "/character.glb \"$2\"\n";
  std::filesystem::permissions(converter, std::filesystem::perms::owner_all);
  const auto call_count = [&] {
    std::ifstream file(calls);
    int count = 0;
    for (std::string line; std::getline(file, line);) ++count;
    return count;
  };
  fascicle_scene_options options = fascicle_scene_options_default();
  options.end = 0.05;
  options.converter = "/no/such/converter";
  fascicle_scene* scene = nullptr;
  EXPECT_FAILS(fascicle_scene_load(character.c_str(), &options, &scene), FASCICLE_BAD_INPUT,
               "/no/such/converter");
  options.converter = converter.c_str();
  ASSERT_EQ(fascicle_scene_load(character.c_str(), &options, &scene), FASCICLE_OK) << message();
  EXPECT_GT(fascicle_scene_joint_count(scene), 1u);
  const int when_read = call_count();
  EXPECT_GT(when_read, 0);
  fascicle_bake_options bake_options = options_for(out);
  bake_options.mesher = FASCICLE_MESHER;
  ASSERT_EQ(fascicle_bake_run(scene, &bake_options, nullptr), FASCICLE_OK) << message();
  EXPECT_GT(call_count(), when_read);
  EXPECT_TRUE(std::filesystem::exists(out + "/character.glb"));
  fascicle_scene_destroy(scene);
}

// Cancels at a call, counted from 1, or once a file exists.
struct Canceller {
  int calls = 0, cancel_at = 0;
  std::string waits_for;  // the file; empty: cancel by calls
};

int cancel(void* user, fascicle_phase phase, uint64_t done, uint64_t total) {
  auto& canceller = *static_cast<Canceller*>(user);
  EXPECT_EQ(phase, FASCICLE_PHASE_BUILD);
  EXPECT_EQ(done + total, 0u);
  if (!canceller.waits_for.empty()) return std::filesystem::exists(canceller.waits_for) ? 1 : 0;
  return ++canceller.calls == canceller.cancel_at ? 1 : 0;
}

// Sends the helpers' temporary files to a folder of the test.
class TemporaryFiles {
 public:
  explicit TemporaryFiles(const std::string& folder) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    std::filesystem::create_directory(folder);
    ::setenv("TMPDIR", folder.c_str(), 1);
  }
  ~TemporaryFiles() {
    if (before_.empty())
      ::unsetenv("TMPDIR");
    else
      ::setenv("TMPDIR", before_.c_str(), 1);
  }
  TemporaryFiles(const TemporaryFiles&) = delete;
  TemporaryFiles& operator=(const TemporaryFiles&) = delete;

 private:
  std::string before_;
};

void expect_nothing_left(const std::string& temporary) {
  EXPECT_TRUE(std::filesystem::is_empty(temporary));
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child process is left";
  EXPECT_EQ(errno, ECHILD);
}

// A cancelled build returns FASCICLE_CANCELLED and leaves nothing behind, at whatever call; otherwise it
// succeeds.
TEST(CApi, ABuildIsCancelledAnywhere) {
  const Folder folder;
  write_cube(folder / "cube.off");
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_load((folder / "cube.off").c_str(), nullptr, &scene), FASCICLE_OK) << message();
  const std::string temporary = folder / "temporary";
  const TemporaryFiles files(temporary);
  fascicle_build_options options = fascicle_build_options_default();
  options.mesher = FASCICLE_MESHER;
  options.cache = "";
  options.progress = cancel;
  Canceller canceller;
  options.progress_user = &canceller;
  fascicle_model* model = nullptr;
  for (;;) {
    canceller.calls = 0;
    ++canceller.cancel_at;
    model = reinterpret_cast<fascicle_model*>(1);
    const fascicle_status status = fascicle_model_build(scene, &options, &model);
    expect_nothing_left(temporary);
    if (status == FASCICLE_OK) break;
    ASSERT_EQ(status, FASCICLE_CANCELLED) << message();
    ASSERT_EQ(model, nullptr);
    EXPECT_EQ(canceller.calls, canceller.cancel_at) << "a cancelled build must not call progress again";
  }
  // Before and after the body, at least once per run of the mesher, and between the later steps.
  EXPECT_GE(canceller.calls, 8);
  EXPECT_GT(fascicle_model_tetrahedron_count(model), 0u);
  fascicle_model_destroy(model);
  fascicle_scene_destroy(scene);
}

// Cancelling ends a mesher that would run for a minute, and removes its folder.
TEST(CApi, AMesherThatRunsIsEndedWithItsBuild) {
  const Folder folder;
  write_cube(folder / "cube.off");
  const std::string mesher = folder / "mesher", pid = folder / "pid", temporary = folder / "temporary";
  std::ofstream(mesher) << "#!/bin/sh\necho $$ > " << pid << ".part\nmv " << pid << ".part " << pid
                        << "\nexec sleep 60\n";
  std::filesystem::permissions(mesher, std::filesystem::perms::owner_all);
  fascicle_scene* scene = nullptr;
  ASSERT_EQ(fascicle_scene_load((folder / "cube.off").c_str(), nullptr, &scene), FASCICLE_OK) << message();
  const TemporaryFiles files(temporary);
  Canceller canceller;
  canceller.waits_for = pid;
  const auto expect_ended = [&] {
    expect_nothing_left(temporary);
    int number = 0;
    std::ifstream(pid) >> number;
    ASSERT_GT(number, 0);
    EXPECT_EQ(::kill(number, 0), -1);
    EXPECT_EQ(errno, ESRCH);
    std::filesystem::remove(pid);
  };
  fascicle_build_options options = fascicle_build_options_default();
  options.mesher = mesher.c_str();
  options.cache = "";
  options.progress = cancel;
  options.progress_user = &canceller;
  fascicle_model* model = nullptr;
  EXPECT_FAILS(fascicle_model_build(scene, &options, &model), FASCICLE_CANCELLED,
               "before the model was built");
  EXPECT_EQ(model, nullptr);
  expect_ended();
  // So does cancelling a bake.
  const std::string out = folder / "out";
  fascicle_bake_options bake_options = options_for(out);
  bake_options.mesher = mesher.c_str();
  bake_options.progress = cancel;
  bake_options.progress_user = &canceller;
  fascicle_bake* bake = nullptr;
  EXPECT_FAILS(fascicle_bake_run(scene, &bake_options, &bake), FASCICLE_CANCELLED,
               "before the model was built");
  EXPECT_EQ(bake, nullptr);
  EXPECT_FALSE(std::filesystem::exists(out)) << "nothing is written";
  expect_ended();
  fascicle_scene_destroy(scene);
}

}  // namespace
}  // namespace fascicle_tests
