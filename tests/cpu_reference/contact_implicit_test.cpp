// Contact in the implicit integrator, stage by stage: solver against Oracle, the effect of an iteration on
// momentum, and the purpose of settling. contact_test.cpp and contact_by_hand_test.cpp test what both
// integrators share.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/oracle/oracle_contact.h"
#include "cpu_reference/solver/contact_stages.h"
#include "host/model/implicit.h"
#include "host/model/overlap.h"
#include "tests/cpu_reference/contact_motion.h"
#include "tests/cpu_reference/oracle_run.h"
#include "tests/cpu_reference/plain_contact_search.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests::contact_implicit_test {

namespace {

namespace cpu = cpu_reference;
using cpu_reference::make_cpu_solver;
using Eigen::Vector3d;
using model::Model;
using model::Stage;
using model::State;

constexpr double h = 1.0 / 480.0;

// Blocks with other stiffness (Pa) and damping (1/s) than those of make_two_blocks. With `ends_held`, the two
// outermost faces are kinematic.
TwoBlocks implicit_blocks(double stiffness, double damping = 0.0, bool ends_held = false) {
  TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 3);
  Model m = without_contact(blocks.model);
  const auto along = [&](std::uint32_t i) { return m.rest[3 * std::size_t{i}]; };
  float least = along(0), most = along(0);
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    least = std::min(least, along(i));
    most = std::max(most, along(i));
  }
  for (std::uint32_t i = 0; ends_held && i < m.vertex_count; ++i)
    if (along(i) < least + 0.06f || along(i) > most - 0.06f) make_kinematic(m, i);
  m.layers.front().damping = damping;
  fill_weights(m);
  blocks.model = make_implicit(m, stiffness);
  add_contact(blocks.model, 1.5 * blocks.spacing, depth_below_boundary(blocks.model));
  return blocks;
}

struct Shown {
  model::Where where;
  std::vector<float> values;
};
struct Record : model::Probe {
  void on_stage(const model::Where& where, std::span<const float> values) override {
    shown.push_back({where, {values.begin(), values.end()}});
  }
  std::vector<Shown> shown;
};
std::vector<Shown> shown_by(model::Solver& solver, const State& state, const model::Drive& drive) {
  Record record;
  solver.load(state);
  solver.submit(drive, {}, &record);
  solver.collect();
  return record.shown;
}

// The difference between two solvers in the moves of stage contact in an iteration, in the positions after
// it, and in its change of the velocities after integrate.
struct Parted {
  double moves = 0.0, places = 0.0, settled = 0.0;
  double largest_move = 0.0, largest_settled = 0.0;
  std::size_t iterations = 0;
};
void compare(const std::vector<Shown>& ours, const std::vector<Shown>& theirs, Parted& parted) {
  ASSERT_EQ(ours.size(), theirs.size());
  const auto triple = [](const Shown& of, std::size_t at) {
    return Vector3d(double{of.values[at]}, double{of.values[at + 1]}, double{of.values[at + 2]});
  };
  for (std::size_t k = 1; k < ours.size(); ++k) {
    ASSERT_EQ(ours[k].where.stage, theirs[k].where.stage);
    ASSERT_EQ(ours[k].where.iteration, theirs[k].where.iteration);
    if (ours[k].where.stage != Stage::contact) continue;
    // A position and a velocity per vertex, as for integrate; relax shows only positions. During the
    // iterations the solver stores y's velocity where the Oracle stores the last one; no kernel of stage
    // contact reads it.
    const bool settles = ours[k - 1].where.stage == Stage::integrate;
    ASSERT_TRUE(settles || ours[k - 1].where.stage == Stage::relax);
    parted.iterations += settles ? 0 : 1;
    for (std::size_t at = 0; at < ours[k].values.size(); at += 6) {
      const auto change = [&](const std::vector<Shown>& of) -> Vector3d {
        return settles ? triple(of[k], at + 3) - triple(of[k - 1], at + 3)
                       : triple(of[k], at) - triple(of[k - 1], at / 2);
      };
      const double apart = (change(ours) - change(theirs)).norm(), size = change(theirs).norm();
      double& worst = settles ? parted.settled : parted.moves;
      double& largest = settles ? parted.largest_settled : parted.largest_move;
      largest = std::max(largest, size);
      const double off = (triple(ours[k], at) - triple(theirs[k], at)).norm();
      if (!(apart <= worst)) worst = apart;  // lets a NaN in and keeps it
      if (!(off <= parted.places)) parted.places = off;
    }
  }
}

// Positions near 1 are rounded by 2^-25 per coordinate, and their differences twice: 1.8e-7 including the
// error of the previous iteration. Goals are off by 1.5e-6, as maps are off by 4e-5 over half an edge.
// Velocities follow from a/H times that, 0.01 x 720: 1.1e-5 m/s, and settling combines those of five
// vertices.
constexpr double rounded_place = 4e-7, rounded_velocity = 5e-5;

// Each iteration and the settling, in the first substep and in two with history, with some kinematic
// vertices. The control: changed velocities of kinematic vertices in the previous substep are detected.
TEST(ContactImplicit, FollowsTheOracleInEachStage) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    const bool held = seed % 3 == 1;
    TwoBlocks blocks = make_two_blocks(3, 2 + seed % 2, 3, 0.125, seed, true, held);
    if (seed >= 6) ignore_some_contact(blocks.model, seed);
    const Model& m = blocks.model;
    model::SolverOptions options = contact_options(m);
    if (seed % 2 == 1) options.viscosity = 0.4 * h;
    const auto solver = make_cpu_solver(m, options, 2);
    cpu::Oracle oracle(m, options);
    TestDrive quiet = quiet_drive(m, h);
    State state = overlapping(blocks, solver->save(), seed);
    for (int substep = 0; substep < 3; ++substep) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", substep " + std::to_string(substep));
      const std::vector<Shown> theirs = shown_by(oracle, state, quiet.get());
      Parted parted;
      compare(shown_by(*solver, state, quiet.get()), theirs, parted);
      const State next = solver->save();
      EXPECT_EQ(parted.iterations, contact_options(m).iterations);
      EXPECT_LT(parted.moves, rounded_place);
      EXPECT_LT(parted.places, rounded_place);
      EXPECT_LT(parted.settled, rounded_velocity);
      EXPECT_GT(parted.largest_move, 1e-3);
      EXPECT_GT(parted.largest_settled, 1.0);
      if (held && substep > 0) {
        State other = state;
        for (std::uint32_t i = 0; i < m.vertex_count; ++i)
          if (m.is_kinematic(i)) other.velocities[3 * std::size_t{i}] += 0.3f;
        Parted bent;
        compare(shown_by(*solver, other, quiet.get()), theirs, bent);
        EXPECT_GT(bent.settled, 100.0 * rounded_velocity);
      }
      state = next;
    }
  }
}

// The same with kinematic vertices moved by a skeleton: the second block follows its own bone into the first
// at 1 m/s, so both sides of a contact have had a velocity.
TEST(ContactImplicit, FollowsTheOracleAgainstWhatTheSkeletonMoves) {
  TwoBlocks blocks = make_two_blocks(3, 3, 3, 0.125, 4);
  Model m = without_contact(blocks.model);
  m.joint_count = 2;
  m.skin_offset = {0};
  for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
    m.skin_joint.push_back(i < blocks.first_of_second ? 0 : 1);
    m.skin_weight.push_back(1.0f);
    m.skin_offset.push_back(i + 1);
    if (i % 3 == 0) make_kinematic(m, i);
  }
  fill_weights(m);
  m = make_implicit(m, 2e4);
  add_contact(m, 1.5 * blocks.spacing, depth_below_boundary(m));

  TestDrive drive = quiet_drive(m, h);
  const auto move = [&](int substep) {
    drive.bones[1].xt = -0.8375f + 0.002f * static_cast<float>(substep);
    drive.bones[1].yt = drive.bones[1].zt = 0.046f;
  };
  move(0);
  const auto solver = make_cpu_solver(m, contact_options(m), 1);
  cpu::Oracle oracle(m, contact_options(m));
  State state = model::initial_state(m, drive.bones, m.rest_origin);
  for (int substep = 1; substep <= 6; ++substep) {
    SCOPED_TRACE(substep);
    move(substep);
    const std::vector<Shown> theirs = shown_by(oracle, state, drive.get());
    Parted parted;
    compare(shown_by(*solver, state, drive.get()), theirs, parted);
    EXPECT_LT(parted.moves, rounded_place);
    EXPECT_LT(parted.places, rounded_place);
    EXPECT_LT(parted.settled, rounded_velocity);
    EXPECT_GT(parted.largest_settled, 0.1);
    state = solver->save();
  }
}

// A vertex's vector in the fields of a substep.
Vector3d vector_in(const cpu::Floats& of, std::size_t stride, std::uint32_t i) {
  const float* from = of.data() + stride * std::size_t{i};
  return Vector3d(double{from[0]}, double{from[1]}, double{from[2]});
}

// 1/w' is a vertex's resistance in an iteration. Weighted by it, the moves of contacts have no linear
// momentum, and no angular momentum about the positions at the beginning of the substep, where the two sides
// of each contact coincided. The same holds for the goals, weighted by a/w'. Moves are 1e-3, and positions
// near 1 of 60 vertices are rounded by 3e-8: 1e-5 of a move, a seventh of it in their sum. Goals move by 1/a
// as much. The controls: masses instead of 1/w', the current positions, and a corner that is not pushed back.
TEST(ContactImplicit, OneIterationMovesAndTurnsNothing) {
  const TwoBlocks blocks = implicit_blocks(1e6);
  const Model& m = blocks.model;
  const SubstepWithTables input(m, h);
  const cpu::SubstepInput& in = input.in;
  const State initial = make_cpu_solver(m, contact_options(m), 1)->save();
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const State state = overlapping(blocks, initial, seed);
    cpu::Fields fields;
    size_fields(m, fields);
    size_plain_contact_fields(m, fields);
    for (std::size_t i = 0; i < m.vertex_count; ++i)
      for (std::size_t a = 0; a < 3; ++a)
        fields.vertices[cpu::vertex_stride * i + a] = fields.positions_before[cpu::vector_stride * i + a] =
            fields.goals[cpu::vector_stride * i + a] = state.positions[3 * i + a];
    const auto points = static_cast<std::uint32_t>(m.contact.size());
    find_plainly(m, in, fields);
    for (std::size_t i = 0; i < m.vertex_count; ++i)
      for (std::size_t a = 0; a < 3; ++a)
        fields.vertices[cpu::vertex_stride * i + a] += 0.01f * state.velocities[3 * i + a];
    const cpu::Fields before = fields;
    contact_hold(m, in, fields, {0, points});
    contact_yield(m, in, fields, {0, m.vertex_count});

    Points began, since, moves, goal_moves;
    std::vector<double> hardness, masses, goal_hardness;
    for (std::uint32_t i = 0; i < m.vertex_count; ++i) {
      const shader::Response& answer = in.responses[i];
      began.push_back(vector_in(before.positions_before, cpu::vector_stride, i));
      since.push_back(vector_in(before.vertices, cpu::vertex_stride, i));
      moves.push_back(vector_in(fields.vertices, cpu::vertex_stride, i) - since.back());
      goal_moves.push_back(vector_in(fields.goals, cpu::vector_stride, i) -
                           vector_in(before.goals, cpu::vector_stride, i));
      hardness.push_back(1.0 / (double(m.mobility[i]) * double(answer.to_inertia)));
      goal_hardness.push_back(double(answer.to_goal) * hardness.back());
      masses.push_back(m.mass[i]);
    }
    // The weighted sum of all moves, relative to the sum of their sizes.
    const auto sum_of = [&](const std::vector<double>& weights, const Points& of, const Points& about) {
      Momentum sum;
      double all = 0.0;
      for (std::size_t i = 0; i < of.size(); ++i) {
        const Vector3d term = weights[i] * of[i];
        sum.linear += term;
        sum.angular += about[i].cross(term);
        all += term.norm();
      }
      EXPECT_GT(all, 0.1);
      return Momentum{sum.linear / all, sum.angular / all};
    };
    const double bar = 5e-6;
    EXPECT_LT(sum_of(hardness, moves, began).linear.norm(), bar);
    EXPECT_LT(sum_of(hardness, moves, began).angular.norm(), bar);
    EXPECT_LT(sum_of(goal_hardness, goal_moves, began).linear.norm(), bar);
    EXPECT_LT(sum_of(goal_hardness, goal_moves, began).angular.norm(), bar);
    EXPECT_GT(sum_of(masses, moves, began).linear.norm(), 20.0 * bar);
    EXPECT_GT(sum_of(hardness, moves, since).angular.norm(), 20.0 * bar);
    const auto most = std::max_element(
        moves.begin(), moves.end(), [](const Vector3d& a, const Vector3d& b) { return a.norm() < b.norm(); });
    most->setZero();
    EXPECT_GT(sum_of(hardness, moves, began).linear.norm(), 200.0 * bar);
  }
}

// One substep. Without `settles`, velocities are those after integrate.
ContactResponse step(model::Solver& solver, const Model& m, State& state, bool settles = true) {
  const ContactResponse response = contact_response(solver, m, state, h);
  state = solver.save();
  if (!settles) state.velocities = response.before.velocities;
  return response;
}

// Blocks are thrown at each other at `speed` each. The first contact closes at nearly twice that, and BDF2
// alone would throw it back at more than half of it. Settling leaves a quarter of the earlier velocity, with
// which the history brings it to rest in the next substep. The start is chosen so that the first contact is
// held fully.
TEST(ContactImplicit, TheFirstTouchIsNotThrownBack) {
  const double speed = 0.5;
  for (const double stiffness : {1e3, 2e4, 1e6, 1e8}) {
    SCOPED_TRACE(stiffness);
    TwoBlocks blocks = implicit_blocks(stiffness);
    for (shader::ContactPoint& point : blocks.model.contact) point.margin *= 0.25f;
    const Model& m = blocks.model;
    const auto solver = make_cpu_solver(m, contact_options(m), 1);
    const cpu::Contacts contacts(m);
    const State start = thrown(blocks, solver->save(), speed);
    std::vector<cpu::Contacts::Pair> pairs;
    Points before;
    ContactResponse response;
    // The deepest first.
    const auto first_is_held_in_full = [&] {
      std::sort(pairs.begin(), pairs.end(),
                [](const auto& a, const auto& b) { return a.push.norm() > b.push.norm(); });
      return !pairs.empty() && 32.0 * pairs[0].push.norm() > double(m.contact[pairs[0].point].margin);
    };
    for (int nearer = 0; nearer < 20 && !first_is_held_in_full(); ++nearer) {
      State state = start;
      for (std::uint32_t i = blocks.first_of_second; i < m.vertex_count; ++i)
        state.positions[3 * std::size_t{i}] -= 2.5e-4f * static_cast<float>(nearer);
      solver->load(state);
      pairs.clear();
      for (int k = 0; k < 20 && pairs.empty(); ++k) {
        pairs = contacts.found_at(points_in(state.positions));
        before = points_in(state.velocities);
        response = step(*solver, m, state);
      }
    }
    ASSERT_TRUE(first_is_held_in_full());
    // The velocity, along n, at which the first contact separates.
    const auto leaving = [&](const Points& v) {
      Vector3d u = v[m.contact[pairs[0].point].vertex];
      for (int k = 0; k < 4; ++k) u -= pairs[0].weights[k] * v[pairs[0].corners[std::size_t(k)]];
      return u.dot(pairs[0].normal);
    };
    EXPECT_LT(leaving(before), -1.8 * speed);
    EXPECT_GT(leaving(points_in(response.before.velocities)), speed) << "the control: without settling";
    EXPECT_NEAR(leaving(points_in(response.after.velocities)), leaving(before) / 4.0, 1e-3 * speed);
  }
}

// Damped blocks whose outer ends are held closer together than the blocks are long. After 2 s nothing moves
// faster than 0.2 mm/s (measured 0.03 mm/s), and they hardly overlap. The control: without contact they
// overlap by 3 cm.
TEST(ContactImplicit, WhatIsPressedTogetherComesToRest) {
  const TwoBlocks blocks = implicit_blocks(2e4, 20.0, true);
  const Model& m = blocks.model;
  const auto end_of = [&](const Model& of, bool settles = true) {
    const auto solver = make_cpu_solver(of, contact_options(of), 1);
    State state = thrown(blocks, solver->save(), 0.0);
    for (std::uint32_t i = blocks.first_of_second; i < m.vertex_count; ++i)
      state.positions[3 * std::size_t{i}] -= 0.05f;
    for (int k = 0; k < 960; ++k) step(*solver, of, state, settles);
    return state;
  };
  const auto fastest = [](const State& state) { return largest_in(points_in(state.velocities)); };
  const auto deepest = [&](const State& state) { return model::OverlapMeter(m).of(state.positions).deepest; };
  const State at_rest = end_of(m);
  EXPECT_LT(fastest(at_rest), 2e-4);
  EXPECT_FALSE(cpu::Contacts(m).found_at(points_in(at_rest.positions)).empty()) << "nothing is in contact";
  // The overlap is at most the depth at which contacts are held fully.
  EXPECT_LT(deepest(at_rest), double(m.contact[0].margin) / 32.0);
  EXPECT_GT(deepest(end_of(without_contact(m))), 3.0 * double(m.contact[0].margin) / 32.0)
      << "the control: without contact";
  // If contacts are held fully from almost zero depth, light ones switch on and off. With settling they rest
  // at 0.6 mm/s. The control: with the velocities after integrate they tremble at 6 cm/s.
  Model sharp = m;
  for (shader::ContactPoint& point : sharp.contact) point.margin *= 0x1p-10f;
  EXPECT_LT(fastest(end_of(sharp)), 2e-3);
  EXPECT_GT(fastest(end_of(sharp, false)), 0.05);
}

}  // namespace

}  // namespace fascicle::tests::contact_implicit_test
