// Contact of one vertex with one tetrahedron: the Oracle and the solver are compared with numbers computed by
// hand, and what must not meet does not.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle_contact.h"
#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/model.h"
#include "host/model/overlap.h"
#include "host/model/solver.h"
#include "shaders/shared.h"
#include "tests/cpu_reference/contact_motion.h"
#include "tests/cpu_reference/oracle_run.h"
#include "tests/cpu_reference/two_blocks.h"
#include "tests/support/contact_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests::contact_by_hand_test {
namespace {

using cpu_reference::make_cpu_solver;
using Eigen::Vector3d;
using model::Model;
using model::State;

// A regular tetrahedron 0 1 2 3 with corners (1,1,1) ... / 4 around (-1/2, 0, 0), corner 0 a quarter deep and
// the others on the surface. Another one, 4 5 6 7, is far away at rest.
struct PointInTetrahedron {
  explicit PointInTetrahedron(bool implicit) {
    Mesh mesh = regular_tetrahedron();
    for (Vector3d& p : mesh.points) p = p / 4.0 - Vector3d(0.5, 0, 0);
    for (int k = 0; k < 4; ++k) mesh.points.push_back(mesh.points[std::size_t(k)] + Vector3d(1, 0, 0));
    auto other = mesh.tetrahedra[0];
    for (std::uint32_t& i : other) i += 4;
    mesh.tetrahedra.push_back(other);
    model = make_model(mesh);
    std::fill(model.mass.begin(), model.mass.end(), 1.0);
    model.mass[4] = 2.0;
    fill_weights(model);
    if (implicit) model = make_implicit(model, 1e4);
    add_contact(model, 0.125, [](std::uint32_t i) { return i == 0 ? 0.25 : 0.0; });
  }

  // Moves vertex 4 to the centre of the tetrahedron, with velocity v. If implicit, moves the other three as
  // well, as their flesh would pull it out again within the substep.
  State meeting(const Vector3d& v) const {
    State state = make_cpu_solver(model, contact_options(model), 1)->save();
    const Vector3d shift = Vector3d(-0.5, 0, 0) - triple_at(state.positions, 4);
    for (std::uint32_t i = 4; i < (model.is_implicit() ? 8u : 5u); ++i)
      for (std::size_t a = 0; a < 3; ++a) {
        state.positions[3 * i + a] += float(shift[int(a)]);
        state.velocities[3 * i + a] = float(v[int(a)]);
      }
    return state;
  }

  static constexpr double h = 0.5;
  Model model;
};

// By hand: the weights are 1/4 each and the gradient of the first is (1,1,1), so g = (1,1,1) / 4, |g|^2 =
// 3/16, and the depth p = 1/16. d = -p g has length sqrt(3)/64, and n = -(1,1,1)/sqrt(3). No vertex is in
// more than two contacts: 1/k = 2 (1/2) + 4 (1/4) 2 = 3.
TEST(Contact, IsWhatAHandComputes) {
  const Vector3d n = -Vector3d(1, 1, 1).normalized(), aside = Vector3d(1, -1, 0).normalized();
  for (const bool implicit : {false, true}) {
    const PointInTetrahedron c(implicit);
    check_model(c.model);
    const cpu_reference::Contacts contacts(c.model);
    std::size_t at_the_limit = 0;
    for (const double approach : {0.25, -0.125, 0.0})
      for (const double sliding : {0.0625, 2.0, 0.0}) {
        SCOPED_TRACE(std::to_string(approach) + " in, " + std::to_string(sliding) + " along");
        const State state = c.meeting(-approach * n + sliding * aside);
        const Points q = points_in(state.positions), v = points_in(state.velocities);
        const auto pairs = contacts.found_at(q);
        ASSERT_EQ(pairs.size(), 1u);
        EXPECT_EQ(c.model.contact[pairs[0].point].vertex, 4u);
        for (int k = 0; k < 4; ++k) EXPECT_NEAR(pairs[0].weights[k], 0.25, 1e-6);
        EXPECT_LT((pairs[0].push + Vector3d(1, 1, 1) / 64.0).norm(), 1e-6);
        EXPECT_LT((pairs[0].normal - n).norm(), 1e-6);

        const double pushed = std::max(0.0, std::sqrt(3.0) / 64.0 / c.h + approach);
        // Coulomb's 1/2 of the push, or all of the sliding.
        const double rubbed = std::min(0.5 * pushed, sliding);
        at_the_limit += rubbed < sliding ? 1 : 0;
        const Vector3d impulse = (pushed * n - rubbed * aside) / 3.0;
        Points expected(8, Vector3d::Zero());
        expected[4] = 0.5 * impulse;
        for (std::size_t k = 0; k < 4; ++k) expected[k] = -0.25 * impulse;
        EXPECT_LT(largest_distance(contacts.velocity_gains(pairs, v, c.h), expected), 1e-6);

        if (implicit) continue;
        // The solver's passes start from the velocities after the other stages.
        const auto solver = make_cpu_solver(c.model, contact_options(c.model), 1);
        const ContactResponse response = contact_response(*solver, c.model, state, c.h);
        Points x = points_in(response.before.positions), u = points_in(response.before.velocities);
        for (std::uint32_t pass = 0; pass < shader::contact_passes; ++pass) {
          const Points gains = contacts.velocity_gains(pairs, u, c.h);
          for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] += gains[i];
            x[i] += c.h * gains[i];
          }
        }
        EXPECT_LT(largest_distance(points_in(response.after.velocities), u), 1e-6);
        EXPECT_LT(largest_distance(points_in(response.after.positions), x), 1e-6);
      }
    EXPECT_GE(at_the_limit, 3u);
  }
}

// By hand, as above. Vertex 4 yields half as easily as the others: the load is 1/2 + 4 (1/4) = 3/2. Half of
// the depth sqrt(3)/64 is corrected, or 180 H of it in a short step, plus the distance the point has moved
// inwards. A depth of a fourth of a 32nd of the margin is held by a fourth.
TEST(Contact, HoldsAndSettlesAsAHandComputes) {
  const Vector3d n = -Vector3d(1, 1, 1).normalized(), aside = Vector3d(1, -1, 0).normalized();
  PointInTetrahedron c(true);
  const cpu_reference::Contacts contacts(c.model);
  auto pairs = contacts.found_at(points_in(c.meeting(Vector3d::Zero()).positions));
  ASSERT_EQ(pairs.size(), 1u);
  std::vector<double> yielding(8, 1.0);
  yielding[4] = 0.5;
  const auto expected = [&](const Vector3d& impulse, double of_point) {
    Points all(8, Vector3d::Zero());
    all[4] = of_point * impulse;
    for (std::size_t k = 0; k < 4; ++k) all[k] = -0.25 * impulse;
    return all;
  };
  Points moved(8, Vector3d::Zero());
  const float margin = c.model.contact[pairs[0].point].margin;
  for (const double share : {1.0, 0.25})
    for (const auto& [step, depth_share] : {std::pair(0.01, 0.5), std::pair(1.0 / 720.0, 0.25)})
      for (const double in : {0.0, 0.01, -0.01, -0.02})
        for (const double along : {0.0, 0.002}) {
          c.model.contact[pairs[0].point].margin = share == 1.0 ? 0.8f : float(0.5 * std::sqrt(3.0) / share);
          moved[4] = -in * n + along * aside;
          const double pushed = std::max(0.0, depth_share * std::sqrt(3.0) / 64.0 + in),
                       rubbed = std::min(0.5 * pushed, along);
          const Points moves = contacts.held_moves(pairs, moved, yielding, step);
          EXPECT_LT(largest_distance(moves, expected(share * (pushed * n - rubbed * aside) / 1.5, 0.5)),
                    1e-6);
          EXPECT_EQ(pairs[0].presses, pushed > 0.0);
        }
  c.model.contact[pairs[0].point].margin = margin;

  // 1/4 of the velocity before, with a history of 1/3; sliding is unchanged. Vertex 4 has twice the mass, and
  // no other contact involves the five vertices: 1/2 + 4 (1/4) (1/4) = 3/4.
  Points v(8, Vector3d::Zero()), before(8, Vector3d::Zero());
  v[4] = 0.5 * n + aside;
  before[4] = -2.0 * n;
  EXPECT_EQ(largest_in(contacts.settling_gains(pairs, v, before, 1.0 / 3.0)), 0.0) << "it does not push";
  moved[4].setZero();
  contacts.held_moves(pairs, moved, yielding, 0.01);
  EXPECT_LT(
      largest_distance(contacts.settling_gains(pairs, v, before, 1.0 / 3.0), expected(-1.0 * n / 0.75, 0.5)),
      1e-6);
  EXPECT_LT(largest_distance(contacts.settling_gains(pairs, v, before, 0.0), expected(-0.5 * n / 0.75, 0.5)),
            1e-6);
}

// A single contact has restitution 0: it ends at rest, or with the velocity that the history turns into rest.
// The control: without the last stage the integrator throws it back.
TEST(Contact, WhatPressesIsLeftAtRest) {
  const PointInTetrahedron c(true);
  const Vector3d n = -Vector3d(1, 1, 1).normalized();
  const double h = 1.0 / 480.0;
  const auto solver = make_cpu_solver(c.model, contact_options(c.model), 1);
  const auto approach = [&](const std::vector<float>& velocities) {
    const Points v = points_in(velocities);
    return (v[4] - (v[0] + v[1] + v[2] + v[3]) / 4.0).dot(n);
  };
  State state = c.meeting(-0.5 * n);
  for (const double history : {0.0, 1.0 / 3.0}) {
    const ContactResponse response = contact_response(*solver, c.model, state, h);
    EXPECT_GT(std::abs(approach(response.before.velocities)), 0.1) << history;
    // Weights have the error `rounding`, and velocities are about a metre a second.
    EXPECT_NEAR(approach(response.after.velocities), history / (1.0 + history) * approach(state.velocities),
                1e-4);
    EXPECT_EQ(response.after.positions, response.before.positions) << "only velocities change";
    state = solver->save();
  }
}

// Flesh that is near at rest does not meet, unless it is across a gap; then it meets beyond the allowance.
// Flesh that moves with the skeleton on both sides does not meet.
TEST(Contact, MeetsWhatIsFarOrAcrossAGap) {
  PointInTetrahedron c(false);
  const Points q = points_in(c.meeting(Vector3d::Zero()).positions);
  const auto pairs = [&] { return cpu_reference::Contacts(c.model).found_at(q); };
  const auto is_pressed = [&] {
    const auto solver = make_cpu_solver(c.model, {}, 1);
    return largest_in(points_in(contact_gains(*solver, c.model, c.meeting(Vector3d::Zero()), c.h))) > 0.0;
  };
  ASSERT_EQ(pairs().size(), 1u);
  EXPECT_TRUE(is_pressed());
  c.model.contact[4].margin = 2.0f;
  EXPECT_EQ(pairs().size(), 0u);
  EXPECT_FALSE(is_pressed());
  add_gap(c.model, 4, {0, 1, 2, 3}, 0.03125f);
  ASSERT_EQ(pairs().size(), 1u);
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(pairs()[0].push.norm(), std::sqrt(3.0) / 4.0 / 32.0, 1e-6) << "allowance not subtracted";
  c.model.contact[4].allowance = 0.125f;
  EXPECT_EQ(pairs()[0].push.norm(), 0.0);
  c.model.contact_near = {{0, 3}};
  EXPECT_EQ(pairs().size(), 0u);
  EXPECT_FALSE(is_pressed());
  c.model.contact_near = {{0, 4}};
  for (const std::uint32_t i : {0u, 1u, 2u, 3u, 4u}) make_kinematic(c.model, i);
  fill_weights(c.model);
  finish_contact(c.model);
  EXPECT_EQ(pairs().size(), 0u);
  EXPECT_FALSE(is_pressed());
}

// Three corners are held, the fourth bears a 64th of the contact, and the incoming mass is a million times as
// heavy. To bring the contact to rest, the fourth would need 64 times the speed; settling gives it at most
// four times. Each iteration moves it by no more than its correction of the depth, 180 H of it.
TEST(Contact, DoesNotThrowACornerThatBearsLittleOfIt) {
  PointInTetrahedron c(true);
  for (std::uint32_t i = 4; i < 8; ++i) c.model.mass[i] = 1e6;
  for (const std::uint32_t i : {1u, 2u, 3u}) make_kinematic(c.model, i);
  fill_weights(c.model);
  finish_contact(c.model);
  constexpr double share = 1.0 / 64.0, speed = 2.0, h = 1.0 / 480.0;
  State state = c.meeting(Vector3d::Zero());
  const Points corners = points_in(state.positions);
  const Vector3d place = share * corners[0] + (1.0 - share) / 3.0 * (corners[1] + corners[2] + corners[3]);
  const Vector3d shift = place - corners[4];
  const Vector3d inward = (corners[0] - (corners[1] + corners[2] + corners[3]) / 3.0).normalized();
  for (std::uint32_t i = 4; i < 8; ++i)
    for (int a = 0; a < 3; ++a) {
      state.positions[3 * i + std::uint32_t(a)] += float(shift[a]);
      state.velocities[3 * i + std::uint32_t(a)] = float(speed * inward[a]);
    }
  ASSERT_EQ(cpu_reference::Contacts(c.model).found_at(points_in(state.positions)).size(), 1u);
  const auto solver = make_cpu_solver(c.model, contact_options(c.model), 1);
  solver->load(state);
  TestDrive quiet = quiet_drive(c.model, h);
  solver->submit(quiet.get(), {});
  solver->collect();
  const double thrown = points_in(solver->save().velocities)[0].norm();
  const double depth = share * 0.25, iterations = contact_options(c.model).iterations;
  EXPECT_GT(thrown, speed) << "the corner was pushed";
  EXPECT_LT(thrown, 4.0 * speed + iterations * 180.0 * depth);
}

// A point does not meet the groups that it ignores. It meets other groups, and flesh without a group.
TEST(Contact, DoesNotMeetWhatItIgnores) {
  for (const bool implicit : {false, true}) {
    PointInTetrahedron c(implicit);
    const State state = c.meeting(Vector3d(0.25, 0.25, 0.25));
    const double h = implicit ? 1.0 / 480.0 : c.h;
    const auto is_met = [&] {
      check_model(c.model);
      const auto solver = make_cpu_solver(c.model, contact_options(c.model), 1);
      const bool is_pressed = largest_in(points_in(contact_gains(*solver, c.model, state, h))) > 0.0;
      EXPECT_EQ(cpu_reference::Contacts(c.model).found_at(points_in(state.positions)).size(),
                is_pressed ? 1u : 0u);
      EXPECT_EQ(model::OverlapMeter(c.model).of(state.positions).vertices, is_pressed ? 1u : 0u);
      return is_pressed;
    };
    EXPECT_TRUE(is_met());
    c.model.contact_group.assign(c.model.contact_tetrahedron_count(), 5u);
    c.model.contact_ignored.assign(c.model.contact.size(), 4u);
    add_group_depths(c.model);
    EXPECT_FALSE(is_met());
    c.model.contact_ignored[4] = 0;
    EXPECT_TRUE(is_met()) << "only this point's groups matter";
    c.model.contact_ignored[4] = 1;
    EXPECT_FALSE(is_met());
    c.model.contact_group[0] = 4u;
    EXPECT_TRUE(is_met()) << "the tetrahedron is in another group";
  }
}

// A point that ignores groups takes the least of their depths.
TEST(Contact, IsAsDeepAsBeyondWhatItIgnores) {
  for (const bool implicit : {false, true}) {
    PointInTetrahedron c(implicit);
    const Points q = points_in(c.meeting(Vector3d::Zero()).positions);
    const auto push = [&] {
      check_model(c.model);
      return cpu_reference::Contacts(c.model).found_at(q).at(0).push.norm();
    };
    const double all = push();
    c.model.contact_group.assign(c.model.contact_tetrahedron_count(), 0);
    c.model.contact_group[1] = 3;
    c.model.contact_ignored.assign(c.model.contact.size(), 0);
    for (const float share : {0.5f, 2.0f})
      for (std::size_t i = 0; i < 8; ++i) c.model.contact_depth.push_back(share * c.model.contact_depth[i]);
    EXPECT_EQ(push(), all) << "the point ignores nothing";
    c.model.contact_ignored[4] = 2;
    EXPECT_EQ(push(), all) << "a larger depth does not count";
    // Depth and its gradient are halved.
    c.model.contact_ignored[4] = 3;
    EXPECT_NEAR(push(), all / 4.0, 1e-6 * all);
    EXPECT_NEAR(model::OverlapMeter(c.model).of(c.meeting(Vector3d::Zero()).positions).deepest,
                c.model.unit / 32.0, 1e-6);
  }
}

}  // namespace
}  // namespace fascicle::tests::contact_by_hand_test
