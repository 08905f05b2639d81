// Small bodies for tests, made without host/build, so that what both make from one mesh can be compared.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"
#include "host/model/solver.h"

namespace fascicle::tests {

struct Mesh {
  std::vector<Eigen::Vector3d> points;                   // metres
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;  // positive volume
};

// nx x ny x nz cubes of `spacing`, each cut into Kuhn's six tetrahedra; one corner at the origin.
Mesh kuhn_bar(std::uint32_t nx, std::uint32_t ny, std::uint32_t nz, double spacing);

// Moves each point along each axis by a whole number of `step`s, at most `reach`. Volumes stay positive while
// reach x step is below a tenth of the spacing.
Mesh jittered(Mesh mesh, double step, int reach, unsigned seed);

// One regular tetrahedron around the origin, (1,1,1), (1,-1,-1), (-1,1,-1), (-1,-1,1); every number is exact.
Mesh regular_tetrahedron();

struct BodyOptions {
  double density = 1000.0;
  float alpha = 0.5f;
  float beta = 0.0f;
  Eigen::Vector3d fibre{1, 0, 0};
  double damping = 0.0;  // 1/s, of the only layer, `body`
  model::WeightForm weight_form = model::WeightForm::symmetric;
  bool momentum_scaled = true;
  std::function<bool(const Eigen::Vector3d&)> kinematic = {};  // default: none
};

// A model in metres (unit 1) with vertices in the mesh's order. Render vertices are slightly inside the
// boundary.
model::Model make_model(const Mesh& mesh, const BodyOptions& options = {});

// Fills pull, share_taken, share_given and region_rest from the rest of the model, using the Oracle's
// weights. Call again after changing mass, alpha, beta, fibre, tag, weight_form or momentum_scaled.
void fill_weights(model::Model& model);

// The same body for the implicit integrator; every region has Young's modulus E (Pa). Weights must be
// momentum-scaled.
model::Model make_implicit(model::Model model, double E);

void make_kinematic(model::Model& model, std::uint32_t i);

// Adds a volume term with this gain to every region that is not flat. Call after fill_weights.
void add_volume(model::Model& model, float gain);

// Adds two joints. Weights blend linearly along x from the first joint to the second over the middle half of
// the body.
void add_skeleton(model::Model& model);

// Bars of random size, shape and material: alpha, beta and fibre of each vertex, two layers, some kinematic
// vertices, either weight form, momentum-scaled or not, with or without skeleton, muscle, force and volume
// term. Passes check_model.
model::Model random_model(unsigned seed, std::uint32_t most_cells = 3);  // cells along each axis

// A drive that owns what its spans point to. Fill it in, then call get().
struct TestDrive {
  model::Drive drive;
  std::vector<shader::Bone> bones;
  std::vector<shader::Muscle> muscles;
  std::vector<shader::Force> forces;
  std::vector<shader::Collider> colliders;
  std::vector<float> decay;
  model::Drive get();
};

inline constexpr shader::Bone identity_bone = model::bone_at_rest;

// Numbers too small to be factors become 0.
shader::RegionFrame region_frame(const Eigen::Vector3d& normal, const Eigen::Vector3d& axis,
                                 const Eigen::Vector3d& around);

// Puts one muscle with this normal into every `every`-th region; the bone runs across it.
void add_muscle(model::Model& model, const Eigen::Vector3d& normal, double bulge, double shear = 0.0,
                std::uint32_t every = 1);

// A half space a thousand working units below the body.
inline constexpr shader::Collider far_collider = [] {
  shader::Collider c{};
  c.xx = c.yy = c.zz = c.before_xx = c.before_yy = c.before_zz = 1.0f;
  c.yt = c.before_yt = 1000.0f;
  c.is_plane = 1.0f;
  return c;
}();

// Bones at rest, slack muscles, no forces, distant solids, decay by the layers' damping.
TestDrive quiet_drive(const model::Model& model, double h, std::uint32_t substeps = 1,
                      const Eigen::Vector3d& gravity = Eigen::Vector3d::Zero());

}  // namespace fascicle::tests
