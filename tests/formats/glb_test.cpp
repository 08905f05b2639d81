// surface.glb of a generated character: its skeleton, skin and morph targets together show the baked surface.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/bake/bake.h"
#include "host/bake/export.h"
#include "host/bake/read_frame_cache.h"
#include "host/base/errors.h"
#include "host/formats/formats.h"
#include "host/formats/glb_document.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/gltf/gltf_rig.h"
#include "host/rig/pose.h"
#include "tests/bake/fake_solver.h"
#include "tests/formats/dressed_model.h"
#include "tests/formats/jointed_body.h"
#include "tests/formats/sink_frames.h"
#include "tests/support/readers.h"

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using scene::Vector3d;

// A float accessor without a view: zeros, overwritten by its sparse part.
std::vector<float> sparse(const GlbChunks& glb, std::size_t number, std::size_t width) {
  const json& accessor = glb.document["accessors"][number];
  EXPECT_FALSE(accessor.contains("bufferView"));
  std::vector<float> values(accessor["count"].get<std::size_t>() * width, 0.0f);
  const json& part = accessor["sparse"];
  const auto start = [&](const json& of) {
    const json& view = glb.document["bufferViews"][of["bufferView"].get<std::size_t>()];
    return view["byteOffset"].get<std::size_t>() + of.value("byteOffset", std::size_t{0});
  };
  const std::size_t indices = start(part["indices"]), replaced = start(part["values"]);
  for (std::size_t k = 0; k < part["count"]; ++k) {
    const auto at = read_value<std::uint32_t>(glb.binary, indices + 4 * k);
    for (std::size_t c = 0; c < width; ++c)
      values.at(width * at + c) = read_value<float>(glb.binary, replaced + 4 * (width * k + c));
  }
  return values;
}

Vector3d vector_at(const std::vector<float>& values, std::size_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// Checks what a viewer shows with weight `target` at 1, at the time of the frame.
void expect_baked_surface(const fs::path& folder, std::size_t target, std::uint64_t frame) {
  const model::Model model = jointed_model();
  const GlbChunks glb = read_glb(folder / "surface.glb");
  const json& primitive = glb.document["meshes"][0]["primitives"][0];
  const std::vector<float> moves = sparse(glb, primitive["targets"][target]["POSITION"], 3);
  const std::vector<float> turns = sparse(glb, primitive["targets"][target]["NORMAL"], 3);
  const gltf::Rig rig = gltf::read_rig(folder / "surface.glb");
  ASSERT_EQ(rig.parts.size(), 1u);
  const gltf::RigPart& part = rig.parts[0];
  const std::vector<Eigen::Matrix4d> joints =
      rig::joint_transforms_at(rig.character, &rig.character.clips.at(0), static_cast<double>(frame) / 24.0);
  const model::Frame baked = bake::FrameCacheReader(folder / "frames.fascicle").read(frame);
  const std::vector<float> surface = formats::embed(model, baked.positions);
  const std::vector<float> points = formats::world_positions(surface, model.unit, baked.origin);
  const std::vector<float> normals = formats::SurfaceNormals(model).of(surface);
  std::vector<Vector3d> shown;
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Matrix4d blend = Eigen::Matrix4d::Zero();
    for (std::size_t k = part.influence_offset[i]; k < part.influence_offset[i + 1]; ++k)
      blend += part.weight[k] * joints[part.skin_joint[part.slot[k]]] * part.inverse_bind[part.slot[k]];
    const Vector3d morphed = part.positions[i] + vector_at(moves, i);
    shown.push_back(blend.topLeftCorner<3, 3>() * morphed + blend.topRightCorner<3, 1>());
    // Floats of about 10 m in the file, a blend and its inverse: some units of 1e-6 m. Omitted moves are
    // below 1e-6 of a diagonal of half a metre.
    EXPECT_NEAR((shown.back() - vector_at(points, i)).norm(), 0.0, 1e-5) << "vertex " << i;
    const Vector3d normal =
        (blend.topLeftCorner<3, 3>() * (part.normals[i] + vector_at(turns, i))).normalized();
    // The only triangle is flat, so the normal in the file is the face normal. Changes under 0.004 are
    // omitted, and a blend of two rotations does not preserve angles.
    EXPECT_GT(normal.dot(vector_at(normals, i)), 0.97) << "vertex " << i;
  }
}

TEST(Glb, SkeletonAndTargetsTogetherAreTheBake) {
  const TemporaryFolder folder;
  bake_jointed(options_for(folder / "out"), 6);
  const GlbChunks glb = read_glb(folder / "out/surface.glb");
  EXPECT_EQ(glb.document["meshes"][0]["extras"]["targetNames"].size(), 7u);
  EXPECT_EQ(glb.document["meshes"][0]["extras"]["targetNames"][3], "frame 3");
  EXPECT_EQ(glb.document["extras"]["fascicle"]["fps"], 24.0);
  EXPECT_EQ(glb.document["extras"]["fascicle"]["first_frame_seconds"], 0.5);
  // Two channels of the skeleton, and the weights: 1 if key and target belong to the same frame, else 0.
  const json& animation = glb.document["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 3u);
  EXPECT_EQ(animation["channels"][2]["target"]["path"], "weights");
  const std::vector<float> weights = sparse(glb, animation["samplers"][2]["output"], 1);
  ASSERT_EQ(weights.size(), 49u);
  for (std::size_t i = 0; i < 49; ++i) EXPECT_EQ(weights[i], i % 8 == 0 ? 1.0f : 0.0f);
  for (std::size_t k = 0; k < 7; ++k) expect_baked_surface(folder / "out", k, k);
}

TEST(Glb, StrideLeavesFramesOutAndKeepsTheLast) {
  const TemporaryFolder folder;
  bake::BakeOptions options = options_for(folder / "out");
  options.glb.stride = 4;
  bake_jointed(options, 6);
  const GlbChunks glb = read_glb(folder / "out/surface.glb");
  EXPECT_EQ(glb.document["meshes"][0]["extras"]["targetNames"],
            (std::vector<std::string>{"frame 0", "frame 4", "frame 6"}));
  expect_baked_surface(folder / "out", 1, 4);
  expect_baked_surface(folder / "out", 2, 6);
  EXPECT_LT(fs::file_size(folder / "out/surface.glb"),
            formats::format_named("glb").bytes(jointed_model(), 3));
}

// The largest distance in m between what a viewer shows and the bake, over all frames: from the file alone
// and from the frame cache.
double error_of_viewer(const fs::path& folder, std::uint64_t frames) {
  const model::Model model = jointed_model();
  const GlbChunks glb = read_glb(folder / "surface.glb");
  const json& primitive = glb.document["meshes"][0]["primitives"][0];
  std::vector<std::uint64_t> keys;
  std::vector<std::vector<float>> moves;
  for (const std::string name : glb.document["meshes"][0]["extras"]["targetNames"]) {
    moves.push_back(sparse(glb, primitive["targets"][keys.size()]["POSITION"], 3));
    keys.push_back(std::stoull(name.substr(6)));
  }
  const gltf::Rig rig = gltf::read_rig(folder / "surface.glb");
  const gltf::RigPart& part = rig.parts.at(0);
  double largest = 0.0;
  std::size_t key = 0;
  for (std::uint64_t k = 0; k <= frames; ++k) {
    while (key + 2 < keys.size() && keys[key + 1] <= k) ++key;
    const double share = static_cast<double>(k - keys[key]) / static_cast<double>(keys[key + 1] - keys[key]);
    const std::vector<Eigen::Matrix4d> joints =
        rig::joint_transforms_at(rig.character, &rig.character.clips.at(0), static_cast<double>(k) / 24.0);
    const model::Frame baked = bake::FrameCacheReader(folder / "frames.fascicle").read(k);
    const std::vector<float> points =
        formats::world_positions(formats::embed(model, baked.positions), model.unit, baked.origin);
    for (std::size_t i = 0; i < 3; ++i) {
      Eigen::Matrix4d blend = Eigen::Matrix4d::Zero();
      for (std::size_t s = part.influence_offset[i]; s < part.influence_offset[i + 1]; ++s)
        blend += part.weight[s] * joints[part.skin_joint[part.slot[s]]] * part.inverse_bind[part.slot[s]];
      const Vector3d morphed =
          part.positions[i] + (1.0 - share) * vector_at(moves[key], i) + share * vector_at(moves[key + 1], i);
      const Vector3d shown = blend.topLeftCorner<3, 3>() * morphed + blend.topRightCorner<3, 1>();
      largest = std::max(largest, (shown - vector_at(points, i)).norm());
    }
  }
  return largest;
}

// Floats of about 10 m in the frame cache's points and in the file.
constexpr double rounding = 1e-5;

TEST(Glb, StrideSaysHowFarAViewerIsOff) {
  const TemporaryFolder folder;
  bake::BakeOptions options = options_for(folder / "out");
  options.glb.stride = 5;
  const model::Model model = jointed_model();
  FakeSolver solver(model);
  const bake::BakeResult result = bake::bake(jointed_scene(12), model, solver, options);
  ASSERT_EQ(result.report.notes.size(), 1u);
  EXPECT_NE(result.report.notes[0].find("4 morph targets for 13 frames"), std::string::npos)
      << result.report.notes[0];
  EXPECT_TRUE(result.report.warnings.empty());
  const double said =
      read_glb(folder / "out/surface.glb").document["extras"]["fascicle"]["interpolation_error"];
  EXPECT_GT(said, 10 * rounding);
  EXPECT_NEAR(error_of_viewer(folder / "out", 12), said, rounding);
}

TEST(Glb, ErrorChoosesTheFrames) {
  std::size_t targets_before = 14;
  for (const double bound : {1e-4, 0.01, 1000.0}) {
    const TemporaryFolder folder;
    bake::BakeOptions options = options_for(folder / "out");
    options.glb.error = bound;
    bake_jointed(options, 12);
    const GlbChunks glb = read_glb(folder / "out/surface.glb");
    const std::size_t targets = glb.document["meshes"][0]["extras"]["targetNames"].size();
    EXPECT_LT(targets, targets_before) << bound;
    targets_before = targets;
    EXPECT_LE(error_of_viewer(folder / "out", 12), bound + rounding);
    EXPECT_LE(glb.document["extras"]["fascicle"]["interpolation_error"], bound);
  }
  EXPECT_EQ(targets_before, 2u);
}

// The baked targets replace those of the meshes that they belong to, and no others.
TEST(Glb, OtherMeshesKeepTheirMorphTargets) {
  json document = json::parse(R"({
      "nodes": [{"mesh": 0}, {"mesh": 1}, {}],
      "animations": [
        {"name": "baked", "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]},
        {"name": "walk", "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}},
                                      {"sampler": 1, "target": {"node": 1, "path": "weights"}},
                                      {"sampler": 2, "target": {"node": 2, "path": "rotation"}}]},
        {"name": "talk", "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]}]})");
  formats::drop_weight_channels(document, {0, 0}, 1);
  const json& animations = document["animations"];
  ASSERT_EQ(animations.size(), 2u);
  EXPECT_TRUE(animations[0]["channels"].empty()) << "the first is kept, for the baked targets";
  ASSERT_EQ(animations[1]["channels"].size(), 2u);
  EXPECT_EQ(animations[1]["channels"][0]["target"]["node"], 1);
  EXPECT_EQ(animations[1]["channels"][1]["target"]["path"], "rotation");
}

TEST(Glb, TooManyTargetsForBrowsersAreSaid) {
  for (const std::uint64_t stride : {1u, 2u}) {
    const TemporaryFolder folder;
    bake::BakeOptions options = options_for(folder / "out");
    options.formats = {"glb"};
    options.glb.stride = stride;
    const model::Model model = jointed_model();
    FakeSolver solver(model);
    const bake::BakeResult result = bake::bake(jointed_scene(300), model, solver, options);
    ASSERT_EQ(result.report.warnings.size(), stride == 1 ? 1u : 0u);
    if (stride == 2) continue;
    EXPECT_NE(result.report.warnings[0].find("301 morph targets"), std::string::npos)
        << result.report.warnings[0];
  }
}

// All primitives of a mesh get the targets, also lines that are not of the body.
TEST(Glb, MoreTargetsThanAFileShouldListAreRefused) {
  const TemporaryFolder folder;
  constexpr std::size_t lines = std::size_t{1} << 17u;
  write_dressed(folder / "character.glb", [](gltf::GltfDocument& document) {
    json& primitives = document.json["meshes"][0]["primitives"];
    // Not skinned: a skinned mesh has triangles only.
    document.json["nodes"][0]["children"] = {1};
    document.json["nodes"][1].erase("skin");
    document.json["scenes"][0]["nodes"] = {0, 2};
    json line = primitives[0];
    line["mode"] = 3;
    for (std::size_t k = 0; k < lines; ++k) primitives.push_back(line);
  });
  const model::Model model = dressed_model();
  const auto refusal = [&](const formats::GlbOptions& options) -> std::string {
    try {
      formats::format_named("glb").make()->begin({.model = &model,
                                                  .folder = folder / "",
                                                  .scene_name = "a",
                                                  .frames = 60,
                                                  .character = folder / "character.glb",
                                                  .glb = options});
    } catch (const base::BakeError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(refusal({}).find("131075 primitives, too many for 61 morph targets"), std::string::npos)
      << refusal({});
  EXPECT_EQ(refusal({.stride = 2}), "") << "31 targets of each are fewer than 2^22";
}

TEST(Glb, ToleranceLeavesVerticesToSkinning) {
  const TemporaryFolder folder;
  bake::BakeOptions options = options_for(folder / "out");
  options.glb.tolerance = 1000.0;
  bake_jointed(options, 6);
  const GlbChunks glb = read_glb(folder / "out/surface.glb");
  const json& targets = glb.document["meshes"][0]["primitives"][0]["targets"];
  for (const json& target : targets)
    for (const float value : sparse(glb, target["POSITION"], 3)) EXPECT_EQ(value, 0.0f);
}

TEST(Glb, OfACharacterResumesAndExportsToTheSameBytes) {
  const TemporaryFolder folder;
  bake_jointed(options_for(folder / "whole"), 6);
  std::atomic<bool> interrupted = false;
  bake::BakeOptions options = options_for(folder / "cut");
  options.interrupted = &interrupted;
  {
    const model::Model model = jointed_model();
    FakeOptions fake;
    fake.on_submit = [&](std::uint64_t frame) { interrupted = frame >= 3; };
    FakeSolver solver(model, fake);
    bake::bake(jointed_scene(6), model, solver, options);
  }
  EXPECT_FALSE(fs::exists(folder / "cut/surface.glb"));
  options.interrupted = nullptr;
  options.resume = true;
  bake_jointed(options, 6);
  EXPECT_EQ(content_of(folder / "cut"), content_of(folder / "whole"));
  bake::export_bake({.bake = folder / "whole", .folder = folder / "exported", .formats = {"glb"}});
  EXPECT_EQ(read_text(folder / "exported/surface.glb"), read_text(folder / "whole/surface.glb"));
}

TEST(Glb, OfACharacterMadeInCodeIsValid) {
  FASCICLE_NEEDS_NODE_READERS;
  const TemporaryFolder folder;
  bake_jointed(options_for(folder / "out"), 6);
  for (const char* name : {"out/surface.glb", "out/character.glb"}) {
    const std::string command = "node '" + (node_readers() / "validate_gltf.mjs").string() + "' '" +
                                (folder / name).string() + "' > '" + (folder / "report.json").string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    const json report = json::parse(read_text(folder / "report.json"));
    EXPECT_EQ(report["issues"]["numErrors"], 0) << name << '\n' << report["issues"].dump(1);
    EXPECT_EQ(report["info"]["hasSkins"], true);
  }
}

}  // namespace
}  // namespace fascicle::tests
