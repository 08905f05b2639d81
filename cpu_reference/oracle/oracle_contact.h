// Contact between flesh and flesh, in double precision, from the rest data; tests every point against every
// tetrahedron. The response is ours and not the paper's (shaders/kernel/contact.inc describes it).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "cpu_reference/oracle/oracle_equations.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

class Contacts {
 public:
  explicit Contacts(const model::Model& model);
  bool empty() const { return model_.contact.empty(); }

  // A point inside a tetrahedron that it may meet.
  struct Pair {
    std::uint32_t point;                   // of Model::contact
    std::uint32_t tetrahedron;             // of Model::contact_tetrahedron
    std::array<std::uint32_t, 4> corners;  // vertices
    Eigen::Vector4d weights;               // of the point's place in the tetrahedron
    Eigen::Vector3d push, normal;          // d and n; 0 if there is no push
    bool presses = false;                  // in the last iteration
  };
  // In ascending order of point.
  std::vector<Pair> found_at(const Points& places) const;
  // What a pass of the explicit response adds to the velocities `v` of all vertices.
  Points velocity_gains(const std::vector<Pair>& pairs, const Points& v, double h) const;
  // The moves of all vertices in an iteration of the implicit integrator; `moved` is their displacement since
  // the substep began, `yielding` is w', `step` is H.
  Points held_moves(std::vector<Pair>& pairs, const Points& moved, const std::vector<double>& yielding,
                    double step) const;
  // Changes of velocity that bring pressing contacts to rest.
  Points settling_gains(const std::vector<Pair>& pairs, const Points& v, const Points& v_before,
                        double history) const;

 private:
  std::optional<Pair> pair_of(std::uint32_t point, std::uint32_t tetrahedron, const Points& places) const;
  // w times the number of contacts that share the vertex.
  std::vector<double> loads(const std::vector<Pair>& pairs, const std::vector<double>& mobility,
                            double least) const;
  double load_of(const Pair& pair, const std::vector<double>& loads) const;
  Eigen::Vector3d difference(const Pair& pair, const Points& of) const;
  Eigen::Vector3d push_of(const Pair& pair, const Eigen::Vector3d& moved, double wanted) const;
  void give(const Pair& pair, const Eigen::Vector3d& impulse, const std::vector<double>& mobility,
            Points& gains) const;

  const model::Model& model_;
  Points rest_;
  std::vector<double> mobility_;  // inverse masses, 0 for kinematic vertices
};

}  // namespace fascicle::cpu_reference
