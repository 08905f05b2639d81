// Trajectories of the Oracle compared with closed forms.
#include "cpu_reference/oracle/oracle.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/cpu_reference/oracle_run.h"

namespace fascicle::tests::oracle_test {
namespace {

using cpu_reference::Oracle;
using Eigen::Vector3d;
using model::Model;

constexpr double h = 1.0 / 64.0;

// A regular tetrahedron whose vertex 0 is free and displaced along its axis of symmetry. The moment stays
// symmetric, so the rotation is the identity. All four regions then have the goal g - q = -(1 - w_0/W) x for
// a displacement x along the axis, and the vertex is a spring, q <- y - alpha_eff x with alpha_eff = alpha (1
// - w_0/W). `anchor` is the mass of a pinned vertex relative to the free one.
struct Spring {
  Model model;
  double alpha_eff = 0.0;
};

Spring make_spring(float alpha, bool momentum_scaled, double anchor = 1.0, double damping = 0.0) {
  BodyOptions options;
  options.alpha = alpha;
  options.damping = damping;
  options.momentum_scaled = momentum_scaled;
  options.kinematic = [](const Vector3d& p) { return p != Vector3d(1, 1, 1); };
  Spring spring{make_model(regular_tetrahedron(), options)};
  for (std::uint32_t i = 1; i < 4; ++i) spring.model.mass[i] = anchor * spring.model.mass[0];
  // Every region contains all four vertices: each gets a quarter of s_i = alpha m_0 and anchor m_0, or of m_i
  // as printed.
  const double w = momentum_scaled ? double(alpha) : 1.0;
  spring.alpha_eff = double(alpha) * (1.0 - w / (w + 3.0 * anchor));
  return spring;
}

// The displacement along the axis after each of `steps` steps, starting from x_0 at rest.
std::vector<double> displacements(const Spring& spring, double x_0, int steps, double* off_axis = nullptr) {
  const Vector3d axis = Vector3d(1, 1, 1) / std::sqrt(3.0);
  Oracle oracle(spring.model, {});
  Points q = rest_points(spring.model);
  q[0] += x_0 * Vector3d(1, 1, 1);
  set_state(spring.model, oracle, q, Points(4, Vector3d::Zero()));
  TestDrive drive = quiet_drive(spring.model, h);
  std::vector<double> xs;
  for (int n = 0; n < steps; ++n) {
    advance(oracle, drive);
    const Vector3d x = oracle.positions()[0] - Vector3d(1, 1, 1);
    xs.push_back(x.dot(axis) / std::sqrt(3.0));
    if (off_axis) *off_axis = std::max(*off_axis, (x - x.dot(axis) * axis).norm());
  }
  return xs;
}

// x_n = x_0 cos((n + 1/2) theta) / cos(theta/2) with 2 (1 - cos theta) = alpha_eff, theta = 2 pi f h: it
// satisfies x_{n+1} - 2 x_n + x_{n-1} = -alpha_eff x_n and starts from x_0 at rest.
TEST(OracleSpring, SwingsWithTheFrequencyOfItsStiffness) {
  for (bool scaled : {false, true})
    for (float alpha : {0.0625f, 0.5f, 1.0f}) {
      const Spring spring = make_spring(alpha, scaled);
      const double theta = std::acos(1.0 - spring.alpha_eff / 2.0);
      double off_axis = 0.0;
      const std::vector<double> xs = displacements(spring, 1.0 / 16, 2000, &off_axis);
      for (std::size_t n = 1; n <= xs.size(); ++n) {
        const double exact = std::cos((double(n) + 0.5) * theta) / std::cos(theta / 2.0) / 16.0;
        // Coordinates near 1 are rounded by 1e-16 a step; in an oscillator such kicks add up to n
        // sqrt(n)/theta at worst.
        ASSERT_NEAR(xs[n - 1], exact, 1e-12) << "alpha " << alpha << " step " << n;
      }
      EXPECT_LT(off_axis, 1e-12);
    }
}

// With decay e the update is x_{n+1} = (1 + e (1 - alpha_eff)) x_n - e x_{n-1}; its roots give the closed
// form.
TEST(OracleSpring, DampsAsItsLayerSays) {
  const Spring spring = make_spring(0.5f, true, 1.0, 2.0);
  const double e = float(std::exp(-2.0 * h));
  const std::complex<double> b = 1.0 + e * (1.0 - spring.alpha_eff);
  const std::complex<double> root = (b + std::sqrt(b * b - 4.0 * e)) / 2.0;
  ASSERT_GT(std::abs(root.imag()), 0.1);
  // x_n = Re(k root^n) through x_0 and x_1 = (1 - e alpha_eff) x_0.
  const double x_0 = 1.0 / 16;
  const double x_1 = (1.0 - e * spring.alpha_eff) * x_0;
  const std::complex<double> k(x_0, (x_0 * root.real() - x_1) / root.imag());
  const std::vector<double> xs = displacements(spring, x_0, 1000);
  for (std::size_t n = 1; n <= xs.size(); ++n)
    ASSERT_NEAR(xs[n - 1], (k * std::pow(root, double(n))).real(), 1e-13)
        << "step " << n;  // 1e-16 a step, damped away
}

// A float rounds h = 1/60: steps use the float's value, which shows after 600 steps of free fall.
TEST(OracleSpring, StepsByTheFloatOfH) {
  Model model = make_model(regular_tetrahedron());
  model.alpha.assign(4, 0.0f);
  Oracle oracle(model, {});
  TestDrive drive = quiet_drive(model, 1.0 / 60.0, 600, Vector3d(0, -8, 0));
  advance(oracle, drive);
  const double step = float(1.0 / 60.0);
  EXPECT_NEAR(oracle.velocities()[0].y(), -8.0 * 600 * step, 1e-11);   // 600 roundings of 80 m/s
  EXPECT_GT(std::abs(oracle.velocities()[0].y() + 8.0 * 10.0), 1e-7);  // not the double's value
}

// The explicit step is stable below alpha_eff = 4. Very heavy anchors make alpha_eff = alpha.
TEST(OracleSpring, StabilityEndsAtFour) {
  const auto largest = [](float alpha) {
    double most = 0.0;
    for (double x : displacements(make_spring(alpha, true, 1e6), 1.0 / 1024, 2000))
      most = std::max(most, std::abs(x));
    return most;
  };
  // Below, the amplitude is x_0/cos(theta/2) = x_0/sqrt(1 - alpha/4): 20 x_0 at 3.99, where the anchors'
  // finite mass changes alpha_eff by 4 parts in 3e6.
  EXPECT_LT(largest(3.99f), 20.1 / 1024);
  EXPECT_GT(largest(3.99f), 10.0 / 1024);
  // Above, it grows by about (1 + sqrt(0.01)) a step and exceeds any bound long before 2,000 steps.
  EXPECT_GT(largest(4.01f), 1e3);
}

// A body at rest without gravity stays at rest, whatever its pins, beta and fibres.
TEST(OracleRest, StaysForTenThousandSteps) {
  struct Case {
    const char* name;
    bool pinned;
    double damping;
    double tolerance;
  };
  // Coordinates of up to 0.3 m are rounded by 3e-17, so a goal is off by about 1e-17 a step, always with the
  // same sign, as nothing changes. Pinned, the error stays constant. Free, it is an acceleration of alpha
  // 1e-17/h^2. Damped by e, that gives a drift of n alpha 1e-17/(1 - e) with 1 - e = 0.19, which is 4e-13;
  // undamped it grows like n^2 alpha 1e-17/2, 4e-10. Each tolerance has a margin of a few times.
  const Case cases[] = {
      {"pinned", true, 0.0, 1e-14}, {"free, damped", false, 13.4, 1e-12}, {"free", false, 0.0, 2e-9}};
  for (const Case& c : cases)
    for (float beta : {0.0f, 0.6f, 1.0f}) {
      BodyOptions options;
      options.alpha = 0.7f;
      options.beta = beta;
      options.damping = c.damping;
      options.fibre = Vector3d(0.48, -0.6, 0.64);
      if (c.pinned) options.kinematic = [](const Vector3d& p) { return p.x() < 0.06; };
      const Model model = make_model(jittered(kuhn_bar(2, 1, 1, 0.125), 1.0 / 1024, 10, 5), options);
      Oracle oracle(model, {});
      TestDrive drive = quiet_drive(model, h, 10000);
      advance(oracle, drive);
      const double moved = largest_distance(oracle.positions(), rest_points(model));
      EXPECT_LT(moved, c.tolerance) << c.name << ", beta " << beta;
    }
}

// Rest with (15)-(17): a body whose regions all share one T is at rest in the shape T q0, with the same
// volume.
TEST(OracleRest, BulgedBodyRestsInItsBulgedShape) {
  BodyOptions options;
  options.beta = 0.5f;
  Model model = make_model(kuhn_bar(2, 2, 2, 0.125), options);
  add_muscle(model, Vector3d::UnitY(), 1.5);
  Oracle oracle(model, {});
  TestDrive drive = quiet_drive(model, h);
  // c = 1 + 1.5 x 2 x 1 = 4, so T = diag(1/2, 4, 1/2), exact in float.
  drive.muscles.assign(1, shader::Muscle{0, 2, 0, 0, 0});
  Points bulged;
  for (const Vector3d& p : rest_points(model)) bulged.emplace_back(p.x() / 2, 4 * p.y(), p.z() / 2);
  set_state(model, oracle, bulged, Points(model.vertex_count, Vector3d::Zero()));
  advance(oracle, drive, 200);
  EXPECT_LT(largest_distance(oracle.positions(), bulged), 1e-13);  // rounding, as for any free body at rest
  // The control: with a slack muscle, that shape is not at rest.
  set_state(model, oracle, bulged, Points(model.vertex_count, Vector3d::Zero()));
  drive.muscles.assign(1, shader::Muscle{0, 0, 0, 0, 0});
  advance(oracle, drive, 1);
  EXPECT_GT(largest_distance(oracle.positions(), bulged), 1e-2);
}

// A muscle with activation 0 has no effect.
TEST(OracleRest, SlackMuscleChangesNothing) {
  Model model = make_model(jittered(kuhn_bar(2, 2, 1, 0.125), 1.0 / 1024, 10, 6));
  Points pulled = rest_points(model);
  for (Vector3d& p : pulled) p.x() *= 1.25;
  Points ends[2];
  for (bool muscle : {false, true}) {
    if (muscle) add_muscle(model, {0.6, 0.8, 0.0}, 1.5);
    Oracle oracle(model, {});
    set_state(model, oracle, pulled, Points(model.vertex_count, Vector3d::Zero()));
    TestDrive drive = quiet_drive(model, h);
    advance(oracle, drive, 200);
    ends[muscle] = oracle.positions();
  }
  // D I D^T is the identity to 2^-52; 200 steps of a smooth motion amplify that by a few hundred.
  EXPECT_LT(largest_distance(ends[0], ends[1]), 1e-12);
}

// Vertices of stiffness 0 fall freely and do not affect the others, wherever they are.
TEST(OracleDegenerate, LayerWithoutStiffnessFallsAndPullsNothing) {
  BodyOptions options;
  options.beta = 0.4f;
  Model model = make_model(jittered(kuhn_bar(3, 2, 1, 0.125), 1.0 / 1024, 10, 7), options);
  const auto loose = [](std::uint32_t i) { return i % 3 == 1; };
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    if (loose(i)) model.alpha[i] = 0.0f;
  fill_weights(model);
  const Vector3d gravity(0, -8, 0);
  Points q = rest_points(model);
  for (Vector3d& p : q) p.x() *= 1.25;
  Points results[2];
  for (bool away : {false, true}) {
    Points start = q;
    if (away)
      for (std::uint32_t i = 0; i < model.vertex_count; ++i)
        if (loose(i)) start[i] += Vector3d(3, 40 + i, -7);
    Oracle oracle(model, {});
    set_state(model, oracle, start, Points(model.vertex_count, Vector3d(0, 1, 0)));
    TestDrive drive = quiet_drive(model, h, 64, gravity);
    advance(oracle, drive);
    // (4)(5) by hand: n steps give v = v_0 + n h g and q = q_0 + n h v_0 + h^2 g n (n + 1)/2.
    const Vector3d fallen = 1.0 * Vector3d(0, 1, 0) + h * h * gravity * (64 * 65 / 2);
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      if (loose(i)) {
        EXPECT_LT((oracle.positions()[i] - start[i].cast<float>().cast<double>() - fallen).norm(), 1e-12)
            << i;  // 64 roundings of 60 m
        EXPECT_LT((oracle.velocities()[i] - Vector3d(0, 1, 0) - gravity).norm(), 1e-13) << i;
      }
    for (std::uint32_t i = 0; i < model.vertex_count; ++i)
      if (!loose(i)) results[away].push_back(oracle.positions()[i]);
  }
  EXPECT_EQ(largest_distance(results[0], results[1]), 0.0);  // zero times anything finite
}

TEST(OracleDegenerate, BodyWithoutAnyStiffnessIsFinite) {
  Model model = make_model(kuhn_bar(1, 1, 1, 0.125));
  model.alpha.assign(model.vertex_count, 0.0f);
  Oracle oracle(model, {});
  TestDrive drive = quiet_drive(model, h, 64, Vector3d(0, -8, 0));
  advance(oracle, drive);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i)
    EXPECT_NEAR(oracle.positions()[i].y() - double(model.rest[3 * i + 1]), -8.0 * h * h * 64 * 65 / 2, 1e-13);
}

// If all points coincide there is no moment: the last rotation stays and the body opens again.
TEST(OracleDegenerate, CollapsedBodyOpensInItsLastRotation) {
  const Model model = make_model(regular_tetrahedron());
  Oracle oracle(model, {});
  model::State state = oracle.save();
  state.positions.assign(12, 2.0f);
  for (std::size_t r = 0; r < 4; ++r)  // a third of a turn about (1,1,1): x -> y -> z
    for (std::size_t k = 0; k < 4; ++k) state.rotations[4 * r + k] = 0.5f;
  oracle.load(state);
  TestDrive drive = quiet_drive(model, h);
  advance(oracle, drive);
  const Points rest = rest_points(model);
  for (std::size_t i = 0; i < 4; ++i) {
    // q = 2 + alpha R q0 with alpha 0.5.
    const Vector3d opened = Vector3d::Constant(2.0) + 0.5 * Vector3d(rest[i].z(), rest[i].x(), rest[i].y());
    EXPECT_LT((oracle.positions()[i] - opened).norm(), 1e-15 * 4);
  }
}

TEST(OracleForces, CoefficientTimesForceAccelerates) {
  Model model = make_model(regular_tetrahedron());
  model.alpha.assign(4, 0.0f);
  model.force_count = 2;
  model.force_offset = {0, 1, 3, 3, 3};
  model.force_index = {1, 0, 1};
  model.force_coefficient = {0.5f, 0.25f, 2.0f};
  make_kinematic(model, 3);
  Oracle oracle(model, {});
  TestDrive drive = quiet_drive(model, 0.5);
  drive.forces = {{4, 0, 0, 0}, {0, 8, 0, 0}};
  advance(oracle, drive);
  EXPECT_EQ(oracle.velocities()[0], Vector3d(0, 2, 0));  // h 0.5 (0,8,0)
  EXPECT_EQ(oracle.velocities()[1], Vector3d(0.5, 8, 0));
  EXPECT_EQ(oracle.velocities()[2], Vector3d(0, 0, 0));
}

// Every frame's surface is the barycentric mean of its vertices; only requested buffers are returned.
TEST(OracleFrame, SurfaceRidesOnTheVertices) {
  const Model model = make_model(kuhn_bar(2, 1, 1, 0.125));
  Oracle oracle(model, {});
  TestDrive drive = quiet_drive(model, h, 3, Vector3d(1, -8, 2));
  oracle.submit(drive.get(), {.surface = true});
  oracle.submit(drive.get(), {.positions = true, .velocities = true});
  const model::Frame first = oracle.collect();
  const model::Frame second = oracle.collect();
  EXPECT_EQ(first.index, 1u);
  EXPECT_EQ(second.index, 2u);
  EXPECT_TRUE(first.positions.empty() && first.velocities.empty() && second.surface.empty());
  EXPECT_EQ(second.positions, to_floats(oracle.positions()));
  EXPECT_EQ(second.velocities, to_floats(oracle.velocities()));
  // A free body falls as a whole: every render vertex by h^2 g 6 from its rest position.
  ASSERT_EQ(first.surface.size(), 3 * std::size_t{model.surface_count()});
  for (std::uint32_t s = 0; s < model.surface_count(); ++s)
    for (std::size_t k = 0; k < 3; ++k) {
      double at_rest = 0.0;
      for (std::size_t c = 0; c < 4; ++c)
        at_rest += double(model.surface_weight[4 * s + c]) *
                   double(model.rest[3 * model.surface_vertex[4 * s + c] + k]);
      const double g[3] = {1, -8, 2};
      EXPECT_NEAR(first.surface[3 * s + k], at_rest + h * h * g[k] * 6,
                  1e-7);  // half an ULP of a float below 1
    }
  EXPECT_THROW(oracle.collect(), std::logic_error);
}

// save() rounds to float once; after that the same history gives the same bits.
TEST(OracleFrame, SavedStateGoesOn) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Model model = random_model(seed);
    Oracle a(model, {});
    TestDrive drive = quiet_drive(model, h, 4, Vector3d(0, -8, 0));
    advance(a, drive, 3);
    const model::State state = a.save();
    EXPECT_EQ(state.frame, 3u);
    a.load(state);
    EXPECT_EQ(a.save(), state);
    Oracle b(model, {});
    b.load(state);
    advance(a, drive, 3);
    advance(b, drive, 3);
    EXPECT_EQ(largest_distance(a.positions(), b.positions()), 0.0);
    EXPECT_EQ(b.save().frame, 6u);
    model::State cut = state;
    cut.positions.pop_back();
    EXPECT_THROW(b.load(cut), std::invalid_argument);
  }
}

// What a probe is shown: stages in order, with stage_width floats.
TEST(OracleFrame, ProbeSeesEveryStageInOrder) {
  struct Seen : model::Probe {
    void on_stage(const model::Where& where, std::span<const float> values) override {
      stages.push_back(where);
      sizes.push_back(values.size());
    }
    std::vector<model::Where> stages;
    std::vector<std::size_t> sizes;
  };
  using model::Stage;
  Model model = make_model(kuhn_bar(2, 1, 1, 0.125));
  add_skeleton(model);
  Oracle oracle(model, {});
  Seen seen;
  TestDrive drive = quiet_drive(model, h, 2);
  oracle.submit(drive.get(), {}, &seen);
  const Stage order[] = {Stage::skin,      Stage::predict,   Stage::region,  Stage::goal,
                         Stage::integrate, Stage::skin,      Stage::predict, Stage::region,
                         Stage::goal,      Stage::integrate, Stage::embed};
  ASSERT_EQ(seen.stages.size(), std::size(order));
  for (std::size_t k = 0; k < seen.stages.size(); ++k) {
    EXPECT_EQ(seen.stages[k].stage, order[k]);
    EXPECT_EQ(seen.stages[k].frame, 1u);
    EXPECT_EQ(seen.stages[k].substep, k < 5 ? 0u : 1u);
    const std::size_t items = order[k] == Stage::embed ? model.surface_count() : model.vertex_count;
    EXPECT_EQ(seen.sizes[k], items * model::stage_width(order[k]));
  }
}

}  // namespace
}  // namespace fascicle::tests::oracle_test
