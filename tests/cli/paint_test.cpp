// Paint from its own file and paint in the character give the same bake; a bake with other paint is not
// resumed.
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/gltf/gltf.h"
#include "host/scene/paint_file.h"
#include "tests/cli/program.h"

namespace fascicle::tests::paint_test {
namespace {

using nlohmann::json;

// The built-in bear as a file, painted by position.
class PaintCommand : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome bear =
        fascicle({"bake", "crouch", "-o", folder_ / "made", "--end", "0.02", "--hold", "0", "--device", "cpu",
                  "--set", "character.resolution=0.12", "--set", "contact.self=false"});
    ASSERT_EQ(bear.status, 0) << bear.err;
    bear_ = folder_ / "made/character.glb";
    character_ = gltf::read_gltf(bear_);
  }

  std::string write_paint(const std::string& name, bool with_stiffness, double height) const {
    rig::Paint paint{rig::surface_hash(character_.surface), character_.surface.vertices.size(), {}};
    rig::PaintedVertices rigid{"_RIGID", {}, {}}, layer{"_LAYER", {}, {}}, stiffness{"_STIFFNESS", {}, {}};
    for (std::uint32_t v = 0; v < paint.vertices; ++v) {
      const rig::Vector3d& p = character_.surface.vertices[v];
      if (p[1] > 1.4) rigid.vertex.push_back(v), rigid.value.push_back(1.0f);
      if (p[1] < height) layer.vertex.push_back(v), layer.value.push_back(p[0] > 0.0 ? 3.0f : 2.0f);
      if (p[1] < height) stiffness.vertex.push_back(v), stiffness.value.push_back(0.37f);
    }
    paint.attributes = {rigid, layer};
    if (with_stiffness) paint.attributes.push_back(stiffness);
    write_text(folder_.path() / name, scene::paint_text(paint));
    return folder_ / name;
  }

  // Writes a scene and bakes it; returns its position hashes.
  json hashes_of(const std::string& name, const std::string& character) const {
    write_text(folder_.path() / (name + ".toml"), "[scene]\nend = 0.05\n[character]\n" + character +
                                                      "\nresolution = 0.12\n[motion]\npreroll = 0.1\n");
    const Outcome outcome = fascicle(
        {"bake", folder_ / (name + ".toml"), "-o", folder_ / name, "--device", "cpu", "--overwrite"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return json::parse(read_text(folder_.path() / name / "manifest.json"), nullptr, false)["position_hashes"];
  }

  TemporaryFolder folder_;
  std::string bear_;
  rig::Character character_;
};

TEST_F(PaintCommand, TheFileAndThePaintedCharacterHaveTheSameBits) {
  const json bare = hashes_of("bare", "file = \"made/character.glb\"");
  for (const bool with_stiffness : {false, true}) {
    SCOPED_TRACE(with_stiffness);
    const std::string paint = write_paint("bear.paint.json", with_stiffness, 0.8);
    const Outcome outcome = fascicle({"paint", bear_, paint, "-o", folder_ / "painted.glb", "--overwrite"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(contains(outcome.out, "_LAYER on ")) << outcome.out;
    const json from_file =
        hashes_of("from-file", "file = \"made/character.glb\"\npaint = \"bear.paint.json\"");
    const json from_glb = hashes_of("from-glb", "file = \"painted.glb\"");
    ASSERT_GE(from_file.size(), 2u);
    EXPECT_EQ(from_file, from_glb);
    EXPECT_NE(from_file, bare) << "the control: paint changes the bake";
  }
}

// A factor of 1 changes no bit, in the solver that the character has without paint; 4 and 0.5 do act.
TEST_F(PaintCommand, AStiffnessOfOneChangesNothing) {
  const auto painted = [&](float factor) {
    rig::PaintedVertices stiffness{"_STIFFNESS", {}, {}};
    for (std::uint32_t v = 0; v < character_.surface.vertices.size(); ++v)
      stiffness.vertex.push_back(v), stiffness.value.push_back(factor);
    write_text(folder_.path() / "all.json",
               scene::paint_text(
                   {rig::surface_hash(character_.surface), character_.surface.vertices.size(), {stiffness}}));
    return hashes_of("all", "file = \"made/character.glb\"\npaint = \"all.json\"");
  };
  const json bare = hashes_of("bare", "file = \"made/character.glb\"");
  ASSERT_GE(bare.size(), 2u);
  EXPECT_EQ(painted(1.0f), bare);
  EXPECT_NE(painted(4.0f), bare);
  EXPECT_NE(painted(0.5f), bare);
}

TEST_F(PaintCommand, ABakeGoesOnWithItsOwnPaintAlone) {
  const std::string character = "file = \"made/character.glb\"\npaint = \"bear.paint.json\"";
  write_paint("bear.paint.json", false, 0.8);
  hashes_of("bear", character);
  const std::vector<std::string> resume{
      "bake", folder_ / "bear.toml", "-o", folder_ / "bear", "--device", "cpu", "--resume", "--end", "0.1"};
  write_paint("bear.paint.json", false, 0.7);
  const Outcome other = fascicle(resume);
  EXPECT_EQ(other.status, 3);
  EXPECT_TRUE(contains(other.err, "the content of bear.paint.json was ")) << other.err;
  write_paint("bear.paint.json", false, 0.8);
  const Outcome same = fascicle(resume);
  EXPECT_EQ(same.status, 0) << same.err;
}

TEST_F(PaintCommand, RefusesWhatItCannotWrite) {
  const std::string paint = write_paint("bear.paint.json", false, 0.8);
  EXPECT_EQ(fascicle({"paint", bear_, paint}).status, 2);
  EXPECT_EQ(fascicle({"paint", bear_, paint, "-o", folder_ / "bear.png"}).status, 2);
  EXPECT_EQ(fascicle({"paint", bear_, paint, "-o", folder_ / "nowhere/bear.glb"}).status, 3);
  EXPECT_EQ(fascicle({"paint", paint, paint, "-o", folder_ / "bear.glb"}).status, 2);
  EXPECT_EQ(fascicle({"paint", bear_, folder_ / "nowhere.json", "-o", folder_ / "bear.glb"}).status, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "bear.glb"));
  ASSERT_EQ(fascicle({"paint", bear_, paint, "-o", folder_ / "bear.glb"}).status, 0);
  EXPECT_EQ(fascicle({"paint", bear_, paint, "-o", folder_ / "bear.glb"}).status, 2) << "the output exists";
}

}  // namespace
}  // namespace fascicle::tests::paint_test
