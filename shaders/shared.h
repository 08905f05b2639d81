// Every struct and constant that C++ and GLSL both see, but for those that only the GPU's layout needs: these
// are in buffers.h. Compiles as C++ (namespace fascicle::shader) and as GLSL (std430). A test holds the
// offsets here against the offsets in the compiled SPIR-V.
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
// translation is relative to the frame's origin. Beside it the acceleration that flesh following the joint
// takes because the joint has turned: g - R g where the sculpted shape hangs under gravity already, else 0.
struct Bone {
  float xx, xy, xz, xt;
  float yx, yy, yz, yt;
  float zx, zy, zz, zt;
  float gravity_x, gravity_y, gravity_z;
  float unused;
};

// One muscle's values in one substep, equation (17): tau, carried back to the rest frame, times the
// activation that the joint angle gives (sines and cosines are taken on the host); the part of the activation
// that has no direction; and the angle by which the far end of its bone is turned about the bone against the
// near end.
struct Muscle {
  float tau_x, tau_y, tau_z;
  float swell;
  float twist;
};

// What a region takes of one muscle: bulge of tau and swell (the muscle's gain x profile x beta_r), and shear
// of the twist (its gain x distance from the bone's axis over the bone's length).
struct RegionMuscle {
  uint muscle;
  float bulge;
  float shear;
};

// The unit directions, at rest, in which muscles change a region: away from the nearest bone and across the
// fibre (n_r), along that bone, and around it.
struct RegionFrame {
  float normal_x, normal_y, normal_z;
  float axis_x, axis_y, axis_z;
  float around_x, around_y, around_z;
};

// What keeps a vertex of a layer that slides at its distance from the flesh below: a spring between the
// vertex and its foot on the plane of a triangle, which faces it. Mobilities are n_j w_j / w_s
// (kernel/tie.inc), 0 of corners that are kinematic.
struct Tie {
  uint sliding;
  uint corner_a, corner_b, corner_c;
  float mobility_a, mobility_b, mobility_c;
  float rest_height;  // working units
};

// A tetrahedron that is not crushed below a share of its rest volume (kernel/limit.inc). Its size is a power
// of two near the mean of its edges at rest, in working units; volume and gradients are in parts of that.
struct Limit {
  uint corner_a, corner_b, corner_c, corner_d;
  float inverse_size;
  float size;
  float least;         // six times the least volume
  float least_square;  // a hundredth of the mean square of the volume's gradients at rest
};

// A point of the body's surface that may come to lie in other flesh (kernel/contact.inc). Flesh that is
// nearer to it at rest than the margin (working units) does not meet it, but for the vertices that are near
// it across a gap: those of so many runs of Model::contact_near, from first_near on.
struct ContactPoint {
  uint vertex;
  float margin;
  float allowance;  // how deep it lies in other flesh at rest
  float friction;   // Coulomb's coefficient
  uint first_near;
  uint near_count;
};

// Vertices that follow each other: the first of them, and one after the last.
struct VertexRun {
  uint first, end;
};

// One force of the scene in one substep: newtons, or for wind N/m^2, divided by the working unit. A vertex
// takes its share of it through Model::force_coefficient (1/kg, for wind m^2/kg).
struct Force {
  float x, y, z;
  float unused;
};

// A solid that flesh does not enter, in one substep (kernel/collide.inc): a box whose edges are rounded by a
// radius (a sphere and a capsule are such boxes), or all that lies below y = radius. The maps lead from the
// body's space (working units relative to the frame's origin) into the solid's own, at the substep's end and
// at its beginning; they turn and shift, and do not scale.
struct Collider {
  float xx, xy, xz, xt;
  float yx, yy, yz, yt;
  float zx, zy, zz, zt;
  float before_xx, before_xy, before_xz, before_xt;
  float before_yx, before_yy, before_yz, before_yt;
  float before_zx, before_zy, before_zz, before_zt;
  float half_x, half_y, half_z;  // of the box before it is rounded
  float radius;                  // of a plane: how thick it is
  float friction;                // Coulomb's coefficient
  float lifted;                  // share of its depth that a vertex that begins inside is lifted by
  float is_plane;                // 1 or 0
  float unused;
};

// What one substep needs beside the buffers. Lengths in working units, time in seconds.
struct Substep {
  float h;
  float inverse_h;
  float gravity_x, gravity_y, gravity_z;
  float shift_x, shift_y, shift_z;  // origin shift, taken off all positions before the frame's first substep
  uint vertex_count;
  uint surface_count;
  uint joint_count;
  uint first_bone;                 // index of this substep's first Bone
  uint first_muscle;               // index of this substep's first Muscle
  uint first_force;                // index of this substep's first Force
  uint contact_count;              // ContactPoints of the model
  uint contact_tetrahedron_count;  // tetrahedra that points may lie in
  uint first_collider;             // index of this substep's first Collider
  uint collider_count;             // a substep
};

// What an implicit substep needs beside. With history (BDF2) H = 2h/3, without (backward Euler, the first
// step) H = h and the shares of history are 0.
struct ImplicitStep {
  float step;           // H
  float history;        // 1/3: what the change from the substep before counts in (4 q - q_prev)/3
  float skin_history;   // 1/2: the same in the skinned velocity at the substep's end
  float inverse_step;   // 1/H
  float extrapolated;   // the share of the last acceleration with which the iterations start
  float omega;          // this iteration's over-relaxation
  float gain;           // what x_hat - x is multiplied by
  uint first_response;  // index of vertex 0's Response
  uint limit_count;     // Limits of the model
};

// How a vertex answers in an implicit substep, with d its damping and K its stiffness.
struct Response {
  float to_goal;     // a = K H^2 / (m (1 + d H) + K H^2)
  float to_inertia;  // 1 - a: a float a rounds to 1 when stiff
  float kept;        // 1 / (1 + d H): what damping leaves of the velocity
  float dragged;     // d H / (1 + d H): the share of the skeleton's
};

// Passes of stage limit in a substep.
SHARED_CONSTANT uint limit_passes = 12u;

// Passes of stage contact in an explicit substep. More leave less overlap and turn more tetrahedra inside
// out.
SHARED_CONSTANT uint contact_passes = 2u;

// The search for contacts: tetrahedra whose boxes have one box around them, and such boxes that have one. No
// result depends on them.
SHARED_CONSTANT uint contact_leaf = 32u;
SHARED_CONSTANT uint contact_branch = 32u;
SHARED_CONSTANT uint no_contact = 0xffffffffu;

// Looks at all solids in a row, most: what one moves into another is moved on along both.
SHARED_CONSTANT uint collide_passes = 6u;

// Vertices per slice of the sliced one-ring lists on the GPU. No result depends on it.
SHARED_CONSTANT uint slice_width = 32u;

// A vertex's tag: the layer in the low byte, and whether it is kinematic (moved by skinning or pinned).
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
