// fascicle render as a user runs it.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

class Render : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome outcome =
        fascicle({"bake", "bar-beta-1", "-o", bake_, "--end", "0.1", "--device", "cpu", "-q"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }
  Outcome render(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"render", bake_});
    arguments.insert(arguments.end(), {"--size", "160x120"});
    return fascicle(arguments);
  }
  // One clear line on stderr, nothing on stdout.
  static void expect_refused(const Outcome& outcome, int status, const std::string& part) {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  static bool is_png(const fs::path& path) { return read_text(path).starts_with("\x89PNG\r\n\x1a\n"); }

  TemporaryFolder folder_;
  std::string bake_ = folder_ / "bake";
};

TEST_F(Render, LeavesTheUsersOwnFilesBesideThePicture) {
  write_text(folder_ / "now.png.tmp", "mine");
  const Outcome outcome = render({"-o", folder_ / "now.png"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(is_png(folder_ / "now.png"));
  EXPECT_EQ(read_text(folder_ / "now.png.tmp"), "mine");
}

TEST_F(Render, EveryModeGivesItsOwnPicture) {
  std::vector<std::string> pictures;
  for (const char* mode : {"shaded", "layers", "fibres", "lag"}) {
    const std::string path = folder_ / (std::string(mode) + ".png");
    const Outcome outcome = render({"-o", path, "--mode", mode});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("wrote " + path), std::string::npos);
    EXPECT_EQ(outcome.out.find("colours") != std::string::npos, std::string(mode) != "shaded") << outcome.out;
    EXPECT_TRUE(is_png(path));
    const std::string bytes = read_text(path);
    EXPECT_EQ(std::count(pictures.begin(), pictures.end(), bytes), 0) << mode;
    pictures.push_back(bytes);
  }
}

// Two boxes, one above the other and not touching yet: the picture has a scale but no marks.
TEST_F(Render, ContactIsDrawnOfWhatHasIt) {
  expect_refused(render({"-o", folder_ / "none.png", "--mode", "contact"}), 2, "set contact.self = true");
  EXPECT_FALSE(fs::exists(folder_.path() / "none.png"));
  const std::string path = folder_ / "contact.png";
  const Outcome outcome = fascicle(
      {"render", "stack", "-o", path, "--mode", "contact", "--lag-scale", "20", "--size", "160x120"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(is_png(path));
  EXPECT_NE(outcome.out.find("20 mm"), std::string::npos) << outcome.out;
}

TEST_F(Render, ThreadsChangeNoByteAndFramesDiffer) {
  const auto bytes = [&](const std::string& name, const std::string& frame, const std::string& threads) {
    const Outcome outcome = render({"-o", folder_ / name, "--frame", frame, "--threads", threads});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return read_text(folder_ / name);
  };
  const std::string one = bytes("one.png", "6", "1");
  EXPECT_EQ(bytes("eight.png", "6", "8"), one);
  EXPECT_NE(bytes("first.png", "0", "1"), one);
}

TEST_F(Render, FolderHoldsAPictureAFrameAndASheetAllOfThem) {
  ASSERT_EQ(render({"-o", folder_ / "frames"}).status, 0);
  for (const char* name : {"0000.png", "0003.png", "0006.png"})
    EXPECT_TRUE(is_png(folder_.path() / "frames" / name));
  EXPECT_FALSE(fs::exists(folder_.path() / "frames/0007.png"));
  expect_refused(render({"-o", folder_ / "frames"}), 2, "--overwrite");
  EXPECT_EQ(render({"-o", folder_ / "frames", "--overwrite"}).status, 0);
  ASSERT_EQ(render({"-o", folder_ / "sheet.png", "--sheet", "3x2"}).status, 0);
  EXPECT_TRUE(is_png(folder_ / "sheet.png"));
}

// A folder holds one run: a shorter one leaves no pictures of a longer one behind, and what else is there
// alone.
TEST_F(Render, AShorterRunTellsOfPicturesBeyondItsLast) {
  const std::string frames = folder_ / "frames";
  ASSERT_EQ(render({"-o", frames}).status, 0);
  for (const char* name : {"0007.png", "0008.png", "0020.png", "7.png", "00009.png"})
    write_text(fs::path(frames) / name, name);
  const Outcome shorter = render({"-o", frames, "--overwrite"});
  ASSERT_EQ(shorter.status, 0);
  EXPECT_TRUE(contains(shorter.err, "also holds 0007.png to 0008.png")) << shorter.err;
  // They may be the user's.
  for (const char* name : {"0007.png", "0008.png", "0020.png", "7.png", "00009.png"})
    EXPECT_EQ(read_text(fs::path(frames) / name), name);
  for (const char* name : {"0000.png", "0006.png"}) EXPECT_TRUE(fs::exists(fs::path(frames) / name)) << name;
}

// The bake has seven frames: a sheet is as wide as they are, not as wide as asked for.
TEST_F(Render, ASheetHasNoEmptyColumns) {
  const auto width = [&](const char* sheet) {
    EXPECT_EQ(render({"-o", folder_ / "sheet.png", "--overwrite", "--sheet", sheet}).status, 0);
    const std::string png = read_text(folder_ / "sheet.png");
    unsigned value = 0;  // bytes 16 to 19, the highest first
    for (std::size_t k = 16; k < 20; ++k) value = 256 * value + static_cast<unsigned char>(png.at(k));
    return value;
  };
  EXPECT_EQ(width("100x1"), 7u * 160u);
  EXPECT_EQ(width("9x3"), 7u * 160u);
  EXPECT_EQ(width("3x2"), 3u * 160u);
}

TEST_F(Render, WrongUseIsOneClearMessageAndWritesNothing) {
  const std::string still = folder_ / "still.png";
  expect_refused(render({"-o", still, "--frame", "7"}), 2, "there are frames 0 to 6");
  expect_refused(render({"-o", still, "--clip", "w=1"}), 2, "x=0.1");
  expect_refused(render({"-o", still, "--clip", "x=nan"}), 2, "not a number");
  expect_refused(render({"-o", still, "--clip", "x=-100"}), 2, "leaves no tetrahedron");
  expect_refused(render({"-o", still, "--sheet", "3"}), 2, "--sheet");
  expect_refused(render({"-o", still, "--sheet", "3x2", "--frame", "1"}), 2, "leave out --frame");
  expect_refused(render({"-o", folder_ / "frames", "--frame", "1"}), 2, ".png");
  expect_refused(fascicle({"render", bake_, "-o", still, "--size", "0x9"}), 2, "--size");
  expect_refused(fascicle({"render", bake_, "-o", still, "--size", "10"}), 2, "--size");
  expect_refused(fascicle({"render", folder_ / "missing", "-o", still}), 3, "missing");
  fs::create_directories(folder_ / "empty");
  expect_refused(fascicle({"render", folder_ / "empty", "-o", still}), 3, "holds no bake");
  EXPECT_FALSE(fs::exists(still));
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
  write_text(still, "mine");
  expect_refused(render({"-o", still}), 2, "--overwrite");
  EXPECT_EQ(read_text(still), "mine");
}

// Whatever its case, .png is a picture; names of other pictures and films are mistakes, unless the folder is
// there or the name ends in a slash.
TEST_F(Render, TheNameSaysWhetherItIsAPicture) {
  ASSERT_EQ(render({"-o", folder_ / "A.PNG", "--frame", "0"}).status, 0);
  EXPECT_TRUE(is_png(folder_ / "A.PNG"));
  for (const char* name : {"a.jpg", "a.JPG", "a.Mov", "a.avi", "a.webm", "a.svg", "a.heic"}) {
    expect_refused(render({"-o", folder_ / name}), 2, "pictures are PNG");
    EXPECT_FALSE(fs::exists(folder_ / name)) << name;
  }
  ASSERT_EQ(render({"-o", folder_ / "one.mov/"}).status, 0);
  EXPECT_TRUE(is_png(folder_ / "one.mov/0000.png"));
  fs::create_directories(folder_ / "two.gif");
  ASSERT_EQ(render({"-o", folder_ / "two.gif"}).status, 0);
  EXPECT_TRUE(is_png(folder_ / "two.gif/0006.png"));
  // No picture's extension.
  ASSERT_EQ(render({"-o", folder_ / "shot.v2"}).status, 0);
  EXPECT_TRUE(is_png(folder_ / "shot.v2/0000.png"));
}

TEST_F(Render, BakeWithoutItsModelOrFramesSaysSo) {
  fs::rename(fs::path(bake_) / "model.fascicle", folder_ / "model");
  expect_refused(render({"-o", folder_ / "a.png"}), 3, "model.fascicle");
  fs::rename(folder_ / "model", fs::path(bake_) / "model.fascicle");
  fs::remove(fs::path(bake_) / "frames.fascicle");
  expect_refused(render({"-o", folder_ / "a.png"}), 3, "frames.fascicle");
}

// A bake whose mesh is gone: pictures and reports show the body without the solids of its scene, and say so.
TEST(RenderSolids, OfASceneThatCannotBeReadAgainAreLeftOut) {
  const TemporaryFolder folder;
  // A tetrahedron above a slope.
  write_text(folder / "body.mesh",
             "MeshVersionFormatted 1\nDimension 3\nVertices 4\n0 0 0 0\n0.2 0 0 0\n0 0.2 0 0\n0 0 0.2 0\n"
             "Tetrahedra 1\n1 2 3 4 0\nEnd\n");
  write_text(folder / "scene.toml",
             "[mesh]\nfile = \"body.mesh\"\n[layers.flesh]\n"
             "[collider.ramp]\nshape = \"plane\"\ncenter = [0, -0.1, 0]\nnormal = [0, 1, 0.3]\n");
  const std::string bake = folder / "bake", picture = folder / "picture.png", page = folder / "page.html";
  const Outcome baked =
      fascicle({"bake", folder / "scene.toml", "-o", bake, "--end", "0.1", "--device", "cpu", "-q"});
  ASSERT_EQ(baked.status, 0) << baked.err;
  const auto render = [&] {
    return fascicle({"render", bake, "-o", picture, "--overwrite", "--size", "160x120"});
  };
  ASSERT_EQ(render().status, 0);
  const std::string with = read_text(picture);
  fs::remove(folder / "body.mesh");
  const Outcome outcome = render();
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "solids are not shown: ")) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "body.mesh")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(read_text(picture), with);
  const Outcome reported = fascicle({"report", bake, "-o", page});
  ASSERT_EQ(reported.status, 0) << reported.err;
  EXPECT_TRUE(contains(read_text(page), "solids are not shown: "));
}

TEST_F(Render, SceneGivesItsRestPose) {
  const Outcome outcome = fascicle(
      {"render", "bar-layers-iii", "-o", folder_ / "rest.png", "--mode", "layers", "--size", "160x120"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(is_png(folder_ / "rest.png"));
}

}  // namespace
}  // namespace fascicle::tests
