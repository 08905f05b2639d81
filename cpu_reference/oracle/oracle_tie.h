// Ties between sliding skin and the flesh below, in double precision, from the rest data: springs to a
// vertex's foot on the plane below, which correct a share of the error per substep. They are ours and not the
// paper's.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "cpu_reference/oracle/oracle_equations.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class Ties {
 public:
  explicit Ties(const model::Model& model);
  bool empty() const { return springs_.empty(); }
  // The accelerations of all vertices in a substep of h seconds that begins at `q` with `v`. The implicit
  // integrator evaluates its ties where the vertices would move by themselves.
  Points accelerations(const Points& q, const Points& v, double h) const;

 private:
  struct Spring {
    std::uint32_t sliding;
    std::array<std::uint32_t, 3> corners;
    double rest_height;
  };
  std::vector<Spring> springs_;
  bool looks_ahead_;
  std::vector<double> ties_at_;   // number per vertex, as a corner
  std::vector<double> mobility_;  // inverse masses, 0 for kinematic vertices
};

// Marks the vertices of layers that ties hold.
std::vector<bool> sliding_vertices(const model::Model& model);

}  // namespace fascicle::cpu_reference
