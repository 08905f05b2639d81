// Oracle: the method in double precision, written to be read beside the paper. Tests and `validate` step it
// with the same drives as a float solver and compare the two. It shares no arithmetic with the kernels. It
// computes weights, centres and T from the rest data itself, so it tests the Model as well.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "host/model/solver.h"

namespace fascicle::cpu_reference {

class Oracle : public model::Solver {
 public:
  Oracle(const model::Model& model, const model::SolverOptions& options);
  ~Oracle() override;
  void submit(const model::Drive& drive, model::Read what, model::Probe* probe = nullptr) override;
  model::Frame collect() override;
  model::State save() const override;
  void load(const model::State& state) override;

  // Double-precision state, working units, model order.
  const std::vector<Eigen::Vector3d>& positions() const;
  const std::vector<Eigen::Vector3d>& velocities() const;
  // Weight w_ir of vertex i in region r (0 if i is not in it), after momentum scaling, without the Model's
  // common factor.
  double weight(std::uint32_t i, std::uint32_t r) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fascicle::cpu_reference
