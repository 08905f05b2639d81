// OverlapMeter measures how much of a body is inside itself. Compared with all pairs, and with numbers by
// hand.
#include "host/model/overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "host/model/contact_depth.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using model::Model;
using model::Overlap;
using model::PointOverlap;

Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// The points inside a tetrahedron that they may meet, and their depths: every point against every
// tetrahedron, by inverting the tetrahedron's edges.
std::vector<PointOverlap> overlaps_of_all_pairs(const Model& model, const std::vector<float>& positions) {
  std::vector<PointOverlap> overlaps;
  for (std::uint32_t p = 0; p < model.contact.size(); ++p)
    for (std::uint32_t t = 0; t < model.contact_tetrahedron_count(); ++t) {
      const shader::ContactPoint& point = model.contact[p];
      const std::uint32_t* corner = model.contact_tetrahedron.data() + 4 * t;
      if (model.is_ignored_contact(p, t)) continue;
      Eigen::Matrix3d edges;
      for (int k = 0; k < 3; ++k)
        edges.col(k) = triple(positions, corner[k + 1]) - triple(positions, corner[0]);
      if (!(edges.determinant() > 0.0)) continue;
      const Vector3d b = edges.inverse() * (triple(positions, point.vertex) - triple(positions, corner[0]));
      const double weights[4] = {1.0 - b.sum(), b[0], b[1], b[2]};
      const auto is_near = [&](std::uint32_t i) {
        const auto first = model.contact_near.begin() + point.first_near;
        return std::any_of(first, first + point.near_count,
                           [i](const shader::VertexRun& run) { return run.first <= i && i < run.end; });
      };
      Vector3d place = Vector3d::Zero();
      double depth = 0.0, least = 1.0;
      bool moves = !model.is_kinematic(point.vertex), is_across_a_gap = true;
      for (int k = 0; k < 4; ++k) {
        place += weights[k] * triple(model.rest, corner[k]);
        depth += weights[k] * double{model::contact_depth_of(model, p, corner[k])};
        least = std::min(least, weights[k]);
        moves = moves || !model.is_kinematic(corner[k]);
        is_across_a_gap = is_across_a_gap && is_near(corner[k]);
      }
      const bool is_far = (place - triple(model.rest, point.vertex)).norm() > double{point.margin};
      if (!(least >= 0.0) || !moves || !(is_far || is_across_a_gap)) continue;
      overlaps.push_back({p, t, depth * model.unit});
      break;
    }
  return overlaps;
}

// Two blocks whose lower or upper halves move with the skeleton, in whole tetrahedra; or all but one vertex
// do. Some points ignore some flesh, and every third may meet nearby flesh of the first block.
TwoBlocks varied_blocks(unsigned seed) {
  TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, seed);
  Model m = without_contact(blocks.model);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i)
    if (seed % 3 == 0 ? i + 1 != blocks.first_of_second
                      : (m.rest[3 * i + 2] < 0.06f) == (i < blocks.first_of_second))
      make_kinematic(m, i);
  add_contact(m, 1.5 * blocks.spacing, depth_below_boundary(m));
  if (seed % 2 == 0) ignore_some_contact(m, seed);
  for (std::uint32_t p = 0; p < m.contact.size(); p += 3) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < blocks.first_of_second; ++i)
      if (i != m.contact[p].vertex &&
          (triple(m.rest, i) - triple(m.rest, m.contact[p].vertex)).norm() < 2.5 * blocks.spacing)
        near.push_back(i);
    add_gap(m, p, near, 0.0f);
  }
  blocks.model = m;
  return blocks;
}

// Pushes the second block into the first by `into` and down by `down`. All vertices also move randomly by up
// to `size` edges.
std::vector<float> pushed(const TwoBlocks& blocks, double into, unsigned seed, float size = 0.1f,
                          float down = 0.0f) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> small(-size, size);
  std::vector<float> positions = blocks.model.rest;
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      positions[3 * i + a] += small(random) * float(blocks.spacing);
      if (a == 0 && i >= blocks.first_of_second) positions[3 * i] -= float(1.0 - 0.5 + into);
      if (a == 2 && i >= blocks.first_of_second) positions[3 * i + 2] -= down;
    }
  return positions;
}

// The number of points found, of those that are kinematic, and of those with flesh across a gap.
struct Seen {
  std::size_t found = 0, held = 0, across_a_gap = 0;
};

void expect_what_all_pairs_find(const TwoBlocks& blocks, double into, float size, float down, unsigned seed,
                                Seen& seen) {
  const Model& m = blocks.model;
  const std::vector<float> positions = pushed(blocks, into, seed, size, down);
  const std::vector<PointOverlap> expected = overlaps_of_all_pairs(m, positions),
                                  found = model::OverlapMeter(m).points(positions);
  ASSERT_EQ(found.size(), expected.size()) << seed;
  double deepest = 0.0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].point, expected[k].point) << seed;
    EXPECT_EQ(found[k].tetrahedron, expected[k].tetrahedron) << seed;
    // The same weights by different sums: rounding of doubles, with nearly flat edges.
    EXPECT_NEAR(found[k].depth, expected[k].depth, 1e-12) << seed;
    deepest = std::max(deepest, expected[k].depth);
    seen.held += m.is_kinematic(m.contact[found[k].point].vertex) ? 1 : 0;
    seen.across_a_gap += m.contact[found[k].point].near_count > 0 ? 1 : 0;
  }
  const Overlap overlap = model::OverlapMeter(m).of(positions);
  EXPECT_EQ(overlap.vertices, expected.size()) << seed;
  EXPECT_NEAR(overlap.deepest, deepest, 1e-12) << seed;
  seen.found += found.size();
}

TEST(OverlapMeter, FindsWhatAllPairsFind) {
  Seen plain, varied;
  for (unsigned seed = 1; seed <= 9; ++seed) {
    const TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, seed);
    expect_what_all_pairs_find(blocks, 0.03 * seed, 0.1f, 0.0f, seed, plain);
    // From half an edge on, many tetrahedra are inside out and points are in several of them.
    for (const float size : {0.1f, 0.5f, 1.5f})
      expect_what_all_pairs_find(varied_blocks(seed), 0.05 + 0.0625 * seed, size, 0.03f * float(seed), seed,
                                 varied);
  }
  // A corner of the first block is inside the second, and both follow the skeleton.
  for (const unsigned seed : {3U, 6U, 9U})
    expect_what_all_pairs_find(varied_blocks(seed), 0.56, 0.1f, 0.06f, seed, varied);
  EXPECT_GT(plain.found, 100u);
  EXPECT_GT(varied.found, 300u);
  EXPECT_GT(varied.held, 50u);
  EXPECT_GT(varied.across_a_gap, 50u);
}

// The blocks already overlap in the rest shape. That does not count, either at rest or rotated and
// translated. In other shapes a point counts by its depth beyond that at rest.
TEST(OverlapMeter, CountsWhatGoesBeyondTheRestShape) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, seed);
    std::vector<float> apart = blocks.model.rest;
    Model& m = blocks.model;
    m.rest = pushed(blocks, 0.12, seed, 0.0f);
    // The other block is across a gap.
    std::vector<std::uint32_t> first, second;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i)
      (i < blocks.first_of_second ? first : second).push_back(i);
    for (std::uint32_t p = 0; p < m.contact.size(); ++p)
      add_gap(m, p, m.contact[p].vertex < blocks.first_of_second ? second : first, 0.0f);
    const model::OverlapMeter meter(m);
    std::vector<double> at_rest(m.contact.size(), -1.0);
    for (const PointOverlap& one : overlaps_of_all_pairs(m, m.rest)) at_rest[one.point] = one.depth;
    EXPECT_GT(*std::max_element(at_rest.begin(), at_rest.end()), 0.05)
        << "m: the blocks hardly overlap at rest";

    std::vector<float> turned = m.rest;
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(1.0, Vector3d(1.0, 2.0, -2.0) / 3.0));
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      const Vector3d x = turn * triple(m.rest, i) + Vector3d(0.1, -0.2, 0.05);
      for (int a = 0; a < 3; ++a) turned[3 * i + std::size_t(a)] = float(x[a]);
    }
    for (std::vector<float>* shape : {&m.rest, &turned, &apart}) {
      EXPECT_EQ(meter.of(*shape).vertices, 0u) << seed;
      EXPECT_EQ(meter.of(*shape).deepest, 0.0) << seed;
      EXPECT_EQ(meter.of(*shape).volume, 0.0) << seed;
    }

    std::vector<float> deeper = m.rest;
    for (std::uint32_t i = blocks.first_of_second; i < m.vertex_count; ++i) deeper[3 * i] -= 0.0625f;
    std::vector<PointOverlap> expected;
    for (const PointOverlap& one : overlaps_of_all_pairs(m, deeper)) {
      const double more = one.depth - std::max(at_rest[one.point], 0.0);
      // No depth here is between rounding errors and depths that count.
      EXPECT_TRUE(more < 1e-7 || more > 1e-5 || at_rest[one.point] < 0.0) << more;
      if (more > 1e-5 || at_rest[one.point] < 0.0) expected.push_back({one.point, one.tetrahedron, more});
    }
    const std::vector<PointOverlap> found = meter.points(deeper);
    ASSERT_EQ(found.size(), expected.size()) << seed;
    EXPECT_GT(found.size(), 15u);
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].point, expected[k].point) << seed;
      EXPECT_NEAR(found[k].depth, expected[k].depth, 1e-12) << seed;
    }
  }
}

// Vertices far away do not affect others, and tetrahedra that extend to them still contain their points.
TEST(OverlapMeter, FindsTheSameBesideWhatHasFlownOff) {
  std::uint64_t found = 0;
  for (const float far : {3.0f, 1e4f, 1e30f, std::numeric_limits<float>::infinity()}) {
    const TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, 2);
    std::vector<float> positions = pushed(blocks, 0.06, 2);
    for (const std::size_t k : {std::size_t{0}, std::size_t{3} * blocks.first_of_second + 1})
      positions[k] = k == 0 ? -far : far;
    const std::size_t expected = overlaps_of_all_pairs(blocks.model, positions).size();
    EXPECT_EQ(model::OverlapMeter(blocks.model).of(positions).vertices, expected) << far;
    found += expected;
  }
  EXPECT_GT(found, 40u);
}

// Two cubes of side 1/2, one pushed into the other by 1/8 along x. Each has a face of area 1/4 that is 1/8
// deep in the other, so the volume is 1/32. Points near the face's rim are nearer to the other cube's sides
// than to its face and count with that smaller depth, which loses less than half of the volume.
TEST(OverlapMeter, ApproachesTheVolumeByHand) {
  Mesh mesh = kuhn_bar(8, 8, 8, 0.0625);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  const std::size_t tetrahedra = mesh.tetrahedra.size();
  for (std::uint32_t i = 0; i < first; ++i) mesh.points.push_back(mesh.points[i] + Vector3d(2.0, 0.0, 0.0));
  for (std::size_t t = 0; t < tetrahedra; ++t) {
    auto corners = mesh.tetrahedra[t];
    for (std::uint32_t& i : corners) i += first;
    mesh.tetrahedra.push_back(corners);
  }
  Model model = make_model(mesh);
  add_contact(model, 0.1, depth_below_boundary(model));
  const model::OverlapMeter meter(model);
  EXPECT_EQ(meter.of(model.rest).vertices, 0u);
  EXPECT_EQ(meter.of(model.rest).volume, 0.0);
  std::vector<float> positions = model.rest;
  for (std::uint32_t i = first; i < model.vertex_count; ++i) positions[3 * i] -= 1.625f;
  const Overlap overlap = meter.of(positions);
  EXPECT_NEAR(overlap.deepest, 0.125, 1e-9);
  EXPECT_GT(overlap.volume, 0.5 / 32.0);
  EXPECT_LT(overlap.volume, 1.0 / 32.0);
}

// A NaN point is inside nothing, and nothing is inside a tetrahedron with a NaN corner.
TEST(OverlapMeter, BearsWhatIsNoNumber) {
  const TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, 1);
  const model::OverlapMeter meter(blocks.model);
  std::vector<float> positions = pushed(blocks, 0.1, 1);
  const std::uint32_t before = meter.of(positions).vertices;
  for (std::uint32_t i = 0; i < blocks.first_of_second; ++i) positions[3 * i] = std::nanf("");
  EXPECT_GT(before, 0u);
  EXPECT_EQ(meter.of(positions).vertices, 0u);
}

}  // namespace
}  // namespace fascicle::tests
