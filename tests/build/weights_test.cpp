// Weights (12)(13)(14), shares and pulls, compared with a direct evaluation of the paper's formulas.
#include "host/build/weights.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "host/build/bar.h"
#include "host/build/shares.h"
#include "host/model/model.h"
#include "tests/build/scenes.h"

namespace fascicle::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using model::Model;
using model::WeightForm;

Vector3d rest_of(const Model& m, std::size_t i) {
  return {double{m.rest[3 * i]}, double{m.rest[3 * i + 1]}, double{m.rest[3 * i + 2]}};
}

std::vector<std::uint32_t> members(const Model& m, std::uint32_t r) {
  std::vector<std::uint32_t> all(m.ring.begin() + m.ring_offset[r], m.ring.begin() + m.ring_offset[r + 1]);
  all.push_back(r);
  return all;
}

// (12) with (13) and (14), literally. Exact at both ends of beta, in either form.
double printed_weight(const Model& m, std::uint32_t r, std::uint32_t i, bool line) {
  Vector3d centre = Vector3d::Zero();
  double mass = 0.0, longest = 0.0;
  for (const std::uint32_t k : members(m, r)) {
    centre += m.mass[k] * rest_of(m, k);
    mass += m.mass[k];
  }
  centre /= mass;
  for (const std::uint32_t k : members(m, r)) longest = std::max(longest, (rest_of(m, k) - centre).norm());
  const Vector3d r_i = rest_of(m, i) - centre;
  if (r_i.norm() < 1e-4 * longest) return m.mass[i];
  Vector3d d(double{m.fibre[3 * r]}, double{m.fibre[3 * r + 1]}, double{m.fibre[3 * r + 2]});
  if (line && d.dot(r_i) < 0.0) d = -d;
  const double beta = double{m.beta[r]};
  const Vector3d s =
      (beta * d + (1.0 - beta) * r_i.normalized()) / std::sqrt(beta * beta + (1.0 - beta) * (1.0 - beta));
  return m.mass[i] * std::pow(s.dot(r_i), 2) / r_i.squaredNorm();
}

struct Built {
  Model model;
  build::RegionWeights weights;
};

// Builds the scene, and the weights again from the model's own arrays.
Built build_weights(const scene::Scene& scene) {
  Built built{build_quietly(scene), {}};
  const Model& m = built.model;
  const build::OneRings rings{m.ring_offset, m.ring};
  built.weights = build::region_weights(rings, {m.rest, m.mass, m.fibre, m.beta}, m.weight_form);
  return built;
}

scene::Scene weight_scene(double beta, const Vector3d& fibre, WeightForm form, double jitter = 0.2) {
  scene::Scene scene = bar_scene();
  scene.geometry = scene::Bar{.vertices = {7, 5, 4}, .jitter = jitter};
  scene.layers[0].beta = beta;
  scene.layers[0].fibre = fibre.normalized();
  scene.solver.weights = form;
  return scene;
}

void expect_printed(const Built& built, bool line) {
  const Model& m = built.model;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    // Both sides round a dozen double operations on the same floats. Cancellation in the centre amplifies
    // this by up to 1e4 where r_i is shortest.
    EXPECT_NEAR(built.weights.own[r], printed_weight(m, r, r, line), m.mass[r] * 1e-10);
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
      EXPECT_NEAR(built.weights.taken[k], printed_weight(m, r, m.ring[k], line), m.mass[m.ring[k]] * 1e-10);
  }
}

// A hub that gives all of itself to its neighbours. With 700 of them, each share rounds up, from 93.6 steps
// to 94, and the excess of 264 steps is more than any one of them has; with 30, from 2184.5 to 2185, the
// first bears all.
TEST(Shares, OfAHubStayPositiveAndSumToOne) {
  for (const std::uint32_t n : {30u, 700u}) {
    build::OneRings rings;
    rings.offset = {0, n};
    for (std::uint32_t k = 1; k <= n; ++k) rings.neighbour.push_back(k);
    for (std::uint32_t k = 1; k <= n; ++k) {
      rings.neighbour.push_back(0);
      rings.offset.push_back(n + k);
    }
    std::vector<float> rest(3 * (std::size_t{n} + 1)), none(3 * (std::size_t{n} + 1)), stiffness(n + 1, 1.0f);
    for (std::size_t k = 0; k < rest.size(); ++k) rest[k] = static_cast<float>(k % 7) / 8.0f;
    const std::vector<double> mass(n + 1, 1.0);
    build::RegionWeights weights;
    weights.own.assign(n + 1, 1.0);
    weights.own[0] = 0.0;
    weights.taken.assign(2 * std::size_t{n}, 1.0);
    const build::Shares shares =
        build::make_shares(rings, {rest, mass, none, stiffness}, weights, stiffness, true);
    double sum = 0.0, least = 1.0, largest = 0.0;
    for (std::uint32_t k = 0; k < n; ++k) {
      const double share = double{shares.given[k]};
      sum += share;
      least = std::min(least, share);
      largest = std::max(largest, share);
    }
    EXPECT_EQ(sum, 1.0);
    EXPECT_EQ(largest, (n == 30 ? 2185.0 : 94.0) / 65536.0);
    EXPECT_EQ(least, (n == 30 ? 2185.0 - 14.0 : 93.0) / 65536.0);
  }
}

TEST(Weights, FollowThePrintedFormula) {
  for (const double beta : {0.1, 0.3, 0.6, 0.75, 0.99})
    expect_printed(build_weights(weight_scene(beta, {1, 2, 3}, WeightForm::kaneda2017)), false);
}

TEST(Weights, SymmetricFormTakesTheFibreTowardsEachVertex) {
  for (const double beta : {0.1, 0.3, 0.6, 0.75, 0.99})
    expect_printed(build_weights(weight_scene(beta, {1, 2, 3}, WeightForm::symmetric)), true);
}

TEST(Weights, AtBetaZeroAreTheMasses) {
  for (const WeightForm form : {WeightForm::symmetric, WeightForm::kaneda2017}) {
    const Built built = build_weights(weight_scene(0.0, {1, 2, 3}, form));
    for (std::size_t k = 0; k < built.model.ring.size(); ++k)
      EXPECT_EQ(built.weights.taken[k], built.model.mass[built.model.ring[k]]);
    EXPECT_EQ(built.weights.own, built.model.mass);
  }
}

TEST(Weights, WithoutAFibreBetaActsAsZero) {
  scene::Scene scene = weight_scene(0.7, {1, 0, 0}, WeightForm::symmetric);
  scene.layers[0].fibre.reset();
  const Built built = build_weights(scene);
  for (const float beta : built.model.beta) EXPECT_EQ(beta, 0.0f);
  EXPECT_EQ(built.weights.own, built.model.mass);
}

TEST(Weights, AtBetaOneAreMassTimesSquaredCosine) {
  const Built a = build_weights(weight_scene(1.0, {1, 2, 3}, WeightForm::symmetric));
  const Built b = build_weights(weight_scene(1.0, {1, 2, 3}, WeightForm::kaneda2017));
  expect_printed(a, false);
  EXPECT_EQ(a.weights.taken, b.weights.taken);
}

TEST(Weights, AFibreIsALineInTheSymmetricFormOnly) {
  const auto taken = [](const Vector3d& d, WeightForm form) {
    return build_weights(weight_scene(0.5, d, form)).weights.taken;
  };
  EXPECT_EQ(taken({1, 2, 3}, WeightForm::symmetric), taken({-1, -2, -3}, WeightForm::symmetric));
  const std::vector<double> one = taken({1, 2, 3}, WeightForm::kaneda2017),
                            other = taken({-1, -2, -3}, WeightForm::kaneda2017);
  double largest = 0.0, change = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    largest = std::max(largest, one[k]);
    change = std::max(change, std::abs(one[k] - other[k]));
  }
  // At beta 0.5, (1 + c)^2 becomes (1 - c)^2, which loses almost everything if c is near 1.
  EXPECT_GT(change, 0.5 * largest);
}

TEST(Weights, ACentreWithoutDirectionKeepsItsMass) {
  // The middle vertex of a regular bar is the mass centre of its region, up to the rounding of rest
  // positions.
  scene::Scene scene = weight_scene(1.0, {1, 2, 3}, WeightForm::symmetric, 0.0);
  std::get<scene::Bar>(scene.geometry).vertices = {7, 7, 7};
  const Built built = build_weights(scene);
  std::size_t middle = 0;
  for (std::uint32_t r = 0; r < built.model.vertex_count; ++r)
    if (rest_of(built.model, r).norm() < 1e-6) {
      ++middle;
      EXPECT_EQ(built.weights.own[r], built.model.mass[r]);
    }
  EXPECT_EQ(middle, 1u);
}

TEST(Weights, RegionsAndVerticesWithoutWeightFallBackToTheMass) {
  // Hand-made one-rings: four vertices in the plane z = 0, all neighbours, fibres along z, beta 1.
  const build::OneRings rings{{0, 3, 6, 9, 12}, {1, 2, 3, 0, 2, 3, 0, 1, 3, 0, 1, 2}};
  const std::vector<float> rest{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const std::vector<double> mass{1, 2, 3, 4};
  const std::vector<float> fibre{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const std::vector<float> beta{1, 1, 1, 1};
  const build::RegionWeights weights =
      build::region_weights(rings, {rest, mass, fibre, beta}, WeightForm::symmetric);
  EXPECT_EQ(weights.region_fallbacks, 4u);
  EXPECT_EQ(weights.vertex_fallbacks, 0u);
  EXPECT_EQ(weights.own, mass);
  for (std::size_t k = 0; k < rings.neighbour.size(); ++k)
    EXPECT_EQ(weights.taken[k], mass[rings.neighbour[k]]);

  // With fibres along x the regions have weight. Vertices 0 and 2 are at right angles to the fibre as seen
  // from every region's centre, so they have no weight in any region and fall back alone.
  const std::vector<float> cross{0, 1, 0, -1, 0, 0, 0, -1, 0, 1, 0, 0};
  const std::vector<double> even{1, 1, 1, 1};
  const std::vector<float> along{1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
  const build::RegionWeights some =
      build::region_weights(rings, {cross, even, along, beta}, WeightForm::symmetric);
  EXPECT_EQ(some.region_fallbacks, 0u);
  EXPECT_EQ(some.vertex_fallbacks, 2u);
  EXPECT_EQ(some.own, even);
  for (const double w : some.taken) EXPECT_EQ(w, 1.0);
}

TEST(Shares, AreTheWeightsWithinHalfAStep) {
  for (const WeightForm form : {WeightForm::symmetric, WeightForm::kaneda2017}) {
    const Built built = build_weights(weight_scene(0.75, {1, 2, 3}, form));
    const Model& m = built.model;
    std::vector<double> sum = built.weights.own, given(m.vertex_count, 0.0);
    for (std::size_t k = 0; k < m.ring.size(); ++k) sum[m.ring[k]] += built.weights.taken[k];
    for (std::size_t k = 0; k < m.ring.size(); ++k) {
      const double share = double{m.share_taken[k]};
      EXPECT_EQ(share * 65536.0, std::round(share * 65536.0));
      // No vertex gave back rounding excess here (`given` checks it), so half a step is the bound.
      EXPECT_LE(std::abs(share - built.weights.taken[k] / sum[m.ring[k]]), 0x1p-17);
      given[m.ring[k]] += share;
    }
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      // The remainder for the own region: its exact share, off by half a step per neighbour.
      const double own = built.weights.own[i] / sum[i];
      EXPECT_NEAR(1.0 - given[i], own, 0x1p-17 * (m.ring_offset[i + 1] - m.ring_offset[i]));
      EXPECT_LE(given[i], 1.0);
    }
  }
}

TEST(Shares, GiveBackWhatRoundingTookTooMuch) {
  const build::OneRings rings{{0, 3, 6, 9, 12}, {1, 2, 3, 0, 2, 3, 0, 1, 3, 0, 1, 2}};
  const std::vector<float> rest{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<double> mass{1, 1, 1, 1};
  const std::vector<float> none(12, 0.0f), beta(4, 0.0f), stiffness(4, 1.0f);
  build::RegionWeights weights;
  weights.own = {0, 1, 1, 1};
  weights.taken.assign(12, 1.0);
  // The exact shares of vertex 0 are 21844.5, 21844.5 and 21847 steps of 65536. Rounding halves up gives away
  // one step too many.
  weights.taken[3] = 43689.0 / 131072.0;
  weights.taken[6] = 43689.0 / 131072.0;
  weights.taken[9] = 43694.0 / 131072.0;
  const build::Shares shares = build::make_shares(rings, {rest, mass, none, beta}, weights, stiffness, true);
  EXPECT_EQ(double{shares.given[0]} * 65536.0, 21845.0);
  EXPECT_EQ(double{shares.given[1]} * 65536.0, 21845.0);
  EXPECT_EQ(double{shares.given[2]} * 65536.0, 21846.0);
}

TEST(Shares, PullsAreAlphaTimesMassOrTheSumOfWeights) {
  scene::Scene scene = weight_scene(0.75, {1, 2, 3}, WeightForm::symmetric);
  scene.layers[0].alpha = 0.3;
  const Model scaled = build_quietly(scene);
  EXPECT_TRUE(scaled.momentum_scaled);
  const auto free_vertex = [](const Model& m) {
    std::uint32_t i = 0;
    while (m.is_kinematic(i)) ++i;
    return i;
  };
  const double factor =
      double{scaled.pull[free_vertex(scaled)]} / (double{0.3f} * scaled.mass[free_vertex(scaled)]);
  for (std::uint32_t i = 0; i < scaled.vertex_count; ++i) {
    const double stiffness = scaled.is_kinematic(i) ? 1.0 : double{0.3f};
    // Each pull is rounded to float once, and so is the pull from which the factor is derived.
    EXPECT_NEAR(double{scaled.pull[i]}, factor * stiffness * scaled.mass[i], scaled.pull[i] * 0x1p-22);
  }

  scene.solver.weights = WeightForm::kaneda2017;
  const Built printed = build_weights(scene);
  EXPECT_FALSE(printed.model.momentum_scaled);
  std::vector<double> sum = printed.weights.own;
  for (std::size_t k = 0; k < printed.model.ring.size(); ++k)
    sum[printed.model.ring[k]] += printed.weights.taken[k];
  for (std::uint32_t i = 1; i < printed.model.vertex_count; ++i)
    EXPECT_NEAR(double{printed.model.pull[i]} / double{printed.model.pull[0]}, sum[i] / sum[0],
                sum[i] / sum[0] * 0x1p-22);
}

// |A_r|_F at rest from the model's own arrays, as a solver computes it; 0 for skipped regions.
double mean_moment(const Model& m) {
  double sum = 0.0;
  std::size_t regions = 0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    double own = 1.0;
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k) own -= double{m.share_given[k]};
    std::vector<std::pair<double, Vector3d>> parts{{double{m.pull[r]} * own, rest_of(m, r)}};
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
      parts.emplace_back(double{m.pull[m.ring[k]]} * double{m.share_taken[k]}, rest_of(m, m.ring[k]));
    double weight = 0.0;
    Vector3d centre = Vector3d::Zero();
    for (const auto& [w, p] : parts) weight += w, centre += w * p;
    if (!(weight > 0.0)) continue;
    centre /= weight;
    Matrix3d moment = Matrix3d::Zero();
    for (const auto& [w, p] : parts) moment += w * (p - centre) * (p - centre).transpose();
    sum += moment.norm();
    ++regions;
    // region_rest is this centre and inverse weight, rounded to float once.
    const Vector3d offset = centre - rest_of(m, r);
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(double{m.region_rest[4 * r + a]}, offset[static_cast<Eigen::Index>(a)],
                  1e-7 * offset.norm() + 1e-14);
    EXPECT_NEAR(double{m.region_rest[4 * r + 3]} * weight, 1.0, 1e-7);
  }
  return sum / static_cast<double>(regions);
}

TEST(Shares, MomentsAtRestAreAboutOne) {
  for (const double density : {1e-6, 1000.0, 1e9}) {
    scene::Scene scene = weight_scene(0.6, {1, 2, 3}, WeightForm::symmetric);
    scene.layers[0].density = density;
    // Scaling by a power of two reaches 1 only within sqrt(2); floats change that by 1e-7.
    const double mean = mean_moment(build_quietly(scene));
    EXPECT_GE(mean, 0.7071);
    EXPECT_LE(mean, 1.4143);
  }
}

TEST(Shares, ALayerWithoutStiffnessGivesAndTakesNothing) {
  scene::Scene scene = weight_scene(0.0, {1, 0, 0}, WeightForm::symmetric);
  scene.pins.clear();
  scene.layers[0].alpha = 0.0;
  build::Report report;
  const Model model = build::build_model(scene, report);
  EXPECT_EQ(report.skipped_regions, model.vertex_count);
  for (const float x : model.pull) EXPECT_EQ(x, 0.0f);
  for (const float x : model.region_rest) EXPECT_EQ(x, 0.0f);
  EXPECT_NO_THROW(model::check_model(model));
}

// For any rotations, sum_r sum_i w_ir (g_i^r - q_i) = 0 region by region, because each goal is relative to
// the region's own centre. With pulls sum_r w_ir this is sum_i pull_i (g_i - q_i) = 0: the body cannot push
// itself.
TEST(Shares, GoalsConserveMomentumForAnyRotations) {
  scene::Scene scene = weight_scene(0.75, {1, 2, 3}, WeightForm::symmetric);
  scene.pins.clear();
  const Model m = build_quietly(scene);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Vector3d> q(m.vertex_count), goal(m.vertex_count, Vector3d::Zero());
  for (Vector3d& p : q) p = Vector3d(uniform(random), uniform(random), uniform(random));
  double scale = 0.0;
  for (std::uint32_t r = 0; r < m.vertex_count; ++r) {
    double own = 1.0;
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k) own -= double{m.share_given[k]};
    std::vector<std::pair<std::uint32_t, double>> parts{{r, own}};
    for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
      parts.emplace_back(m.ring[k], double{m.share_taken[k]});
    Vector3d centre = Vector3d::Zero();
    for (const auto& [i, f] : parts) centre += double{m.pull[i]} * f * q[i];
    centre *= double{m.region_rest[4 * r + 3]};
    const Vector3d rest_centre =
        rest_of(m, r) + Vector3d(double{m.region_rest[4 * r]}, double{m.region_rest[4 * r + 1]},
                                 double{m.region_rest[4 * r + 2]});
    const Matrix3d rotation =
        Eigen::Quaterniond(uniform(random), uniform(random), uniform(random), uniform(random))
            .normalized()
            .toRotationMatrix();
    for (const auto& [i, f] : parts) goal[i] += f * (rotation * (rest_of(m, i) - rest_centre) + centre);
  }
  Vector3d drift = Vector3d::Zero();
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    drift += double{m.pull[i]} * (goal[i] - q[i]);
    scale += double{m.pull[i]} * (goal[i] - q[i]).norm();
  }
  // region_rest is rounded to floats: 6e-8 of each centre, which is within a spacing or two of the goals.
  EXPECT_LT(drift.norm(), 2e-7 * scale);
}

TEST(Shares, DoNotDependOnScaleOrPlace) {
  scene::Scene scene = weight_scene(0.75, {1, 2, 3}, WeightForm::symmetric);
  scene.geometry = build::make_bar(std::get<scene::Bar>(scene.geometry), "test");
  const auto shares_by_source = [](const Model& m) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> shares;
    for (std::uint32_t r = 0; r < m.vertex_count; ++r)
      for (std::uint32_t k = m.ring_offset[r]; k < m.ring_offset[r + 1]; ++k)
        shares[{m.source_vertex[r], m.source_vertex[m.ring[k]]}] = double{m.share_taken[k]};
    return shares;
  };
  const auto plain = shares_by_source(build_quietly(scene));
  const auto compare = [&](const scene::Scene& changed, double tolerance) {
    const auto other = shares_by_source(build_quietly(changed));
    ASSERT_EQ(other.size(), plain.size());
    for (const auto& [pair, share] : plain) EXPECT_NEAR(other.at(pair), share, tolerance);
  };
  scene::Scene doubled = scene;
  doubled.scale = 2.0;
  compare(doubled, 0.0);  // a power of two changes only the unit
  scene::Scene scaled = scene;
  scaled.scale = 0.37;
  scene::Scene moved = scene;
  for (auto& p : std::get<mesh::TetMesh>(moved.geometry).vertices) p += Vector3d(3.3, -1.7, 0.9);
  // Rest floats round differently: directions and shares change by 1e-6, and then shares by one step.
  compare(scaled, 0x1p-16);
  compare(moved, 0x1p-16);
}

}  // namespace
}  // namespace fascicle::tests
