// Skin weights: the artist's on the surface, harmonic inside.
#include "host/build/skin_weights.h"

#include <cmath>
#include <numeric>
#include <span>

#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/boundary.h"
#include "tests/build/scenes.h"
#include "tests/build/surfaces.h"

namespace fascicle::tests {
namespace {

using scene::Vector3d;

// A bar whose surface vertices come first, as tetrahedralize() returns them.
struct SurfaceFirst {
  mesh::TetMesh mesh;
  std::size_t surface_count = 0;
};

SurfaceFirst bar_surface_first(const scene::Bar& bar) {
  const mesh::TetMesh given = build::make_bar(bar, "test");
  std::vector<char> outside(given.vertices.size(), 0);
  for (const auto& t : build::boundary_triangles(given, "test"))
    for (const std::uint32_t corner : t) outside[corner] = 1;
  SurfaceFirst result;
  std::vector<std::uint32_t> number(given.vertices.size());
  for (const char wanted : {char{1}, char{0}}) {
    for (std::size_t i = 0; i < given.vertices.size(); ++i)
      if (outside[i] == wanted) {
        number[i] = static_cast<std::uint32_t>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(given.vertices[i]);
      }
    if (wanted) result.surface_count = result.mesh.vertices.size();
  }
  for (auto t : given.tetrahedra) {
    for (std::uint32_t& corner : t) corner = number[corner];
    result.mesh.tetrahedra.push_back(t);
  }
  return result;
}

build::SkinWeights weights_on(const SurfaceFirst& bar, const rig::Character& character,
                              std::span<const std::uint32_t> welded) {
  return build::harmonic_skin_weights(
      bar.mesh, build::welded_skin_weights(character, welded, bar.surface_count, "test"),
      character.skeleton.size(), "test");
}

// A character on the bar's surface with `count` joints; weight_of(point, joint).
template <class WeightOf>
rig::Character character_on(const SurfaceFirst& bar, std::uint32_t count, WeightOf weight_of) {
  rig::Character character;
  for (std::uint32_t j = 0; j < count; ++j)
    character.skeleton.push_back(joint_at("joint", static_cast<std::int32_t>(j) - 1, {0, 0, 0}));
  for (std::size_t i = 0; i < bar.surface_count; ++i) {
    character.surface.vertices.push_back(bar.mesh.vertices[i]);
    std::array<std::uint32_t, 8> joints{};
    std::array<double, 8> weights{};
    for (std::uint32_t j = 0; j < std::min(count, 8u); ++j) {
      joints[j] = j;
      weights[j] = weight_of(bar.mesh.vertices[i], j);
    }
    character.joints.push_back(joints);
    character.weights.push_back(weights);
  }
  return character;
}

std::vector<std::uint32_t> identity(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

double weight_of(const build::SkinWeights& skin, std::size_t i, std::uint32_t joint) {
  for (std::uint32_t k = skin.offset[i]; k < skin.offset[i + 1]; ++k)
    if (skin.joint[k] == joint) return skin.weight[k];
  return 0.0;
}

TEST(SkinWeights, ALinearFieldGoesOnInsideUnchanged) {
  // Linear functions are harmonic, and linear finite elements represent them exactly, even on jittered
  // tetrahedra.
  const SurfaceFirst bar = bar_surface_first({.size = {1, 0.5, 0.5}, .vertices = {11, 6, 6}, .jitter = 0.2});
  const rig::Character character =
      character_on(bar, 2, [](const Vector3d& p, std::uint32_t j) { return j == 0 ? 1.0 - p[0] : p[0]; });
  const build::SkinWeights skin = weights_on(bar, character, identity(bar.surface_count));
  ASSERT_EQ(skin.offset.size(), bar.mesh.vertices.size() + 1);
  for (std::size_t i = 0; i < bar.mesh.vertices.size(); ++i)
    // The solve stops at 1e-8 of the right-hand side, which the condition number (about 1e2) may amplify;
    // shares below 1e-4 are dropped.
    EXPECT_NEAR(weight_of(skin, i, 1), bar.mesh.vertices[i][0], i < bar.surface_count ? 1.01e-4 : 1e-6);
}

TEST(SkinWeights, SumToOneInFloatsInAnyOrder) {
  const SurfaceFirst bar = bar_surface_first({.vertices = {8, 5, 5}, .jitter = 0.2});
  const rig::Character character = character_on(bar, 8, [](const Vector3d& p, std::uint32_t j) {
    const double x = 10.0 * p[0] + 20.0 * p[1] - j;
    return 1.0 / (1.0 + x * x) / 7.0;
  });
  const build::SkinWeights skin = weights_on(bar, character, identity(bar.surface_count));
  for (std::size_t i = 0; i + 1 < skin.offset.size(); ++i) {
    float up = 0.0f, down = 0.0f;
    for (std::uint32_t k = skin.offset[i]; k < skin.offset[i + 1]; ++k)
      up += static_cast<float>(skin.weight[k]);
    for (std::uint32_t k = skin.offset[i + 1]; k-- > skin.offset[i];)
      down += static_cast<float>(skin.weight[k]);
    EXPECT_EQ(up, 1.0f);
    EXPECT_EQ(down, 1.0f);
    EXPECT_LE(skin.offset[i + 1] - skin.offset[i], 8u);
    for (std::uint32_t k = skin.offset[i]; k < skin.offset[i + 1]; ++k) EXPECT_GT(skin.weight[k], 0.0);
  }
}

TEST(SkinWeights, DoNotDependOnTheNumberOfThreads) {
  const SurfaceFirst bar = bar_surface_first({.vertices = {20, 6, 6}, .jitter = 0.2});
  const rig::Character character = character_on(bar, 8, [](const Vector3d& p, std::uint32_t j) {
    const double x = 20.0 * p[0] - j;
    return 1.0 / (1.0 + x * x);
  });
  const build::SkinWeights given =
      build::welded_skin_weights(character, identity(bar.surface_count), bar.surface_count, "test");
  const build::SkinWeights one = build::harmonic_skin_weights(bar.mesh, given, 8, "test", 1);
  for (const std::size_t threads : {2u, 3u, 8u}) {
    const build::SkinWeights more = build::harmonic_skin_weights(bar.mesh, given, 8, "test", threads);
    EXPECT_EQ(one.offset, more.offset);
    EXPECT_EQ(one.joint, more.joint);
    EXPECT_EQ(one.weight, more.weight);
  }
}

TEST(SkinWeights, InsideIsBoundedByTheSurface) {
  // Two joints with a sharp border: values below 0 and above 1 are clamped.
  const SurfaceFirst bar = bar_surface_first({.vertices = {12, 6, 6}, .jitter = 0.3});
  const rig::Character character = character_on(
      bar, 2, [](const Vector3d& p, std::uint32_t j) { return (p[0] < 0.2) == (j == 0) ? 1.0 : 0.0; });
  const build::SkinWeights skin = weights_on(bar, character, identity(bar.surface_count));
  for (std::size_t i = bar.surface_count; i < bar.mesh.vertices.size(); ++i) {
    const double second = weight_of(skin, i, 1);
    EXPECT_GE(second, 0.0);
    EXPECT_LE(second, 1.0);
    // Beyond half of the bar's width from the border, the nearer joint has most of the weight.
    if (bar.mesh.vertices[i][0] < 0.12) {
      EXPECT_LT(second, 0.2);
    }
    if (bar.mesh.vertices[i][0] > 0.28) {
      EXPECT_GT(second, 0.8);
    }
  }
}

TEST(SkinWeights, AWeldedVertexTakesTheMean) {
  const SurfaceFirst bar = bar_surface_first({.vertices = {3, 3, 3}});
  rig::Character character =
      character_on(bar, 2, [](const Vector3d&, std::uint32_t j) { return j == 0 ? 1.0 : 0.0; });
  // A second vertex at the position of vertex 0, with all its weight on joint 1.
  character.surface.vertices.push_back(character.surface.vertices[0]);
  character.joints.push_back({1});
  character.weights.push_back({1.0});
  std::vector<std::uint32_t> welded = identity(bar.surface_count);
  welded.push_back(0);
  const build::SkinWeights skin = weights_on(bar, character, welded);
  EXPECT_EQ(weight_of(skin, 0, 0), 0.5);
  EXPECT_EQ(weight_of(skin, 0, 1), 0.5);
  EXPECT_EQ(weight_of(skin, 1, 0), 1.0);
}

TEST(SkinWeights, RefuseVerticesThatNoJointMoves) {
  const SurfaceFirst bar = bar_surface_first({.vertices = {3, 3, 3}});
  const rig::Character whole = character_on(bar, 2, [](const Vector3d&, std::uint32_t) { return 0.5; });
  const auto refusal = [&](const std::function<void(rig::Character&)>& spoil, const std::string& part) {
    rig::Character character = whole;
    spoil(character);
    expect_refusal([&] { weights_on(bar, character, identity(bar.surface_count)); }, part);
  };
  for (std::size_t v = 0; v < whole.weights.size(); ++v)
    refusal([v](rig::Character& c) { c.weights[v] = {}; }, "vertex " + std::to_string(v) + " ");
  refusal([](rig::Character& c) { c.weights[6][0] = -0.5; }, "vertex 6 ");
  refusal([](rig::Character& c) { c.weights[7][1] = NAN; }, "vertex 7 ");
  refusal([](rig::Character& c) { c.joints[8][1] = 2; }, "vertex 8 ");
  refusal([](rig::Character& c) { c.weights.pop_back(); }, "every vertex");
}

}  // namespace
}  // namespace fascicle::tests
