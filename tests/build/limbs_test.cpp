// Skin is grouped by limb kind by kind: that must give what comparing each patch with each gives.
#include "host/build/limbs.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "host/mesh/mesh.h"

namespace {

using namespace fascicle;
using build::Limbs;
using scene::Vector3d;

// Ribbons along x, each a part of the skin. A ribbon's triangle i has the vertices i, i + 1 and i + 2.
struct Ribbons {
  mesh::SurfaceMesh skin;
  build::SkinWeights weights;
  std::vector<rig::Joint> skeleton;
  std::vector<std::vector<std::uint32_t>>
      patches;  // stretches of ribbons, the longest first; no two have one length
};

constexpr std::uint32_t ribbons = 6, stretches = 4, gap = 4;

// A root with three joints, of which the last has a child: kin, and strangers.
std::vector<rig::Joint> skeleton() {
  std::vector<rig::Joint> joints(5);
  for (std::size_t j = 0; j < joints.size(); ++j) joints[j].name = "j" + std::to_string(j);
  joints[1].parent = joints[2].parent = joints[3].parent = 0;
  joints[0].parent = -1;
  joints[4].parent = 3;
  return joints;
}

using Row = std::vector<std::pair<std::uint32_t, double>>;

Ribbons random_ribbons(std::uint32_t seed) {
  std::mt19937 random(seed);
  // Few rows, so that patches of different ribbons have the same weights.
  const std::vector<Row> rows{{{1, 1.0}}, {{2, 1.0}}, {{1, 0.5}, {2, 0.5}},
                              {{3, 1.0}}, {{4, 1.0}}, {{2, 0.875}, {4, 0.125}}};
  Ribbons made;
  made.skeleton = skeleton();
  made.weights.offset.push_back(0);
  std::vector<std::uint32_t> lengths(ribbons * stretches);
  std::iota(lengths.begin(), lengths.end(), 1u);
  std::shuffle(lengths.begin(), lengths.end(), random);
  for (std::uint32_t r = 0; r < ribbons; ++r) {
    const auto first_vertex = static_cast<std::uint32_t>(made.skin.vertices.size());
    const auto add_vertex = [&](const Row& row) {
      const auto i = static_cast<double>(made.skin.vertices.size() - first_vertex);
      made.skin.vertices.emplace_back(0.1 * i, 0.1 * static_cast<double>(made.skin.vertices.size() % 2), r);
      for (const auto& [joint, weight] : row) {
        made.weights.joint.push_back(joint);
        made.weights.weight.push_back(weight);
      }
      made.weights.offset.push_back(static_cast<std::uint32_t>(made.weights.joint.size()));
    };
    const auto first_triangle = static_cast<std::uint32_t>(made.skin.triangles.size());
    std::uint32_t triangles = 0;
    for (std::uint32_t s = 0; s < stretches; ++s) {
      const std::uint32_t length = lengths[made.patches.size()];
      std::vector<std::uint32_t> patch;
      for (std::uint32_t i = 0; i < length; ++i) patch.push_back(first_triangle + triangles + i);
      made.patches.push_back(std::move(patch));
      // One stretch in four has two rows, so that a triangle of it may differ from its mean.
      const Row& row = rows[random() % rows.size()];
      const Row& other = random() % 4 == 0 ? rows[random() % rows.size()] : row;
      for (std::uint32_t i = 0; i < length + 2; ++i) add_vertex(2 * i < length ? row : other);
      for (std::uint32_t i = 0; i + 2 < gap; ++i) add_vertex(row);
      triangles += length + gap;
    }
    for (std::uint32_t i = 0; i + 2 < made.skin.vertices.size() - first_vertex; ++i)
      made.skin.triangles.push_back({first_vertex + i, first_vertex + i + 1, first_vertex + i + 2});
  }
  std::sort(made.patches.begin(), made.patches.end(),
            [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return made;
}

std::vector<std::vector<std::uint32_t>> compared_each_with_each(const Limbs& limbs, const Ribbons& made) {
  std::vector<std::vector<const std::vector<std::uint32_t>*>> groups;
  for (const auto& patch : made.patches) {
    const auto home = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      return std::none_of(group.begin(), group.end(),
                          [&](const auto* other) { return limbs.are_apart(*other, patch); });
    });
    (home == groups.end() ? groups.emplace_back() : *home).push_back(&patch);
  }
  std::vector<std::vector<std::uint32_t>> sorted;
  for (const auto& group : groups) {
    sorted.emplace_back();
    for (const auto* patch : group) sorted.back().insert(sorted.back().end(), patch->begin(), patch->end());
    std::sort(sorted.back().begin(), sorted.back().end());
  }
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

TEST(Limbs, AreGroupedAsByComparingEachPatchWithEach) {
  std::map<std::size_t, int> group_counts;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    const Ribbons made = random_ribbons(seed);
    const Limbs limbs(made.skin, made.weights, made.skeleton, {0.6, 0.2});
    std::vector<std::uint32_t> triangles;
    for (const auto& patch : made.patches) triangles.insert(triangles.end(), patch.begin(), patch.end());
    std::sort(triangles.begin(), triangles.end());
    const auto groups = limbs.groups_of(triangles);
    EXPECT_EQ(groups, compared_each_with_each(limbs, made)) << "seed " << seed;
    ++group_counts[groups.size()];
  }
  // Neither is all of it one limb, nor is each patch its own.
  EXPECT_GE(group_counts.begin()->first, 2u);
  EXPECT_LE(group_counts.rbegin()->first, ribbons * stretches / 2);
  EXPECT_GE(group_counts.size(), 2u);
}

}  // namespace
