// Bullet's deformable body as a solver of a model: the same tetrahedra, masses, moduli, skeleton and solids,
// stepped by the same drives as fascicle's own solvers. Bullet does elasticity, time stepping, contact with
// planes and self-contact.
//
// What Bullet does not support is applied before each of its steps: kinematic vertices are moved, and the
// velocities of the others receive gravity, its change in the bones' frames, and damping relative to the
// skeleton.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/model/solver.h"

namespace fascicle::bench {

struct BulletSettings {
  bool implicit = false;          // elastic forces by backward Euler; viscosity always is
  bool projects = true;           // contacts by projection; otherwise by Lagrange multipliers
  bool line_search = false;       // in Newton's method
  int newton_steps = 1;           // maximum per substep
  bool linear = false;            // corotated linear elasticity; otherwise Neo-Hookean
  bool converts = true;           // converts moduli to those of Bullet's Neo-Hookean law
  double poisson = 0.3;           // Poisson's ratio
  double viscosity = 0.003;       // s; stress per strain rate, relative to the moduli
  double margin = 0.001;          // m; distance from faces and planes at which contact starts
  double repulsion = 1e4;         // N/m; springs between flesh in contact
  double self_friction = 0.5;     // between flesh and flesh
  bool self = true;               // self-contact
  double error_reduction = 0.06;  // fraction of the depth in a plane that is corrected per substep
  int contact_iterations = 10;    // with solids, per substep
};

// Does not support forces other than gravity, muscles, cuts, or solids other than planes: throws
// std::invalid_argument.
class BulletSolver : public model::Solver {
 public:
  // The model must be implicit, and must outlive the solver.
  BulletSolver(const model::Model& model, const BulletSettings& settings);
  ~BulletSolver() override;

  void submit(const model::Drive& drive, model::Read what, model::Probe* probe) override;
  model::Frame collect() override;
  model::State save() const override;
  void load(const model::State& state) override;

  // The elastic force on each vertex, N, 3 per vertex.
  std::vector<double> flesh_forces();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// "3.24"
std::string bullet_version();

}  // namespace fascicle::bench
