// `fascicle export` gives the same bytes as the bake, from its folder alone.
#include "host/bake/export.h"

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/bake/manifest.h"
#include "host/bake/read_frame_cache.h"
#include "tests/bake/fake_bakes.h"
#include "tests/bake/fake_solver.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using bake::BakeError;

void bake_into(const fs::path& folder, const std::vector<std::string>& formats, std::uint64_t frames = 6) {
  bake::BakeOptions options = options_for(folder);
  options.formats = formats;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake::bake(short_scene(frames), model, solver, options);
}

std::vector<std::string> listed(const fs::path& folder) {
  return nlohmann::json::parse(read_text(folder / "manifest.json"))["files"];
}

template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const BakeError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Export, GivesTheBytesOfTheBake) {
  const TemporaryFolder folder;
  const std::vector<std::string> formats = bake::export_format_names();
  EXPECT_GE(formats.size(), 5u);
  bake_into(folder / "all", formats);
  bake_into(folder / "none", {});
  const bake::ExportResult result =
      bake::export_bake({.bake = folder / "none", .folder = folder / "exported", .formats = formats});
  EXPECT_EQ(result.frames, 6u);
  std::size_t compared = 0;
  for (const auto& [name, bytes] : content_of(folder / "exported")) {
    EXPECT_EQ(bytes, read_text(folder / ("all/" + name))) << name;
    ++compared;
  }
  // One file per format, except seven OBJ files, seven ParaView surfaces and their collection; plus the rest
  // mesh and the Blender script.
  EXPECT_EQ(compared, formats.size() - 2 + 7 + 8 + 2);
}

TEST(Export, CountsFramesAsTheBakeDoes) {
  const TemporaryFolder folder;
  const std::vector<std::string> formats = bake::export_format_names();
  bake::BakeOptions options = options_for(folder / "out");
  options.formats = formats;
  options.first_number = 1001;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake::bake(short_scene(3), model, solver, options);
  bake::export_bake({.bake = folder / "out", .folder = folder / "same", .formats = formats});
  for (const auto& [name, bytes] : content_of(folder / "same"))
    EXPECT_EQ(bytes, read_text(folder / ("out/" + name))) << name;
  EXPECT_TRUE(fs::exists(folder / "same/obj/frame_001004.obj"));
  EXPECT_NE(read_text(folder / "same/import_blender.py").find("\nFIRST = 1001\n"), std::string::npos);
  bake::export_bake(
      {.bake = folder / "out", .folder = folder / "other", .formats = {"obj"}, .first_number = 7});
  EXPECT_TRUE(fs::exists(folder / "other/obj/frame_000007.obj"));
  // Our own files count from 0, whatever the number of the first frame.
  EXPECT_NE(read_text(folder / "out/metrics.csv").find("\n0,"), std::string::npos);
}

TEST(Export, IntoTheBakesFolderBelongsToTheBake) {
  const TemporaryFolder folder;
  bake_into(folder / "out", {});
  bake::export_bake({.bake = folder / "out", .formats = {"mdd", "obj"}});
  const std::vector<std::string> files = listed(folder / "out");
  EXPECT_NE(std::find(files.begin(), files.end(), "surface.mdd"), files.end());
  EXPECT_NE(std::find(files.begin(), files.end(), "obj/"), files.end());
  // The next bake into this folder must be able to remove them.
  bake::BakeOptions options = options_for(folder / "out");
  options.formats = {};
  options.overwrite = true;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake::bake(short_scene(2), model, solver, options);
  EXPECT_FALSE(fs::exists(folder / "out/surface.mdd"));
  EXPECT_FALSE(fs::exists(folder / "out/obj"));
}

// import_blender.py in the bake's folder has the bake's number.
TEST(Export, IntoTheBakesFolderKeepsItsFrameNumbers) {
  const TemporaryFolder folder;
  bake_into(folder / "out", {});
  EXPECT_TRUE(contains(
      refusal([&] { bake::export_bake({.bake = folder / "out", .formats = {"obj"}, .first_number = 1001}); }),
      "its files number the first frame 0; with another --first-frame, export to another"));
  EXPECT_FALSE(fs::exists(folder / "out/obj"));
  bake::export_bake({.bake = folder / "out", .formats = {"obj"}, .first_number = 0});
  bake::export_bake(
      {.bake = folder / "out", .folder = folder / "shot", .formats = {"obj"}, .first_number = 1001});
  EXPECT_TRUE(fs::exists(folder / "shot/obj"));
}

TEST(Export, RefusesWhatIsInTheWay) {
  const TemporaryFolder folder;
  bake_into(folder / "out", {});
  write_text(folder / "surface.mdd", "mine");
  bake::ExportOptions options{.bake = folder / "out", .folder = folder / "", .formats = {"mdd"}};
  EXPECT_NE(refusal([&] { bake::export_bake(options); }).find("surface.mdd: would be overwritten"),
            std::string::npos);
  EXPECT_EQ(read_text(folder / "surface.mdd"), "mine");
  options.overwrite = true;
  bake::export_bake(options);
  EXPECT_NE(read_text(folder / "surface.mdd"), "mine");
}

TEST(Export, RefusesAnythingButAFinishedBake) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& name, const std::string& format) {
    return refusal([&] { bake::export_bake({.bake = folder / name, .formats = {format}}); });
  };
  fs::create_directories(folder / "empty");
  EXPECT_NE(message("empty", "mdd").find("holds no bake"), std::string::npos);
  EXPECT_NE(message("missing", "mdd").find("holds no bake"), std::string::npos);

  bake_into(folder / "out", {});
  EXPECT_NE(message("out", "fbx").find("no such format"), std::string::npos);
  EXPECT_NE(message("out", "vtu").find("velocities"), std::string::npos);

  std::string text = read_text(folder / "out/model.fascicle");
  text[text.size() / 2] = static_cast<char>(text[text.size() / 2] + 1);
  write_text(folder / "out/model.fascicle", text);
  EXPECT_NE(message("out", "mdd").find("damaged"), std::string::npos);
  fs::remove(folder / "out/model.fascicle");
  EXPECT_NE(message("out", "mdd").find("is missing"), std::string::npos);

  std::atomic<bool> interrupted = true;
  bake::BakeOptions options = options_for(folder / "cut");
  options.interrupted = &interrupted;
  const model::Model model = two_tetrahedra();
  FakeSolver solver(model);
  bake::bake(short_scene(6), model, solver, options);
  EXPECT_NE(message("cut", "mdd").find("not finished, 1 of 7 frames"), std::string::npos);
}

TEST(Export, LeavesNothingWhenInterrupted) {
  const TemporaryFolder folder;
  bake_into(folder / "out", {});
  const std::atomic<bool> interrupted = true;
  const bake::ExportResult result = bake::export_bake({.bake = folder / "out",
                                                       .folder = folder / "exported",
                                                       .formats = bake::export_format_names(),
                                                       .interrupted = &interrupted});
  EXPECT_TRUE(result.interrupted);
  EXPECT_TRUE(fs::is_empty(folder / "exported"));
}

// Exports over an earlier export: into the bake's own folder, or into another one. There the new export is of
// a different bake, so that its files differ.
class ExportOver : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    bake_into(folder_ / "out", {}, 6);
    options_ = {.bake = folder_ / "out", .formats = bake::export_format_names()};
    if (!is_own()) options_.folder = folder_ / GetParam();
    bake::export_bake(options_);
    write_text(target() / "obj/mine.obj", "precious");
    if (!is_own()) {
      bake_into(folder_ / "later", {}, 4);
      options_.bake = folder_ / "later";
      // Scripts of the two bakes differ by their length. Rest meshes do not, so mark this one.
      write_text(target() / "rest.obj", "earlier");
    }
    options_.overwrite = true;
    before_ = content_of(target());
  }
  bool is_own() const { return std::string(GetParam()) == "out"; }
  fs::path target() const { return folder_ / GetParam(); }

  TemporaryFolder folder_;
  bake::ExportOptions options_;
  std::vector<std::pair<std::string, std::string>> before_;
};

TEST_P(ExportOver, InterruptedLeavesTheEarlierOne) {
  std::atomic<bool> interrupted = false;
  options_.interrupted = &interrupted;
  options_.on_frame = [&](std::uint64_t frame, std::uint64_t) { interrupted = frame >= 2; };
  EXPECT_TRUE(bake::export_bake(options_).interrupted);
  EXPECT_EQ(content_of(target()), before_);
  EXPECT_FALSE(fs::exists(target() / "export.part"));
}

TEST_P(ExportOver, FailedLeavesTheEarlierOne) {
  const fs::path cache = options_.bake / "frames.fascicle";
  const std::string whole = read_text(cache);
  std::string text = whole;
  // Damages the frame before the last, because the check for missing frames reads only the last one.
  const std::size_t record = bake::cache_record_bytes(two_tetrahedra().vertex_count);
  text[text.size() - record - record / 2] ^= 1;
  write_text(cache, text);
  EXPECT_NE(refusal([&] { bake::export_bake(options_); }).find("is damaged"), std::string::npos);
  write_text(cache, whole);
  EXPECT_EQ(content_of(target()), before_);
  EXPECT_FALSE(fs::exists(target() / "export.part"));
}

// A folder with that name that no export made belongs to the user.
TEST_P(ExportOver, LeavesAFolderOfItsStagesNameAlone) {
  fs::create_directories(target() / "export.part");
  write_text(target() / "export.part/surface.abc", "precious");
  EXPECT_NE(refusal([&] { bake::export_bake(options_); }).find("but no export made it"), std::string::npos);
  EXPECT_EQ(read_text(target() / "export.part/surface.abc"), "precious");
  // A symbolic link with that name is not followed either.
  fs::rename(target() / "export.part", target() / "own");
  fs::create_symlink(target() / "own", target() / "export.part");
  EXPECT_NE(refusal([&] { bake::export_bake(options_); }).find("move it away"), std::string::npos);
  EXPECT_EQ(read_text(target() / "own/surface.abc"), "precious");
}

TEST_P(ExportOver, ReplacesTheEarlierOneWhole) {
  // Leftovers of a killed export are removed too.
  fs::create_directories(target() / "export.part/obj");
  write_text(target() / "export.part/obj/frame_000001.obj", "half");
  write_text(target() / "export.part/surface.glb.targets.part", "half");
  write_text(target() / "export.part/.fascicle-export", "");
  bake::export_bake(options_);
  EXPECT_EQ(read_text(target() / "obj/mine.obj"), "precious");
  fs::remove(target() / "obj/mine.obj");
  EXPECT_FALSE(fs::exists(target() / "export.part"));
  // The same files as in a new folder; no frame of the longer series is left.
  options_.folder = folder_ / "fresh";
  bake::export_bake(options_);
  const auto fresh = content_of(folder_ / "fresh");
  for (const auto& [name, bytes] : fresh) EXPECT_EQ(read_text(target() / name), bytes) << name;
  if (!is_own()) {
    EXPECT_EQ(content_of(target()).size(), fresh.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Folders, ExportOver, testing::Values("out", "exported"),
                         [](const auto& folder) { return std::string(folder.param); });

}  // namespace
}  // namespace fascicle::tests
