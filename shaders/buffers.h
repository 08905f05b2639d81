// The compute shaders' buffers: one binding number each, the same in every shader, and the records that only
// the GPU's layout needs. Compiles as C++ and as GLSL, like shared.h. A shader's descriptor set holds the
// buffers it uses.
#ifndef FASCICLE_SHADERS_BUFFERS_H
#define FASCICLE_SHADERS_BUFFERS_H

#include "shaders/shared.h"

#ifdef __cplusplus
namespace fascicle::shader {
#define BUFFERS_CONSTANT inline constexpr
#else
#define BUFFERS_CONSTANT const
#endif

// State, one vec4 per vertex unless stated otherwise.
BUFFERS_CONSTANT uint buffer_position = 0u;
BUFFERS_CONSTANT uint buffer_velocity = 1u;
BUFFERS_CONSTANT uint buffer_rotation = 2u;  // w x y z
BUFFERS_CONSTANT uint buffer_transform =
    3u;  // the rows of linear map and translation: all first rows, all second, all third
BUFFERS_CONSTANT uint buffer_goal = 4u;
BUFFERS_CONSTANT uint buffer_skinned = 5u;           // this substep's
BUFFERS_CONSTANT uint buffer_skinned_before = 6u;    // the last substep's
BUFFERS_CONSTANT uint buffer_skinned_velocity = 7u;  // the last substep's
BUFFERS_CONSTANT uint buffer_gravity = 8u;           // change of gravity as the bones turn
BUFFERS_CONSTANT uint buffer_surface = 9u;           // three floats per render vertex

// Static.
BUFFERS_CONSTANT uint buffer_rest = 10u;           // rest position, pull
BUFFERS_CONSTANT uint buffer_tag = 11u;            // tag of shared.h, above it the one-ring's size
BUFFERS_CONSTANT uint buffer_slice = 12u;          // first entry of each slice of one-rings
BUFFERS_CONSTANT uint buffer_ring = 13u;           // entries, sliced: neighbours; empty if all are near
BUFFERS_CONSTANT uint buffer_share_taken = 14u;    // entries, sliced: shares; if near, neighbours too
BUFFERS_CONSTANT uint buffer_share_given = 15u;    // entries, sliced: shares; if near, neighbours too
BUFFERS_CONSTANT uint buffer_region_rest = 16u;    // c0_r - q0_r, 1/W_r
BUFFERS_CONSTANT uint buffer_muscle_offset = 17u;  // first RegionMuscle of each region, and the count
BUFFERS_CONSTANT uint buffer_region_frame = 18u;   // RegionFrame
BUFFERS_CONSTANT uint buffer_skin_offset = 19u;
BUFFERS_CONSTANT uint buffer_skin_joint = 20u;
BUFFERS_CONSTANT uint buffer_skin_weight = 21u;
BUFFERS_CONSTANT uint buffer_force_offset = 22u;
BUFFERS_CONSTANT uint buffer_force_index = 23u;
BUFFERS_CONSTANT uint buffer_force_coefficient = 24u;
BUFFERS_CONSTANT uint buffer_surface_vertex = 25u;  // uvec4 per render vertex
BUFFERS_CONSTANT uint buffer_surface_weight = 26u;
BUFFERS_CONSTANT uint buffer_region_muscle = 33u;  // RegionMuscle
BUFFERS_CONSTANT uint buffer_region_volume = 34u;  // b, |A0^-1|^2, gain of kernel/volume.inc

// Drive of a frame.
BUFFERS_CONSTANT uint buffer_bone = 27u;
BUFFERS_CONSTANT uint buffer_muscle = 28u;
BUFFERS_CONSTANT uint buffer_force = 29u;
BUFFERS_CONSTANT uint buffer_decay = 30u;

// The self-test's table: inputs, results.
BUFFERS_CONSTANT uint buffer_self_test_input = 31u;
BUFFERS_CONSTANT uint buffer_self_test_result = 32u;

// State of an implicit model. One vec4 per vertex.
BUFFERS_CONSTANT uint buffer_position_before = 35u;  // a substep earlier; from predict on, this one's start
BUFFERS_CONSTANT uint buffer_velocity_before = 36u;
BUFFERS_CONSTANT uint buffer_predicted = 38u;       // y
BUFFERS_CONSTANT uint buffer_iterate_before = 39u;  // the iterate before the last
BUFFERS_CONSTANT uint buffer_response = 40u;        // Response, without history, then with

// Models with ties.
BUFFERS_CONSTANT uint buffer_tied = 41u;  // the accelerations from ties, one vec4 per vertex
BUFFERS_CONSTANT uint buffer_tie = 42u;   // Tie
BUFFERS_CONSTANT uint buffer_tie_offset = 43u;
BUFFERS_CONSTANT uint buffer_tie_index = 44u;
BUFFERS_CONSTANT uint buffer_tie_coefficient = 45u;

BUFFERS_CONSTANT uint buffer_alpha = 46u;
BUFFERS_CONSTANT uint buffer_carried =
    37u;  // share of the skeleton's acceleration that a vertex does not feel

// Models with limits.
BUFFERS_CONSTANT uint buffer_limit = 47u;         // Limit
BUFFERS_CONSTANT uint buffer_limit_offset = 48u;  // first entry of each vertex, and the count
BUFFERS_CONSTANT uint buffer_limit_entry = 49u;   // 4 x Limit + corner
BUFFERS_CONSTANT uint buffer_mobility = 50u;      // one float per vertex
BUFFERS_CONSTANT uint buffer_lack = 51u;          // one float per Limit
BUFFERS_CONSTANT uint buffer_limit_load = 52u;    // one float per vertex

// Models with contact.
BUFFERS_CONSTANT uint buffer_contact = 53u;              // ContactPoint
BUFFERS_CONSTANT uint buffer_contact_near = 54u;         // VertexRun
BUFFERS_CONSTANT uint buffer_contact_tetrahedron = 55u;  // uvec4: corners
BUFFERS_CONSTANT uint buffer_contact_depth = 56u;        // one float per vertex
BUFFERS_CONSTANT uint buffer_contact_number = 57u;       // each vertex's ContactPoint, or no_contact
BUFFERS_CONSTANT uint buffer_contact_offset = 58u;       // first entry of each vertex, and the count
BUFFERS_CONSTANT uint buffer_contact_entry = 59u;        // 4 x tetrahedron + corner
BUFFERS_CONSTANT uint buffer_contact_rest_box = 60u;     // two vec4 per box: the leaves, then the branches
BUFFERS_CONSTANT uint buffer_contact_box = 61u;          // two vec4 per leaf: its current bounds
BUFFERS_CONSTANT uint buffer_contact_branch_box = 62u;   // the same per branch
BUFFERS_CONSTANT uint buffer_contact_found = 63u;    // the tetrahedron that each point lies in, or no_contact
BUFFERS_CONSTANT uint buffer_contact_place = 64u;    // three vec4 per point: weights, push, normal
BUFFERS_CONSTANT uint buffer_contact_first = 65u;    // the first point of each tetrahedron's chain, or none
BUFFERS_CONSTANT uint buffer_contact_next = 66u;     // the point after each in its chain, or none
BUFFERS_CONSTANT uint buffer_contact_crowd = 67u;    // S, one float per vertex
BUFFERS_CONSTANT uint buffer_contact_impulse = 68u;  // J, one vec4 per point

// Models with colliders.
BUFFERS_CONSTANT uint buffer_spared = 69u;    // one uint per vertex: a bit for each solid it ignores
BUFFERS_CONSTANT uint buffer_collider = 70u;  // Collider, of one frame

// Models whose scene excludes some contacts.
BUFFERS_CONSTANT uint buffer_contact_ignored =
    71u;  // one uint per point: a bit for each group it does not meet
BUFFERS_CONSTANT uint buffer_contact_group = 72u;  // one uint per tetrahedron: a bit for each group it is in

BUFFERS_CONSTANT uint buffer_count = 73u;

// In buffer_tag.
BUFFERS_CONSTANT uint degree_shift = 16u;
// Near entries: the neighbour minus the slice's first vertex, signed; above it the share in units of 2^-16.
BUFFERS_CONSTANT uint share_shift = 16u;

// Specialisation constants.
BUFFERS_CONSTANT uint constant_rotation = 0u;  // rotation_qcp or rotation_mueller2016
BUFFERS_CONSTANT uint constant_muscles = 1u;   // the model has muscles
BUFFERS_CONSTANT uint constant_forces = 2u;    // the model has forces besides gravity
BUFFERS_CONSTANT uint constant_carried = 3u;   // some vertices do not feel all of the skeleton's acceleration
BUFFERS_CONSTANT uint constant_volume = 4u;    // some regions have a volume term
BUFFERS_CONSTANT uint constant_implicit = 5u;  // the model is implicit
BUFFERS_CONSTANT uint constant_ties = 6u;      // the model has ties
BUFFERS_CONSTANT uint constant_group_size = 7u;        // invocations per workgroup, a multiple of slice_width
BUFFERS_CONSTANT uint constant_near = 8u;              // all neighbours and shares fit 16 bits
BUFFERS_CONSTANT uint constant_ahead = 9u;             // neighbours read ahead of the first use
BUFFERS_CONSTANT uint constant_ignored_contact = 10u;  // the scene excludes some contacts
BUFFERS_CONSTANT uint constant_count = 11u;

// The self-test's results per row: scalar operations, operations on a positive number, two quaternions.
BUFFERS_CONSTANT uint self_test_scalars = 19u;
BUFFERS_CONSTANT uint self_test_positives = 3u;
BUFFERS_CONSTANT uint self_test_results = self_test_scalars + self_test_positives + 8u;

// A dispatch's push constants. Invocation k over all workgroups handles item first_slice x slice_width + k,
// so a stage can be split into several dispatches.
struct Push {
  Substep substep;
  uint first_slice;
  ImplicitStep implicit;
};

#ifdef __cplusplus
}  // namespace fascicle::shader
#endif
#undef BUFFERS_CONSTANT
#endif
