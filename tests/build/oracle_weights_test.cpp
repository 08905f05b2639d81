// The builder's weights (pulls, shares, rest centres) and the Oracle's (w_ir from the rest data alone) were
// written independently. This compares them on random scenes.
#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using cpu_reference::Oracle;
using Eigen::Vector3d;
using model::Model;

constexpr unsigned scene_count = 100;

// A bar of random size, shape, fibres and materials, in up to three layers; one is sometimes kinematic.
scene::Scene random_bar(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto chance = [&](double p) { return unit(random) < p; };
  const auto fraction = [&] { return chance(0.2) ? 0.0 : chance(0.2) ? 1.0 : unit(random); };
  scene::Scene scene;
  scene.name = scene.source = "random";
  scene::Bar bar;
  for (int a = 0; a < 3; ++a) bar.size[a] = std::exp2(6.0 * unit(random) - 3.0);
  for (auto& count : bar.vertices) count = 2 + static_cast<std::uint32_t>(4.0 * unit(random));
  bar.jitter = chance(0.5) ? 0.3 * unit(random) : 0.0;
  bar.seed = seed;
  scene.geometry = bar;
  const int layers = 1 + static_cast<int>(3.0 * unit(random));
  for (int k = 0; k < layers; ++k) {
    scene::Layer layer;
    layer.name = "layer" + std::to_string(k);
    layer.alpha = fraction();
    layer.beta = fraction();
    layer.density = std::exp2(10.0 * unit(random));
    const Vector3d d(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
    if (d.norm() > 0.1) layer.fibre = d.normalized();
    layer.kinematic = k > 0 && k + 1 == layers && chance(0.4);
    if (k > 0)
      layer.where = {scene::HalfSpace{
          .axis = scene::Axis::x, .below = true, .is_fraction = true, .value = 0.7 / static_cast<double>(k)}};
    scene.layers.push_back(layer);
  }
  scene.solver.weights = chance(0.5) ? scene::WeightForm::symmetric : scene::WeightForm::kaneda2017;
  return scene;
}

// Shares and their error bounds, of the entries (r, i) of the one-rings and of own regions.
struct Shares {
  const Model& model;
  double own(std::uint32_t i) const {
    double rest = 1.0;
    for (std::uint32_t k = model.ring_offset[i]; k < model.ring_offset[i + 1]; ++k)
      rest -= double{model.share_given[k]};
    return rest;
  }
  std::uint32_t neighbours(std::uint32_t i) const { return model.ring_offset[i + 1] - model.ring_offset[i]; }
  // How far a share of i may be from the exact one. Each is rounded to a multiple of 2^-16. The remainder for
  // the own region has the error of all of them. If nothing would remain, the largest share gives back the
  // excess.
  double error_of_taken(std::uint32_t i) const { return own(i) > 0.0 ? 0x1p-17 : 0x1p-17 * neighbours(i); }
  double error_of_own(std::uint32_t i) const { return 0x1p-17 * neighbours(i); }
};

// Pulls are floats with a common power of two, which converts the Oracle's kilograms to the Model's pulls.
double common_factor(const Model& model, const Oracle& oracle) {
  double factor = 0.0;
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    double sum = oracle.weight(i, i);
    for (std::uint32_t k = model.ring_offset[i]; k < model.ring_offset[i + 1]; ++k)
      sum += oracle.weight(i, model.ring[k]);
    if (sum == 0.0) {
      EXPECT_EQ(model.pull[i], 0.0f) << "vertex " << i;
      continue;
    }
    const double here = double{model.pull[i]} / sum;
    if (factor == 0.0) factor = std::exp2(std::round(std::log2(here)));
    // 2^-24 for the rounding of the pull, plus twice that for the squared length of a float fibre, which only
    // the Oracle normalises.
    EXPECT_NEAR(here / factor, 1.0, 0x1p-22) << "vertex " << i;
  }
  return factor;
}

TEST(BuilderAndOracle, AgreeOnEveryWeight) {
  std::size_t compared = 0, fibrous = 0;
  for (unsigned seed = 0; seed < scene_count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Model m = build_quietly(random_bar(seed));
    const Oracle oracle(m, {});
    const double factor = common_factor(m, oracle);
    const Shares shares{m};
    for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
      const double slack = double{m.pull[r]} * 0x1p-22;  // the pull's rounding to float
      ASSERT_NEAR(double{m.pull[r]} * shares.own(r), factor * oracle.weight(r, r),
                  double{m.pull[r]} * shares.error_of_own(r) + slack)
          << "vertex " << r << " in its own region";
      for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k) {
        const std::uint32_t i = m.ring[k];
        const double pull = double{m.pull[i]};
        ASSERT_NEAR(pull * double{m.share_taken[k]}, factor * oracle.weight(i, r),
                    pull * (shares.error_of_taken(i) + 0x1p-22))
            << "vertex " << i << " in region " << r;
        ++compared;
        fibrous += m.beta[r] > 0.0f;
      }
    }
  }
  EXPECT_GT(compared, 10000u);
  EXPECT_GT(fibrous, compared / 4) << "without fibres weights are just masses, and agreement proves little";
}

TEST(BuilderAndOracle, AgreeOnRestCentresAndRegionWeights) {
  std::size_t compared = 0;
  for (unsigned seed = 0; seed < scene_count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Model m = build_quietly(random_bar(seed));
    const Oracle oracle(m, {});
    const double factor = common_factor(m, oracle);
    const Shares shares{m};
    const auto rest = [&](std::uint32_t i) {
      return Vector3d(double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]});
    };
    for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
      double W = oracle.weight(r, r), doubt = double{m.pull[r]} * shares.error_of_own(r), reach = 0.0;
      Vector3d c0 = Vector3d::Zero();  // relative to q0_r, equation (8)
      for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k) {
        const std::uint32_t i = m.ring[k];
        const Vector3d offset = rest(i) - rest(r);
        W += oracle.weight(i, r);
        c0 += oracle.weight(i, r) * offset;
        doubt += double{m.pull[i]} * shares.error_of_taken(i);
        reach = std::max(reach, offset.norm());
      }
      const double inverse = double{m.region_rest[4 * r + 3]};
      if (W == 0.0) {
        EXPECT_EQ(inverse, 0.0) << "region " << r;
        continue;
      }
      c0 /= W;
      W *= factor;
      // The total error of the weights is `doubt`. A relative error e of the weights changes 1/W by e and the
      // centre by e times the region's reach. Floats add a relative 2^-24, taken four times for the sums.
      // Regions with a large e prove nothing and are skipped.
      const double e = doubt / W;
      if (e > 0.1) continue;
      EXPECT_NEAR(inverse * W, 1.0, 1.2 * e + 0x1p-22) << "region " << r;
      const Vector3d built(double{m.region_rest[4 * r]}, double{m.region_rest[4 * r + 1]},
                           double{m.region_rest[4 * r + 2]});
      EXPECT_LE((built - c0).norm(), 2.4 * e * reach + 0x1p-22 * reach) << "region " << r;
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000u);
}

// The control: with another beta the comparison fails by far more than its tolerance.
TEST(BuilderAndOracle, DisagreeWhereAParameterDiffers) {
  scene::Scene scene = bar_scene();
  const Model m = build_quietly(scene);
  Model other = m;
  for (float& beta : other.beta) beta *= 0.9f;
  const Oracle oracle(other, {});
  const double factor = common_factor(m, oracle);
  double largest = 0.0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r)
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
      largest = std::max(largest, std::abs(double{m.share_taken[k]} -
                                           factor * oracle.weight(m.ring[k], r) / double{m.pull[m.ring[k]]}));
  EXPECT_GT(largest, 100 * 0x1p-17);
}

}  // namespace
}  // namespace fascicle::tests
