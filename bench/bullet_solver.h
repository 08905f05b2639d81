// Bullet's deformable body as a solver of a model: the same tetrahedra, masses, moduli, skeleton and solids,
// stepped by the drives that fascicle's own solvers take. What Bullet does by itself is elasticity, time
// steps, contact with planes and contact with itself.
//
// What Bullet has no word for is done to it from outside, before each of its steps: vertices that are
// kinematic are moved, and the velocities of the others take gravity, its change in the bones' frames, and
// damping relative to the skeleton.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/model/solver.h"

namespace fascicle::bench {

struct BulletSettings {
  bool implicit = false;          // elastic forces, by backward Euler; viscosity always is
  bool projects = true;           // contacts by projection; else by Lagrange multipliers
  bool line_search = false;       // of Newton's steps
  int newton_steps = 1;           // most, a substep
  bool linear = false;            // corotated linear elasticity; else Neo-Hookean
  bool converts = true;           // moduli to what Bullet's Neo-Hookean law takes for them
  double poisson = 0.3;           // Poisson's ratio
  double viscosity = 0.003;       // s: stress by rate of strain, over the moduli
  double margin = 0.001;          // m: how far from faces and planes contact begins
  double repulsion = 1e4;         // N/m: springs between flesh that meets flesh
  double self_friction = 0.5;     // of flesh on flesh
  bool self = true;               // flesh meets flesh
  double error_reduction = 0.06;  // share of a depth in a plane that is taken back in a substep
  int contact_iterations = 10;    // with solids, a substep
};

// Forces beside gravity, muscles, cuts and solids other than planes are not there: std::invalid_argument.
class BulletSolver : public model::Solver {
 public:
  // The model is implicit, and must outlive the solver.
  BulletSolver(const model::Model& model, const BulletSettings& settings);
  ~BulletSolver() override;

  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override;
  model::Frame collect() override;
  model::State save() const override;
  void load(const model::State& state) override;

  // The force of the flesh on each vertex, N, 3 a vertex.
  std::vector<double> flesh_forces();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// "3.24"
std::string bullet_version();

}  // namespace fascicle::bench
