// Parts of a character's skin that the rig moves rigidly: plates, helmets, horns, teeth, eyes, buttons. They
// follow their joints alone, as skinning moves them, and are no flesh.
//
// Found by themselves are parts of the skin that are connected to no other and that one joint moves (each
// vertex by 0.99 of its weights or more), or a blend that is the same all over (no vertex off the mean by
// more than 0.05), with at most a quarter of the skin's area each: a man of separate blocks has flesh in the
// large ones. If all parts of the skin are such, two or more and of two joints or more, the character is a
// robot, and all of it is rigid. So are inlays, teeth, claws and eyes that are modelled into the skin:
// patches of one object and material that one joint moves, of at most a hundredth of the skin's area each. A
// skin in one piece and material has none, however hard its weights: figures of few polygons have hard
// weights everywhere. A joint in skeleton.simulated, and those below it, have none.
//
// Asked for are, by skeleton.rigid, the skin of joints (half of the weights or more), of objects and of
// materials, and where the attribute _RIGID is painted with 0.5 or more.
//
// What is connected to no soft skin is left out when the rest is filled. Its vertices, and those of rigid
// skin within a soft part, ride on carriers: for each set of weights among them one tetrahedron that is
// connected to nothing and moves by just these weights. Blended bones are one affine map of space, so a rider
// keeps its place to rounding. The flesh close to rigid skin is held: it follows the skeleton and cannot come
// through.
#pragma once

#include <string>
#include <vector>

#include "host/build/body.h"
#include "host/build/weld.h"

namespace fascicle::build {

struct RigidSkin {
  std::vector<char> is_rigid;  // a vertex of the welded skin
  std::vector<char> is_apart;  // a vertex of the welded skin: rigid, and connected to no soft one
  std::vector<RigidReport> report;
};

// Throws scene::SceneError for names in skeleton.rigid that nothing has.
RigidSkin find_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                           const SkinWeights& weights, const scene::Scene& scene);

// A character without the skin that is apart: its vertices and triangles in their order.
struct SoftSkin {
  rig::Character character;                  // surface, joints, weights, skeleton and clips
  WeldedSurface welded;                      // of_vertex, too, without what is apart
  std::vector<std::uint32_t> render_vertex;  // of each vertex left, its number before
};
SoftSkin without_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                             const RigidSkin& rigid);

// Adds the carriers to a body that was filled from the soft skin, seats all of the character's render
// vertices and marks what is held. `weights` are those of the welded skin.
void add_rigid_parts(const rig::Character& character, const WeldedSurface& welded, const SkinWeights& weights,
                     const RigidSkin& rigid, const SoftSkin& soft, Body& body);

}  // namespace fascicle::build
