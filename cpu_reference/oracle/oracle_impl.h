// Oracle's data and its stages, one by one, and their output for probes (oracle_stages.cpp). oracle.cpp runs
// the stages in order.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "cpu_reference/oracle/oracle.h"
#include "cpu_reference/oracle/oracle_collide.h"
#include "cpu_reference/oracle/oracle_contact.h"
#include "cpu_reference/oracle/oracle_equations.h"
#include "cpu_reference/oracle/oracle_implicit.h"
#include "cpu_reference/oracle/oracle_limit.h"
#include "cpu_reference/oracle/oracle_tie.h"
#include "cpu_reference/oracle/oracle_weights.h"
#include "host/model/model.h"
#include "host/model/solver.h"
#include "host/model/substep_plan.h"

namespace fascicle::cpu_reference {

// In the order x y z, and w x y z.
void append(std::vector<float>& floats, const Eigen::Vector3d& v);
void append(std::vector<float>& floats, const Eigen::Quaterniond& q);
std::vector<float> floats_of(const Points& points);

struct Oracle::Impl {
  Impl(const model::Model& of, const model::SolverOptions& with);

  const model::Model& model;
  const model::SolverOptions options;
  const Points rest;
  const Weights weights;
  const Ties ties;
  const Contacts contacts;
  const Limits limits;
  std::vector<Eigen::Matrix3d> rest_moment;  // A_r at rest
  std::vector<double> stiffness;             // K_i; empty with the explicit integrator

  // History.
  std::uint64_t frame = 0;
  std::array<double, 3> origin{0, 0, 0};
  Points q, v;
  Points skinned;                   // of the last substep; empty without a skeleton
  Points skinned_velocities;        // u of the last substep; empty if the model has no carried shares
  std::vector<RegionPose> regions;  // only R is history
  Points q_before, v_before;        // implicit: one substep earlier
  double step_before = 0.0;         // s: the length of that substep; 0 if there was none

  // Between the stages of a substep.
  Points skinned_before;
  Points turned_gravity;  // change of gravity from the bones' rotation
  Points tied;            // accelerations by ties; empty without ties
  std::vector<Contacts::Pair> contacts_found;
  Points goals;
  Points surface;
  Points y, iterate_before;            // implicit
  std::vector<VertexHistory> history;  // implicit: at the substep's start
  std::vector<bool> is_pushed;         // implicit: by a solid, which has already set its velocity

  std::deque<model::Frame> frames;

  // Input of the kernels in one substep.
  struct Substep {
    double h;
    Eigen::Vector3d gravity;
    std::span<const shader::Bone> bones;
    std::span<const shader::Muscle> muscles;
    std::span<const shader::Force> forces;
    std::span<const shader::Collider> colliders;
    std::span<const float> decay;
    std::optional<Stepping> stepping = std::nullopt;    // implicit
    std::optional<Chebyshev> chebyshev = std::nullopt;  // implicit
  };
  Substep substep_of(const model::Drive& drive, std::uint32_t number) const;
  // Runs a kernel of the plan (host/model/substep_plan.h). Kernel::limit runs all passes of stage limit in
  // one call.
  void run(model::Kernel kernel, const Substep& now, std::uint32_t iteration);

  void skin(std::span<const shader::Bone> bones);
  void predict(const Eigen::Vector3d& gravity, std::span<const shader::Force> forces, double h);
  void region(std::span<const shader::Muscle> muscles);
  void goal();
  void integrate(std::span<const float> decay, double h);
  Eigen::Vector3d acceleration_of(std::uint32_t i, const Eigen::Vector3d& gravity,
                                  std::span<const shader::Force> forces) const;
  void begin_implicit(const Eigen::Vector3d& gravity, std::span<const shader::Force> forces,
                      const Stepping& step, double share);
  void relax(double gain, double omega, const Stepping& step);
  void obstruct(const Substep& now);
  void apply_limits(const Stepping& step);
  void collide(const Substep& now);
  void collide_implicit(std::uint32_t i, const Substep& now);
  void finish_implicit(const Stepping& step);
  void respond_to_contacts(double h);
  void hold_contacts(const Stepping& step);
  void settle_contacts(const Stepping& step);
  double stiffest(const Stepping& step) const;
  void embed();

  Eigen::Matrix3d scale_of_region(std::uint32_t r, std::span<const shader::Muscle> muscles) const;
  Eigen::Vector3d skinned_velocity(std::uint32_t i, double h) const;
  void carry(const model::Cut& cut, double h);
  // Appends a field at item i in the format for probes.
  void append_field(std::vector<float>& floats, model::Field field, std::uint32_t i) const;
  std::vector<float> output(model::Stage stage) const;
};

}  // namespace fascicle::cpu_reference
