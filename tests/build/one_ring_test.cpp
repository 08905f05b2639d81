// One-rings compared with a brute-force search of all pairs, and the mesh's connected parts.
#include "host/build/one_ring.h"

#include <set>

#include <gtest/gtest.h>

#include "host/build/bar.h"

namespace fascicle::tests {
namespace {

mesh::TetMesh small_bar() {
  return build::make_bar({.vertices = {4, 3, 3}}, "test");
}

std::set<std::pair<std::uint32_t, std::uint32_t>> pairs_by_brute_force(const mesh::TetMesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const auto& t : mesh.tetrahedra)
    for (const std::uint32_t a : t)
      for (const std::uint32_t b : t)
        if (a != b) pairs.emplace(a, b);
  return pairs;
}

TEST(OneRing, HoldsExactlyThePairsThatShareATetrahedron) {
  const mesh::TetMesh mesh = small_bar();
  const build::OneRings rings = build::one_rings(mesh.vertices.size(), mesh.tetrahedra);
  ASSERT_EQ(rings.size(), mesh.vertices.size());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> listed;
  for (std::uint32_t i = 0; i < rings.size(); ++i)
    for (const std::uint32_t j : rings[i]) listed.emplace_back(i, j);
  // A set iterates in ascending order; the lists must be ascending too.
  const auto expected = pairs_by_brute_force(mesh);
  EXPECT_TRUE(std::equal(listed.begin(), listed.end(), expected.begin(), expected.end()));
}

TEST(OneRing, MirrorLeadsToTheOppositeEntryAndBack) {
  const mesh::TetMesh mesh = small_bar();
  const build::OneRings rings = build::one_rings(mesh.vertices.size(), mesh.tetrahedra);
  const std::vector<std::uint32_t> mirror = build::mirror_entries(rings);
  for (std::uint32_t r = 0; r < rings.size(); ++r)
    for (std::uint32_t k = rings.offset[r]; k < rings.offset[r + 1]; ++k) {
      const std::uint32_t i = rings.neighbour[k];
      EXPECT_EQ(rings.neighbour[mirror[k]], r);
      EXPECT_GE(mirror[k], rings.offset[i]);
      EXPECT_LT(mirror[k], rings.offset[i + 1]);
      EXPECT_EQ(mirror[mirror[k]], k);
    }
}

TEST(OneRing, PartsAreCountedByTheirLowestVertex) {
  // Vertices 0 2 4 6 and 1 3 5 7, with no edge between the two groups.
  const build::OneRings rings = build::one_rings(8, {{0, 2, 4, 6}, {1, 3, 5, 7}});
  const build::Parts parts = build::connected_parts(rings);
  EXPECT_EQ(parts.count, 2u);
  EXPECT_EQ(parts.of_vertex, (std::vector<std::uint32_t>{0, 1, 0, 1, 0, 1, 0, 1}));
}

}  // namespace
}  // namespace fascicle::tests
