// The weights w_ir: equations (12), (13), (14), their special cases, and momentum scaling.
#include "cpu_reference/oracle/oracle_weights.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "tests/cpu_reference/oracle_run.h"

namespace fascicle::tests {
namespace {

using cpu_reference::fibre_weight;
using cpu_reference::Oracle;
using Eigen::Vector3d;
using model::Model;
using model::WeightForm;

std::vector<std::uint32_t> region_of(const Model& model, std::uint32_t r) {
  std::vector<std::uint32_t> members{r};
  members.insert(members.end(), model.ring.begin() + model.ring_offset[r],
                 model.ring.begin() + model.ring_offset[r + 1]);
  return members;
}

Mesh small_bar() {
  return jittered(kuhn_bar(3, 2, 2, 0.125), 1.0 / 1024, 10, 3);
}

BodyOptions printed(float beta, const Vector3d& fibre, WeightForm form = WeightForm::symmetric) {
  BodyOptions options;
  options.beta = beta;
  options.fibre = fibre;
  options.weight_form = form;
  options.momentum_scaled = false;
  return options;
}

// A centre with six neighbours along the axes; eight tetrahedra. The centre is the centre of mass of its
// region.
Mesh octahedron() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t x : {1u, 2u})
    for (std::uint32_t y : {3u, 4u})
      for (std::uint32_t z : {5u, 6u}) {
        const bool even = ((x == 2) + (y == 4) + (z == 6)) % 2 == 0;
        mesh.tetrahedra.push_back(even ? std::array<std::uint32_t, 4>{0, x, y, z}
                                       : std::array<std::uint32_t, 4>{0, x, z, y});
      }
  return mesh;
}

TEST(OracleWeights, BetaZeroIsTheMass) {
  const Model model = make_model(small_bar(), printed(0.0f, Vector3d(0.6, 0.8, 0)));
  const Oracle oracle(model, {});
  for (std::uint32_t r = 0; r < model.vertex_count; ++r)
    for (std::uint32_t i : region_of(model, r)) EXPECT_EQ(oracle.weight(i, r), model.mass[i]);
}

TEST(OracleWeights, BetaOneIsTheMassTimesTheCosineSquared) {
  const Vector3d d(0.6, 0.8, 0);
  const Model model = make_model(small_bar(), printed(1.0f, d));
  const Oracle oracle(model, {});
  const Points rest = rest_points(model);
  for (std::uint32_t r = 0; r < model.vertex_count; ++r) {
    Vector3d centre = Vector3d::Zero();
    double mass = 0.0;
    for (std::uint32_t k : region_of(model, r)) {
      centre += model.mass[k] * rest[k];
      mass += model.mass[k];
    }
    for (std::uint32_t i : region_of(model, r)) {
      const Vector3d offset = rest[i] - centre / mass;
      const double c = d.dot(offset) / offset.norm();
      // The Model's fibre is (0.6f, 0.8f), off by up to 6e-8, so c^2 is off by twice that.
      EXPECT_NEAR(oracle.weight(i, r), model.mass[i] * c * c, 1.2e-7 * model.mass[i]);
    }
  }
}

// In between: w = m (beta c + 1 - beta)^2 / (beta^2 + (1 - beta)^2). By hand, with cosine 0.6 and beta 0.75:
// (0.45 + 0.25)^2 / (0.5625 + 0.0625) = 0.784.
TEST(OracleWeights, BetweenByHand) {
  const Vector3d offset(3, 4, 0);
  for (WeightForm form : {WeightForm::symmetric, WeightForm::kaneda2017})
    EXPECT_NEAR(fibre_weight(Vector3d::UnitX(), 0.75, offset, form), 0.784, 1e-15);
  // Against the fibre, (-0.45 + 0.25)^2 / 0.625 = 0.064 as printed; `symmetric` ignores the sign.
  EXPECT_NEAR(fibre_weight(-Vector3d::UnitX(), 0.75, offset, WeightForm::kaneda2017), 0.064, 1e-15);
  EXPECT_NEAR(fibre_weight(-Vector3d::UnitX(), 0.75, offset, WeightForm::symmetric), 0.784, 1e-15);
}

TEST(OracleWeights, AFibreHasNoSign) {
  for (float beta : {0.0f, 0.3f, 0.5f, 0.9f, 1.0f}) {
    const Vector3d d(0.48, -0.6, 0.64);
    const Model model = make_model(small_bar(), printed(beta, d));
    const Model turned = make_model(small_bar(), printed(beta, -d));
    const Oracle a(model, {});
    const Oracle b(turned, {});
    for (std::uint32_t r = 0; r < model.vertex_count; ++r)
      for (std::uint32_t i : region_of(model, r)) EXPECT_EQ(a.weight(i, r), b.weight(i, r));
  }
}

// The control: as printed, the sign matters between beta 0 and 1.
TEST(OracleWeights, APrintedFibreHasASign) {
  const Vector3d d(0.48, -0.6, 0.64);
  for (float beta : {0.0f, 0.5f, 1.0f}) {
    const Model model = make_model(small_bar(), printed(beta, d, WeightForm::kaneda2017));
    const Model turned = make_model(small_bar(), printed(beta, -d, WeightForm::kaneda2017));
    const Oracle a(model, {});
    const Oracle b(turned, {});
    double largest = 0.0;
    for (std::uint32_t r = 0; r < model.vertex_count; ++r)
      for (std::uint32_t i : region_of(model, r))
        largest = std::max(largest, std::abs(a.weight(i, r) - b.weight(i, r)) / model.mass[i]);
    if (beta == 0.5f)
      EXPECT_GT(largest, 0.5);
    else
      EXPECT_LT(largest, 1e-15);
  }
}

TEST(OracleWeights, NoFibreIsBetaZero) {
  const Model model = make_model(small_bar(), printed(0.7f, Vector3d::Zero()));
  const Oracle oracle(model, {});
  for (std::uint32_t r = 0; r < model.vertex_count; ++r)
    for (std::uint32_t i : region_of(model, r)) EXPECT_EQ(oracle.weight(i, r), model.mass[i]);
}

// At the centre of mass r_i has no direction: the weight is the mass, even if rounding leaves a tiny r_i.
TEST(OracleWeights, VertexAtTheCentreWeighsItsMass) {
  for (double away : {0.0, 1e-7}) {
    Mesh mesh = octahedron();
    mesh.points[0] += Vector3d(0, away, 0);
    const Model model = make_model(mesh, printed(1.0f, Vector3d::UnitX()));
    const Oracle oracle(model, {});
    EXPECT_EQ(oracle.weight(0, 0), model.mass[0]);
    EXPECT_NEAR(oracle.weight(1, 0), model.mass[1],
                1e-12 * model.mass[1]);                     // along: cosine 1 up to `away` squared
    EXPECT_LT(oracle.weight(3, 0), 1e-13 * model.mass[3]);  // across: cosine about `away`
  }
}

// In a flat region every r_i is perpendicular to a fibre along the normal: the weights sum to zero and fall
// back.
TEST(OracleWeights, RegionWithoutWeightsFallsBackToMass) {
  Mesh flat = regular_tetrahedron();
  for (Vector3d& p : flat.points) p.z() = 0.0;
  Model model = make_model(flat, printed(1.0f, Vector3d::UnitZ()));
  model.mass = {1.0, 2.0, 3.0, 4.0};
  const Oracle oracle(model, {});
  for (std::uint32_t r = 0; r < 4; ++r)
    for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(oracle.weight(i, r), model.mass[i]);
}

// Here vertices (1,1,1) and (-1,-1,1) are perpendicular to the fibre in all their regions, so only these two
// fall back.
TEST(OracleWeights, VertexWithoutWeightsFallsBackToMass) {
  const Mesh mesh = regular_tetrahedron();
  const Model model = make_model(mesh, printed(1.0f, Vector3d(1, -1, 0)));
  const Oracle oracle(model, {});
  for (std::uint32_t r = 0; r < 4; ++r)
    for (std::uint32_t i = 0; i < 4; ++i) {
      const bool square = mesh.points[i].x() == mesh.points[i].y();
      // c = 2 / (sqrt 2 sqrt 3), c^2 = 2/3
      EXPECT_NEAR(oracle.weight(i, r), square ? model.mass[i] : model.mass[i] * 2.0 / 3.0,
                  1e-12 * model.mass[i]);
    }
}

// Scaled: the total that vertex i gives to all its regions is s_i = alpha_i m_i, m_i if kinematic, nothing at
// alpha 0.
TEST(OracleWeights, MomentumScalingSumsToStiffnessTimesMass) {
  int kinematic = 0;
  int loose = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Model model = random_model(seed);
    if (!model.momentum_scaled) continue;
    const Oracle oracle(model, {});
    for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
      double sum = 0.0;
      for (std::uint32_t r : region_of(model, i)) sum += oracle.weight(i, r);
      const double s = model.is_kinematic(i) ? model.mass[i] : double(model.alpha[i]) * model.mass[i];
      EXPECT_NEAR(sum, s, 1e-14 * model.mass[i]);  // about 20 additions
      kinematic += model.is_kinematic(i);
      loose += s == 0.0;
    }
  }
  EXPECT_GT(kinematic, 0);
  EXPECT_GT(loose, 0);
}

TEST(OracleWeights, OutsideTheOneRingIsZero) {
  const Model model = make_model(kuhn_bar(4, 1, 1, 0.125));
  const Oracle oracle(model, {});
  EXPECT_EQ(oracle.weight(0, 4), 0.0);
  EXPECT_GT(oracle.weight(0, 1), 0.0);
}

}  // namespace
}  // namespace fascicle::tests
