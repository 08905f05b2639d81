// A bar of Kuhn tetrahedra as a Model, written down directly so that these tests need no other room. Its
// weights are plausible, not the paper's: what is tested is that two solvers do the same with them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/model/solver.h"

namespace fascicle::tests {

struct BarOptions {
  std::uint32_t x = 9, y = 4, z = 3;  // vertices along each axis
  bool skeleton = false;              // two joints, the second bends and takes gravity along
  bool carried = false;               // vertices that feel none, half or all of the skeleton's acceleration
  bool cuts = false;                  // the motion jumps in some frames, twice in some
  bool muscle = false;
  bool forces = false;
  bool volume = false;  // a volume term in two of three regions
  bool ties = false;    // of the uppermost vertices to triangles below them, some of which are held
  bool surface = true;
  bool implicit = false;         // for the implicit integrator, from soft to stiff
  bool limits = false;           // of an implicit one: no tetrahedron loses a tenth of its volume
  bool contact = false;          // most vertices are points, in tetrahedra that may be met nearly everywhere
  bool ignored_contact = false;  // beside contact: some points ignore some of them
  bool colliders =
      false;  // a solid of each shape, all of them moving, in the bar's way; some vertices are spared
  bool odd_vertices = false;  // adds one vertex without neighbours, one of those also without weight
};

model::Model make_bar(const BarOptions& options);

// Owns what a Drive points to: poses, muscles, forces and solids that change with every substep, and a
// shifting origin.
class BarMotion {
 public:
  BarMotion(const model::Model& model, std::uint32_t substeps, bool cuts = false)
      : model_(model), substeps_(substeps), cuts_(cuts) {}
  // Frame k; spans live until the next call.
  model::Drive drive(std::uint64_t frame);

 private:
  // The pose at `time`, in substeps; `jump`: how much further it bends and stands after a cut.
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
