// OverlapMeter: how much of a body lies inside itself. Against all pairs, and against numbers by hand.
#include "host/model/overlap.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests {
namespace {

using Eigen::Vector3d;
using model::Model;
using model::Overlap;

Vector3d triple(const std::vector<float>& values, std::uint32_t i) {
  return {double{values[3 * i]}, double{values[3 * i + 1]}, double{values[3 * i + 2]}};
}

// The points that lie in a tetrahedron of flesh far from them at rest, and how deep: every point against
// every tetrahedron, by inverting the tetrahedron's edges.
std::vector<double> depths_of_all_pairs(const Model& model, const std::vector<float>& positions) {
  std::vector<double> depths;
  for (const shader::ContactPoint& point : model.contact)
    for (std::size_t t = 0; t < model.contact_tetrahedron.size(); t += 4) {
      const std::uint32_t* corner = model.contact_tetrahedron.data() + t;
      Eigen::Matrix3d edges;
      for (int k = 0; k < 3; ++k)
        edges.col(k) = triple(positions, corner[k + 1]) - triple(positions, corner[0]);
      if (!(edges.determinant() > 0.0)) continue;
      const Vector3d b = edges.inverse() * (triple(positions, point.vertex) - triple(positions, corner[0]));
      const double weights[4] = {1.0 - b.sum(), b[0], b[1], b[2]};
      Vector3d place = Vector3d::Zero();
      double depth = 0.0, least = 1.0;
      for (int k = 0; k < 4; ++k) {
        place += weights[k] * triple(model.rest, corner[k]);
        depth += weights[k] * double{model.contact_depth[corner[k]]};
        least = std::min(least, weights[k]);
      }
      if (least < 0.0 || (place - triple(model.rest, point.vertex)).norm() <= double{point.margin}) continue;
      depths.push_back(depth);
      break;
    }
  return depths;
}

// The second block pushed into the first by `into`, all vertices moved at random besides.
std::vector<float> pushed(const TwoBlocks& blocks, double into, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> small(-0.1f, 0.1f);
  std::vector<float> positions = blocks.model.rest;
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      positions[3 * i + a] += small(random) * float(blocks.spacing);
      if (a == 0 && i >= blocks.first_of_second) positions[3 * i] -= float(1.0 - 0.5 + into);
    }
  return positions;
}

TEST(OverlapMeter, FindsWhatAllPairsFind) {
  std::uint64_t found = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, seed);
    const model::OverlapMeter meter(blocks.model);
    const std::vector<float> positions = pushed(blocks, 0.03 * seed, seed);
    const std::vector<double> depths = depths_of_all_pairs(blocks.model, positions);
    double deepest = 0.0;
    for (const double depth : depths) deepest = std::max(deepest, depth);
    const Overlap overlap = meter.of(positions);
    EXPECT_EQ(overlap.vertices, depths.size()) << seed;
    // The same sums in another order: rounding of double.
    EXPECT_NEAR(overlap.deepest, deepest * blocks.model.unit, 1e-12) << seed;
    found += depths.size();
  }
  EXPECT_GT(found, 100u);
}

// Vertices that have flown off make no difference to the others, and tetrahedra that reach out to them hold
// what they hold.
TEST(OverlapMeter, FindsTheSameBesideWhatHasFlownOff) {
  std::uint64_t found = 0;
  for (const float far : {3.0f, 1e4f, 1e30f, std::numeric_limits<float>::infinity()}) {
    const TwoBlocks blocks = make_two_blocks(4, 3, 3, 0.125, 2);
    std::vector<float> positions = pushed(blocks, 0.06, 2);
    for (const std::size_t k : {std::size_t{0}, std::size_t{3} * blocks.first_of_second + 1})
      positions[k] = k == 0 ? -far : far;
    const std::size_t expected = depths_of_all_pairs(blocks.model, positions).size();
    EXPECT_EQ(model::OverlapMeter(blocks.model).of(positions).vertices, expected) << far;
    found += expected;
  }
  EXPECT_GT(found, 40u);
}

// Two cubes of side 1/2, one pushed into the other by 1/8 along x and nothing else. Each has a face of area
// 1/4 that lies 1/8 deep in the other, so the volume is 1/32. Points near the face's rim are nearer to the
// other's sides than to its face and count with that depth: less than half of the volume is lost so.
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

// What is no number lies nowhere, and nothing lies in it.
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
