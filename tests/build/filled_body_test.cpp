// What a filled body is kept under, and that bytes which hold none are refused.
#include "host/build/filled_body.h"

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace fascicle::tests {
namespace {

// Bytes with a valid checksum can still be foreign or malicious.
class FilledBodyTest : public testing::Test {
 protected:
  void SetUp() override {
    body_.mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    body_.mesh.tetrahedra = {{0, 1, 2, 3}, {1, 2, 3, 4}};
    body_.skin.offset = {0, 1, 2, 3, 4, 6};
    body_.skin.joint = {0, 0, 1, 1, 0, 1};
    body_.skin.weight = {1, 1, 1, 1, 0.5, 0.5};
    body_.render.corners = {{0, 1, 2, 3}, {4, 4, 4, 4}, {1, 1, 1, 1}};
    body_.render.weights = {{0.25, 0.25, 0.25, 0.25}, {1, 0, 0, 0}, {1, 0, 0, 0}};
    found_.warnings = {{"a warning", {3, 4}}};
    found_.fill.least_barycentric = -0.03;
    character_.skeleton.resize(2);
    surface_.vertices.resize(3);
    surface_.triangles = {{0, 1, 2}};
  }

  bool reads(const std::string& bytes) {
    read_ = {};
    found_again_ = {};
    return build::read_filled_body(bytes, {scene_, surface_, welded_, bones_, &character_}, read_,
                                   found_again_);
  }
  void expect_refused(const std::function<void(build::FilledBody&)>& spoil, const char* what) {
    build::FilledBody spoilt = body_;
    spoil(spoilt);
    EXPECT_FALSE(reads(build::filled_body_bytes(spoilt, found_))) << what;
  }

  build::FilledBody body_, read_;
  build::Report found_, found_again_;
  scene::Scene scene_;
  rig::Character character_;
  mesh::SurfaceMesh surface_;
  build::WeldedSurface welded_;
  std::vector<build::Bone> bones_;
};

// The cut reads the clips, so other poses give another body.
TEST_F(FilledBodyTest, IsKeptUnderItsClips) {
  const auto key = [&] {
    return build::fill_key({scene_, surface_, welded_, bones_, &character_}, "programs");
  };
  const std::string still = key();
  rig::Clip& clip = character_.clips.emplace_back();
  clip.duration = 1.0;
  clip.channels.push_back(
      {0, rig::ChannelPath::translation, rig::Interpolation::linear, {0.0, 1.0}, {0, 0, 0, 1, 0, 0}});
  const std::string moving = key();
  EXPECT_NE(moving, still);
  clip.name = "a name that nothing reads";
  EXPECT_EQ(key(), moving);
  clip.channels[0].values[3] = 2.0;
  EXPECT_NE(key(), moving);
}

// Everything that the filling reads is in the key: with one left out, another body would be taken for this
// one.
TEST_F(FilledBodyTest, IsKeptUnderAllThatItIsMadeOf) {
  welded_.surface.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  welded_.surface.triangles = {{0, 1, 2}};
  welded_.of_vertex = {0, 1, 2};
  welded_.file_vertex = {0, 1, 2};
  bones_.resize(1);
  character_.joints.resize(3);
  character_.weights.resize(3);
  struct Input {
    scene::Scene scene;
    mesh::SurfaceMesh surface;
    build::WeldedSurface welded;
    std::vector<build::Bone> bones;
    rig::Character character;
    std::string programs = "programs";
    bool is_character = true;
  };
  const Input as_it_is{scene_, surface_, welded_, bones_, character_};
  const std::vector<std::pair<const char*, std::function<void(Input&)>>> changes{
      {"the programs", [](Input& in) { in.programs = "others"; }},
      {"the resolution", [](Input& in) { in.scene.resolution = 0.25; }},
      {"the cage", [](Input& in) { in.scene.body.cage = scene::Cage::wrap; }},
      {"the cage's detail", [](Input& in) { in.scene.body.cage_detail *= 2.0; }},
      {"the number of vertices", [](Input& in) { in.scene.body.vertices = 500; }},
      {"the thickness", [](Input& in) { in.scene.body.thickness = 0.01; }},
      {"a vertex", [](Input& in) { in.welded.surface.vertices[2][1] = 1.5; }},
      {"a triangle of the welded surface",
       [](Input& in) {
         in.welded.surface.triangles = {{1, 2, 0}};
       }},
      {"where a vertex was welded", [](Input& in) { in.welded.of_vertex[2] = 1; }},
      {"the numbers in the file", [](Input& in) { in.welded.file_vertex[2] = 7; }},
      {"a triangle",
       [](Input& in) {
         in.surface.triangles = {{1, 2, 0}};
       }},
      {"one bone more", [](Input& in) { in.bones.emplace_back(); }},
      {"the end of a bone", [](Input& in) { in.bones[0].to[2] = 0.5; }},
      {"the owner of a bone", [](Input& in) { in.bones[0].owners[1] = 1; }},
      {"no character", [](Input& in) { in.is_character = false; }},
      {"one joint more", [](Input& in) { in.character.skeleton.emplace_back(); }},
      {"a joint's parent", [](Input& in) { in.character.skeleton[1].parent = 0; }},
      {"a vertex's joints", [](Input& in) { in.character.joints[1][3] = 1; }},
      {"a vertex's weights", [](Input& in) { in.character.weights[1][3] = 0.5; }}};
  const auto key = [](const Input& in) {
    const rig::Character* character = in.is_character ? &in.character : nullptr;
    return build::fill_key({in.scene, in.surface, in.welded, in.bones, character}, in.programs);
  };
  std::map<std::string, const char*> of_key{{key(as_it_is), "nothing"}};
  EXPECT_EQ(key(Input(as_it_is)), key(as_it_is));
  for (const auto& [what, change] : changes) {
    Input changed = as_it_is;
    change(changed);
    const auto [found, is_new] = of_key.emplace(key(changed), what);
    EXPECT_TRUE(is_new) << what << " has the key of " << found->second;
  }
}

TEST_F(FilledBodyTest, ComesBackWhole) {
  ASSERT_TRUE(reads(build::filled_body_bytes(body_, found_)));
  EXPECT_EQ(read_.mesh.vertices, body_.mesh.vertices);
  EXPECT_EQ(read_.mesh.tetrahedra, body_.mesh.tetrahedra);
  EXPECT_EQ(read_.skin.offset, body_.skin.offset);
  EXPECT_EQ(read_.skin.joint, body_.skin.joint);
  EXPECT_EQ(read_.skin.weight, body_.skin.weight);
  EXPECT_EQ(read_.render.corners, body_.render.corners);
  EXPECT_EQ(read_.render.weights, body_.render.weights);
  EXPECT_EQ(read_.render.triangles, surface_.triangles);
  ASSERT_EQ(found_again_.warnings.size(), 1u);
  EXPECT_EQ(found_again_.warnings[0].text, "a warning");
  EXPECT_EQ(found_again_.warnings[0].vertices, (std::vector<std::uint32_t>{3, 4}));
  EXPECT_EQ(found_again_.fill.least_barycentric, -0.03);
}

TEST_F(FilledBodyTest, RefusesEveryShorterAndLongerText) {
  const std::string good = build::filled_body_bytes(body_, found_);
  for (std::size_t k = 0; k < good.size(); ++k) EXPECT_FALSE(reads(good.substr(0, k))) << k;
  EXPECT_FALSE(reads(good + '\0'));
}

TEST_F(FilledBodyTest, NoByteCanMakeItCrash) {
  const std::string good = build::filled_body_bytes(body_, found_);
  // Every byte at its extremes; this covers the lengths of all arrays, up to 2^64 - 1.
  for (std::size_t k = 0; k < good.size(); ++k)
    for (const char value : {'\x00', '\x7f', '\x80', '\xff'}) {
      std::string bad = good;
      bad[k] = value;
      if (!reads(bad)) continue;
      // Accepted data must be safe to use.
      for (const auto& t : read_.mesh.tetrahedra)
        for (const std::uint32_t corner : t) ASSERT_LT(corner, read_.mesh.vertices.size());
      for (const std::uint32_t joint : read_.skin.joint) ASSERT_LT(joint, 2u);
      ASSERT_EQ(found_again_.fill.cage.ends.fate.size(), found_again_.fill.cage.ends.vertex.size());
    }
}

TEST_F(FilledBodyTest, RefusesWhatTheBuildCouldNotRelyOn) {
  expect_refused([](auto& b) { b.mesh.tetrahedra[1][3] = 5; }, "corner out of range");
  expect_refused([](auto& b) { std::swap(b.mesh.tetrahedra[0][0], b.mesh.tetrahedra[0][1]); }, "inside out");
  expect_refused([](auto& b) { b.mesh.vertices[4][0] = NAN; }, "not finite");
  expect_refused([](auto& b) { b.mesh.vertices.push_back({9, 9, 9}); }, "an unused vertex");
  expect_refused([](auto& b) { b.skin.joint[3] = 2; }, "joint out of range");
  expect_refused([](auto& b) { b.skin.weight[4] = 0.75; }, "weights that sum to more than 1");
  expect_refused([](auto& b) { b.skin.weight[0] = NAN; }, "a weight that is not a number");
  expect_refused([](auto& b) { b.skin.offset[2] = 1; }, "a vertex without joints");
  expect_refused([](auto& b) { b.skin.offset[2] = 0xffffffffu; }, "an offset beyond the end");
  expect_refused([](auto& b) { b.skin = {}; }, "no weights for a character");
  expect_refused([](auto& b) { b.render.corners[0][2] = 5; }, "a rider on nothing");
  expect_refused([](auto& b) { b.render.weights[1][0] = INFINITY; }, "a rider at infinity");
  expect_refused([](auto& b) { b.render.corners.pop_back(); }, "a rider too few");
}

// The report reads an entry of each array per end.
TEST_F(FilledBodyTest, RefusesEndsOfUnequalArrays) {
  build::OpenEnds& ends = found_.fill.cage.ends;
  ends = {.vertex = {0, 2}, .edges = {3, 4}, .joint = {1, -1}, .width = {0.5, 0.25}, .fate = {0, 1}};
  ASSERT_TRUE(reads(build::filled_body_bytes(body_, found_)));
  EXPECT_EQ(found_again_.fill.cage.ends.width, ends.width);
  const auto expect_ends_refused = [&](const std::function<void(build::OpenEnds&)>& spoil, const char* what) {
    build::Report spoilt = found_;
    spoil(spoilt.fill.cage.ends);
    EXPECT_FALSE(reads(build::filled_body_bytes(body_, spoilt))) << what;
  };
  expect_ends_refused([](auto& e) { e.vertex.resize(200'000); }, "vertices without the rest");
  expect_ends_refused([](auto& e) { e.edges.pop_back(); }, "an edge count too few");
  expect_ends_refused([](auto& e) { e.joint.pop_back(); }, "a joint too few");
  expect_ends_refused([](auto& e) { e.width.push_back(1.0); }, "a width too many");
  expect_ends_refused([](auto& e) { e.fate.clear(); }, "no fates");
}

}  // namespace
}  // namespace fascicle::tests
