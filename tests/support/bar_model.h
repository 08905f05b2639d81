// A bar of Kuhn tetrahedra, written directly as a Model so that these tests depend on no other room. Its
// weights are plausible, not the paper's: the tests check that two solvers treat them alike.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/solver.h"

namespace fascicle::tests {

struct BarOptions {
  std::uint32_t x = 9, y = 4, z = 3;  // vertices along each axis
  bool skeleton = false;              // two joints; the second bends and rotates gravity
  bool carried = false;               // vertices feel none, half or all of the skeleton's acceleration
  bool cuts = false;                  // the motion jumps in some frames, in some of them twice
  bool muscle = false;
  bool forces = false;
  bool volume = false;  // two of three regions have a volume term
  bool ties = false;    // ties the top vertices to triangles below them, some with kinematic corners
  bool surface = true;
  bool implicit = false;         // for the implicit integrator, from soft to stiff
  bool limits = false;           // implicit only: no tetrahedron loses more than a tenth of its volume
  bool contact = false;          // most vertices are contact points; most tetrahedra can be touched
  bool ignored_contact = false;  // needs contact: some points ignore some tetrahedra
  bool colliders = false;        // a moving solid of each shape, in the bar's way; some vertices ignore it
  bool odd_vertices = false;     // adds two vertices without neighbours, the second without weight
};

model::Model make_bar(const BarOptions& options);

// Owns what a Drive points to: poses, muscles, forces and solids, all changing every substep, and a moving
// origin.
class BarMotion {
 public:
  BarMotion(const model::Model& model, std::uint32_t substeps, bool cuts = false)
      : model_(model), substeps_(substeps), cuts_(cuts) {}
  // Frame k. Spans stay valid until the next call.
  model::Drive drive(std::uint64_t frame);

 private:
  // The pose at `time`, in substeps. `jump` adds bend and displacement after a cut.
  void append_pose(double time, float jump, std::vector<shader::Bone>& to) const;
  void append_colliders(double time);

  const model::Model& model_;
  std::uint32_t substeps_;
  bool cuts_;
  std::vector<shader::Bone> poses_of_cuts_;
  std::vector<model::Cut> cut_list_;
  std::vector<shader::Bone> bones_;
  std::vector<shader::Muscle> muscles_;
  std::vector<shader::Force> forces_;
  std::vector<shader::Collider> colliders_;
  std::vector<float> decay_;
  std::array<double, 3> origin_{};
};

}  // namespace fascicle::tests
