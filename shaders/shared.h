// Every struct and constant that C++ and GLSL share, except those that only the GPU's layout needs, which are
// in buffers.h. Compiles as C++ (namespace fascicle::shader) and as GLSL (std430). A test compares the
// offsets here with those in the compiled SPIR-V.
#ifndef FASCICLE_SHADERS_SHARED_H
#define FASCICLE_SHADERS_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace fascicle::shader {
using uint = std::uint32_t;
#define SHARED_CONSTANT inline constexpr
#else
#define SHARED_CONSTANT const
#endif

// A joint's affine map from the rest pose to the posed character, three rows of four. Working units; the
// translation is relative to the frame's origin. Also the acceleration that the joint's rotation adds to the
// flesh that follows it: g - R g if the sculpted shape already hangs under gravity, else 0.
struct Bone {
  float xx, xy, xz, xt;
  float yx, yy, yz, yt;
  float zx, zy, zz, zt;
  float gravity_x, gravity_y, gravity_z;
  float unused;
};

// One muscle's values in one substep, equation (17): tau, transformed back to the rest frame, times the
// activation from the joint angle (sines and cosines are computed on the host); the part of the activation
// that has no direction; and the angle by which the bone's far end is twisted about the bone relative to its
// near end.
struct Muscle {
  float tau_x, tau_y, tau_z;
  float swell;
  float twist;
};

// The effect of one muscle on a region: bulge per tau and swell (the muscle's gain x profile x beta_r), and
// shear per twist (its gain x distance from the bone's axis / the bone's length).
struct RegionMuscle {
  uint muscle;
  float bulge;
  float shear;
};

// The unit directions, at rest, in which muscles deform a region: away from the nearest bone and across the
// fibre (n_r), along that bone, and around it.
struct RegionFrame {
  float normal_x, normal_y, normal_z;
  float axis_x, axis_y, axis_z;
  float around_x, around_y, around_z;
};

// Keeps a vertex of a sliding layer at its distance from the flesh below: a spring between the vertex and its
// foot on the plane of a triangle that faces it. Mobilities are n_j w_j / w_s (kernel/tie.inc), 0 for
// kinematic corners.
struct Tie {
  uint sliding;
  uint corner_a, corner_b, corner_c;
  float mobility_a, mobility_b, mobility_c;
  float rest_height;  // working units
};

// A tetrahedron that resists being crushed below a share of its rest volume (kernel/limit.inc). Its size is a
// power of two near the mean of its edges at rest, in working units; volume and gradients are in units of
// that size.
struct Limit {
  uint corner_a, corner_b, corner_c, corner_d;
  float inverse_size;
  float size;
  float least;         // six times the least volume
  float least_square;  // a hundredth of the mean square of the volume's gradients at rest
};

// A point of the body's surface that may enter other flesh (kernel/contact.inc). It does not meet flesh that
// is nearer to it at rest than the margin (working units), except vertices that are near across a gap:
// near_count runs of Model::contact_near, from first_near on.
struct ContactPoint {
  uint vertex;
  float margin;
  float allowance;  // depth in other flesh at rest
  float friction;   // Coulomb's coefficient
  uint first_near;
  uint near_count;
};

// A run of consecutive vertices: the first, and one past the last.
struct VertexRun {
  uint first, end;
};

// One force of the scene in one substep: newtons, or N/m^2 for wind, divided by the working unit.
// Model::force_coefficient (1/kg, or m^2/kg for wind) gives each vertex its share.
struct Force {
  float x, y, z;
  float unused;
};

// A solid that flesh does not enter, in one substep (kernel/collide.inc): a box with its edges rounded by a
// radius (spheres and capsules are such boxes), or everything below y = radius. The maps lead from body space
// (working units relative to the frame's origin) to the solid's own space, at the substep's end and at its
// beginning; they rotate and translate, but do not scale.
struct Collider {
  float xx, xy, xz, xt;
  float yx, yy, yz, yt;
  float zx, zy, zz, zt;
  float before_xx, before_xy, before_xz, before_xt;
  float before_yx, before_yy, before_yz, before_yt;
  float before_zx, before_zy, before_zz, before_zt;
  float half_x, half_y, half_z;  // of the box before rounding
  float radius;                  // of a plane: its thickness
  float friction;                // Coulomb's coefficient
  float lifted;                  // share of its depth by which a vertex that begins inside is lifted
  float is_plane;                // 1 or 0
  float unused;
};

// Inputs of one substep other than buffers. Lengths in working units, time in seconds.
struct Substep {
  float h;
  float inverse_h;
  float gravity_x, gravity_y, gravity_z;
  float shift_x, shift_y, shift_z;  // origin shift, subtracted from positions before the first substep
  uint vertex_count;
  uint surface_count;
  uint joint_count;
  uint first_bone;                 // index of this substep's first Bone
  uint first_muscle;               // index of this substep's first Muscle
  uint first_force;                // index of this substep's first Force
  uint contact_count;              // ContactPoints of the model
  uint contact_tetrahedron_count;  // tetrahedra that points may lie in
  uint first_collider;             // index of this substep's first Collider
  uint collider_count;             // per substep
};

// Further inputs of an implicit substep, with the share t of BDF2 (host/model/implicit.h); t is 0, backward
// Euler, without history (the first step).
struct ImplicitStep {
  float step;           // H = 2h/(2 + t)
  float history;        // t/(2 + t): weight of the previous substep's change; 1/3 for BDF2
  float skin_history;   // t/2: the same in the skinned velocity at the substep's end
  float settled;        // history/(1 + history): after this share of the last velocity, history leaves none
  float start;          // 1 - t/2: a substep of constant acceleration p goes h v + start h^2 p
  float inverse_step;   // 1/H
  float extrapolated;   // share of the last acceleration that the iterations start with
  float omega;          // this iteration's over-relaxation
  float gain;           // factor of x_hat - x
  uint first_response;  // index of vertex 0's Response
  uint limit_count;     // Limits of the model
};

// A vertex's response in an implicit substep, with d its damping and K its stiffness.
struct Response {
  float to_goal;     // a = K H^2 / (m (1 + d H) + K H^2)
  float to_inertia;  // 1 - a: a float a rounds to 1 when stiff
  float kept;        // 1 / (1 + d H): share of the velocity that damping keeps
  float dragged;     // d H / (1 + d H): share of the skeleton's velocity
};

// Passes of stage limit per substep.
SHARED_CONSTANT uint limit_passes = 12u;

// Passes of stage contact per explicit substep. More passes leave less overlap and invert more tetrahedra.
SHARED_CONSTANT uint contact_passes = 2u;

// The search for contacts: tetrahedra per leaf box, and leaf boxes per branch box. No result depends on them.
SHARED_CONSTANT uint contact_leaf = 32u;
SHARED_CONSTANT uint contact_branch = 32u;
SHARED_CONSTANT uint no_contact = 0xffffffffu;

// The most passes over all solids: what one moves into another is then moved along both.
SHARED_CONSTANT uint collide_passes = 6u;

// Vertices per slice of the sliced one-ring lists on the GPU. No result depends on it.
SHARED_CONSTANT uint slice_width = 32u;

// A vertex's tag: the layer in the low byte, and whether it is kinematic (skinned or pinned).
SHARED_CONSTANT uint tag_layer_mask = 0xffu;
SHARED_CONSTANT uint tag_kinematic = 0x100u;

// Rotation extraction, the specialisation constant of region.comp.
SHARED_CONSTANT uint rotation_qcp = 0u;
SHARED_CONSTANT uint rotation_mueller2016 = 1u;

#ifdef __cplusplus
}  // namespace fascicle::shader
#endif
#undef SHARED_CONSTANT
#endif
