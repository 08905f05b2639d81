// Model: everything a solver needs, as flat arrays. Built once, immutable, uploaded once.
//
// Units. Lengths are in working units: `unit` metres, a power of two near the body's size. Rest positions are
// relative to `rest_origin`; positions of a frame are relative to that frame's origin (Drive::origin).
//
// Numbering. Vertices are numbered in the locality order chosen at build; `source_vertex` maps back to the
// tetrahedral mesh. All sums over one-rings run in ascending vertex number, so results depend on this
// numbering bit by bit.
//
// Regions. Region r is vertex r and its one-ring; there is one for each vertex. The one-ring lists leave the
// vertex itself out: its part of each sum is constant or zero.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/base/stepping.h"
#include "shaders/shared.h"

namespace fascicle::model {

struct Layer {
  std::string name;
  double damping = 0.0;  // 1/s
  double density = 0.0;  // kg/m^3
  bool kinematic = false;
  double frequency = 0.0;  // Hz: its lowest mode with everything else held still; 0 if not requested
};

// A named vertex set whose mean position is reported for each frame.
struct ProbeSet {
  std::string name;
  std::vector<std::uint32_t> vertices;  // ascending
};

using base::Integrator;
using base::name_of;
using base::Rotation;
using base::WeightForm;

// The smallest alpha and pull other than 0. Smaller factors are set to 0 at build: they would bring denormal
// numbers, which devices treat differently, into products that are not snapped to zero.
inline constexpr float least_factor = 0x1p-40f;
// Model::carried of flesh that feels four times the skeleton's acceleration.
inline constexpr float least_carried = -3.0f;
// x, or 0 if its magnitude is below least_factor.
inline float as_factor(double x) {
  const auto factor = static_cast<float>(x);
  return std::abs(factor) < least_factor ? 0.0f : factor;
}

// Model::spared has one bit for each.
inline constexpr std::uint32_t most_colliders = 32;

// Number of parts of at most `size` that `count` items make.
inline std::uint32_t parts_of(std::uint32_t count, std::uint32_t size) {
  return count / size + (count % size != 0 ? 1 : 0);
}

struct Model {                                 // each member has a row in model_arrays.h
  double unit = 1.0;                           // metres per working unit
  std::array<double, 3> rest_origin{0, 0, 0};  // metres
  WeightForm weight_form = WeightForm::symmetric;
  bool momentum_scaled = true;  // see docs/design/integrators.md; false: as in the paper

  std::uint32_t vertex_count = 0;
  std::vector<std::uint32_t> source_vertex;  // n: number in the tetrahedral mesh the model was built from
  std::vector<float> rest;                   // 3n: q0_i
  std::vector<double> mass;                  // n: m_i, kg
  std::vector<float> alpha;  // n: stiffness, the paper's in [0,1], stable below 4; 0 or at least
                             // least_factor, 0 for kinematic vertices
  // Only in models for the implicit integrator, else empty; that integrator reads these instead of alpha.
  std::vector<double> youngs_modulus;  // n: E_r of region r, Pa
  std::vector<double> stiffness;       // n: K_i / m_i, 1/s^2, with K_i = sum_{r: i in N_r} k_r m_i
  std::vector<float> beta;             // n: fibre weight of region i; 0 where there is no fibre
  std::vector<float> fibre;            // 3n: unit direction d_r, or 0 0 0
  std::vector<std::uint32_t> tag;      // n: shader::tag_* bits
  std::vector<Layer> layers;

  // One-rings, CSR, ascending, without the vertex itself. The relation is symmetric.
  std::vector<std::uint32_t> ring_offset;  // n + 1
  std::vector<std::uint32_t> ring;         // e

  // Weights (12)(13)(14), written w_ir = pull_i f_ir. f_ir is region r's share in vertex i, sum over r of
  // f_ir = 1 (the share of i in its own region is what remains), a multiple of 2^-16; pull_i is alpha_i m_i
  // (m_i if kinematic) when momentum_scaled, else sum_r w_ir. In an implicit model w_ir includes k_r as well
  // and pull_i is K_i. All pulls carry one common factor, the power of two that brings the mean over regions
  // of |A_r|_F at rest nearest to 1 (within sqrt 2; a power of two is exact).
  std::vector<float> pull;         // n: 0 or at least least_factor
  std::vector<float> share_taken;  // e: entry (r, i) holds f_ir: what region r takes from vertex i
  std::vector<float> share_given;  // e: entry (i, r) holds f_ir: what vertex i gives to region r
  std::vector<float> region_rest;  // 4n: c0_r - q0_r, then 1/W_r (0 where W_r = 0: the region is skipped)

  // Muscles (15)-(17), CSR; empty without muscles. The effects of several muscles on a region add up. The
  // magnitude of every number is 0 or at least least_factor.
  std::uint32_t muscle_count = 0;                   // at most 2^20
  std::vector<std::uint32_t> muscle_offset;         // n + 1 or 0
  std::vector<shader::RegionMuscle> region_muscle;  // for each region by ascending muscle
  std::vector<shader::RegionFrame> region_frame;    // n or 0; unit vectors, or 0 where there is no direction

  // The volume term (shaders/kernel/volume.inc): empty, or one entry per region.
  std::vector<float> volume_gain;    // n or 0: G, at least 0; not read by solvers
  std::vector<float> region_volume;  // 3n or 0: b = det(A0_r)^(-1/3), then |A0^-1|^2 and
                                     // G |A0^-1|^2 / trace(A0^-1) with A0 = b A0_r; 0 1 0 where G is 0

  // Ties between sliding layers and the flesh below, by ascending sliding vertex; empty without ties. For
  // each vertex, the ties that act on it (CSR, ascending) and a coefficient for each, at least least_factor:
  // the share of a substep that they bear times w_i / w_s (shaders/kernel/tie.inc). Kinematic vertices have
  // none.
  std::vector<shader::Tie> tie;
  std::vector<std::uint32_t> tie_offset;  // n + 1 or 0
  std::vector<std::uint32_t> tie_index;
  std::vector<float> tie_coefficient;

  // Tetrahedra protected from being crushed (shaders/kernel/limit.inc), only in implicit models; empty
  // without. For each vertex, kinematic ones too, the tetrahedra that it is a corner of: 4 x number + corner,
  // CSR, ascending. The mobility w_i is the mean mass of the free vertices over m_i, at least least_factor,
  // and 0 for kinematic ones.
  std::vector<shader::Limit> limit;
  std::vector<std::uint32_t> limit_offset;  // n + 1 or 0
  std::vector<std::uint32_t> limit_entry;
  std::vector<float> mobility;  // n with limits or contact, else 0

  // Self-contact (shaders/kernel/contact.inc); empty without. Surface points, by ascending vertex, may come
  // to lie in the tetrahedra. If a point lies in several of them, their order decides which one counts.
  std::vector<shader::ContactPoint> contact;
  std::vector<shader::VertexRun> contact_near;     // ascending and disjoint for each point (contact_near.h)
  std::vector<std::uint32_t> contact_tetrahedron;  // 4 per tetrahedron: corners
  std::vector<float> contact_depth;                // see contact_depth.h; empty without contact
  std::vector<std::uint32_t> contact_number;       // n or 0: the vertex's point, or shader::no_contact
  // For each vertex, the contact tetrahedra that it is a corner of: 4 x number + corner, CSR, ascending.
  std::vector<std::uint32_t> contact_offset;  // n + 1 or 0
  std::vector<std::uint32_t> contact_entry;
  // 8 per box, around shader::contact_leaf tetrahedra at rest, then around shader::contact_branch such boxes:
  // minimum x y z and 0, maximum x y z and 0.
  std::vector<float> contact_rest_box;
  // Pairs of flesh that the scene exempts from contact; both empty without. A tetrahedron may belong to
  // several groups, one bit each; a point does not meet tetrahedra of the groups that it ignores.
  std::vector<std::uint32_t> contact_ignored;  // one per point, or 0
  std::vector<std::uint32_t> contact_group;    // one per tetrahedron of contact_tetrahedron, or 0

  // Skinning, CSR; empty without a skeleton.
  std::uint32_t joint_count = 0;           // at most 2^20
  std::vector<std::uint32_t> skin_offset;  // n + 1 or 0
  std::vector<std::uint32_t> skin_joint;
  std::vector<float> skin_weight;  // sums to 1 for each vertex

  // The share of the skeleton's acceleration that a vertex does not feel: 1 minus its layer's inertia scale,
  // from least_carried to 1, 0 or at least least_factor in magnitude. Empty if every vertex feels all of it,
  // and without a skeleton. An implicit model with a skeleton always has it: with it, solvers keep the
  // skinned velocities of the last substep.
  std::vector<float> carried;  // n or 0

  // Forces besides gravity, CSR; empty without. Acceleration of i += coefficient x Drive force, which is in
  // newtons for a point force and in N/m^2 for wind, both divided by the working unit.
  std::uint32_t force_count = 0;            // at most 2^20
  std::vector<std::uint32_t> force_offset;  // n + 1 or 0
  std::vector<std::uint32_t> force_index;
  std::vector<float> force_coefficient;  // 1/kg; for wind m^2/kg, the vertex's rest area divided by its mass

  // Solids that flesh does not enter (shaders/kernel/collide.inc); the drive says where they are. For each
  // vertex, one bit per solid that does not push it: a solid does not push flesh that it lies in at rest.
  std::uint32_t collider_count = 0;   // at most most_colliders
  std::vector<std::uint32_t> spared;  // n with colliders, else empty

  // The render mesh, in its own vertex order: each vertex is embedded in four vertices of the model.
  std::vector<std::uint32_t> surface_vertex;    // 4m
  std::vector<float> surface_weight;            // 4m, barycentric
  std::vector<std::uint32_t> surface_triangle;  // 3k, numbers of render vertices

  // For metrics and export; no solver reads them.
  std::vector<std::uint32_t> tetrahedron;  // 4t, numbers of model vertices, positive volume
  std::vector<ProbeSet> probes;

  std::uint32_t surface_count() const { return static_cast<std::uint32_t>(surface_vertex.size() / 4); }
  std::uint32_t tetrahedron_count() const { return static_cast<std::uint32_t>(tetrahedron.size() / 4); }
  bool has_skeleton() const { return joint_count > 0; }
  std::uint32_t contact_tetrahedron_count() const {
    return static_cast<std::uint32_t>(contact_tetrahedron.size() / 4);
  }
  std::uint32_t contact_leaf_count() const {
    return parts_of(contact_tetrahedron_count(), shader::contact_leaf);
  }
  std::uint32_t contact_branch_count() const {
    return parts_of(contact_leaf_count(), shader::contact_branch);
  }
  bool has_contact() const { return !contact.empty(); }
  bool has_ignored_contact() const { return !contact_ignored.empty(); }
  // Whether the scene exempts point p of `contact` from meeting tetrahedron t of contact_tetrahedron.
  bool is_ignored_contact(std::uint32_t p, std::uint32_t t) const {
    return has_ignored_contact() && (contact_ignored[p] & contact_group[t]) != 0;
  }
  bool has_colliders() const { return collider_count > 0; }
  bool has_limits() const { return !limit.empty(); }
  bool has_carried() const { return !carried.empty(); }
  bool has_ties() const { return !tie.empty(); }
  bool is_implicit() const { return !stiffness.empty(); }
  bool is_kinematic(std::uint32_t i) const { return (tag[i] & shader::tag_kinematic) != 0; }
  std::uint32_t layer_of(std::uint32_t i) const { return tag[i] & shader::tag_layer_mask; }
};

// Checks every size, index, range and symmetry that the comments above promise. Throws std::invalid_argument
// naming the first array and index that break a promise. Solvers may rely on it.
void check_model(const Model& model);

// The longest side of the axis-aligned bounding box of the rest shape without what carries surroundings
// (surroundings.h), m; 0 without vertices.
double extent(const Model& model);
// The same for each of several characters. Joints from first_joint[k] up to the next entry move the vertices
// of character k; ascending. With fewer than two characters, the whole body's.
std::vector<double> extents(const Model& model, std::span<const std::uint32_t> first_joint);

// Bytes of the arrays that a solver keeps for this model and its state.
std::uint64_t solver_bytes(const Model& model);

}  // namespace fascicle::model
