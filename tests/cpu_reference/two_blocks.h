// Two blocks of flesh in one body, far apart at rest, which the contact tests move into each other.
#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "cpu_reference/solver/cpu_solver.h"
#include "host/model/solver.h"
#include "tests/support/contact_models.h"
#include "tests/support/test_models.h"

namespace fascicle::tests {

struct TwoBlocks {
  model::Model model;
  std::uint32_t first_of_second = 0;  // the second block's vertices start here
  double spacing = 0.0;
};

// Cells along each axis; the second block is a metre beyond the first along x.
inline Mesh two_blocks_mesh(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double spacing,
                            unsigned seed) {
  Mesh mesh = jittered(kuhn_bar(nx, ny, nz, spacing), spacing / 64.0, 5, seed);
  const Mesh other = jittered(kuhn_bar(nx, ny, nz, spacing), spacing / 64.0, 5, seed + 1);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (const Eigen::Vector3d& p : other.points) mesh.points.push_back(p + Eigen::Vector3d(1, 0, 0));
  for (auto t : other.tetrahedra) {
    for (std::uint32_t& i : t) i += first;
    mesh.tetrahedra.push_back(t);
  }
  for (Eigen::Vector3d& p : mesh.points) p -= Eigen::Vector3d(0.75, 0.125, 0.125);
  return mesh;
}

inline TwoBlocks make_two_blocks(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double spacing,
                                 unsigned seed, bool implicit = false, bool held = false) {
  const Mesh mesh = two_blocks_mesh(nx, ny, nz, spacing, seed);
  TwoBlocks blocks{make_model(mesh, {.alpha = 0.4f}), static_cast<std::uint32_t>(mesh.points.size() / 2),
                   spacing};
  for (std::uint32_t i = 0; held && i < blocks.model.vertex_count; i += 5) make_kinematic(blocks.model, i);
  if (held) fill_weights(blocks.model);
  if (implicit) blocks.model = make_implicit(blocks.model, 2e4);
  add_contact(blocks.model, 1.5 * spacing, depth_below_boundary(blocks.model));
  return blocks;
}

inline model::SolverOptions contact_options(const model::Model& model) {
  if (!model.is_implicit()) return {};
  return {.integrator = model::Integrator::implicit_step, .iterations = 20};
}

// The blocks moved into each other, with every vertex displaced and given a random velocity.
inline model::State overlapping(const TwoBlocks& blocks, model::State state, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const double size = 0.08 * blocks.spacing;
  const float along = static_cast<float>(-1.0 + 1.3 * blocks.spacing + 0.1 * blocks.spacing * normal(random));
  for (std::uint32_t i = 0; i < blocks.model.vertex_count; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      float& x = state.positions[3 * std::size_t{i} + a];
      if (i >= blocks.first_of_second) x += a == 0 ? along : 0.37f * static_cast<float>(blocks.spacing);
      x += static_cast<float>(size * normal(random));
      state.velocities[3 * std::size_t{i} + a] = static_cast<float>(0.3 * normal(random));
    }
  return state;
}

// Positions and velocities, three numbers each per vertex.
struct BodyMotion {
  std::vector<float> positions, velocities;
};
// The input and output of stage contact in the first substep from a state.
struct ContactResponse {
  BodyMotion before, after;
  // The change of the velocities.
  std::vector<float> gains() const {
    std::vector<float> gained = after.velocities;
    for (std::size_t k = 0; k < gained.size(); ++k) gained[k] -= before.velocities[k];
    return gained;
  }
};
inline ContactResponse contact_response(model::Solver& solver, const model::Model& model,
                                        const model::State& state, double h) {
  struct Watch : model::Probe {
    void on_stage(const model::Where& where, std::span<const float> values) override {
      if (where.stage == model::Stage::integrate) response.before = motion_in(values);
      if (where.stage == model::Stage::contact) response.after = motion_in(values);
    }
    static BodyMotion motion_in(std::span<const float> values) {
      BodyMotion motion;
      for (std::size_t k = 0; k < values.size(); ++k)
        (k % 6 < 3 ? motion.positions : motion.velocities).push_back(values[k]);
      return motion;
    }
    ContactResponse response;
  } watch;
  solver.load(state);
  TestDrive quiet = quiet_drive(model, h);
  solver.submit(quiet.get(), {}, &watch);
  solver.collect();
  return watch.response;
}
inline std::vector<float> contact_gains(model::Solver& solver, const model::Model& model,
                                        const model::State& state, double h) {
  return contact_response(solver, model, state, h).gains();
}

inline Eigen::Vector3d triple_at(const std::vector<float>& values, std::uint32_t i) {
  const std::size_t k = 3 * std::size_t{i};
  return Eigen::Vector3d(double{values[k]}, double{values[k + 1]}, double{values[k + 2]});
}

}  // namespace fascicle::tests
