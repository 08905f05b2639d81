// Parts of a character's skin that the rig moves rigidly: plates, helmets, horns, teeth, eyes, buttons. They
// follow only their joints, as skinning moves them, and are not flesh.
//
// Found automatically are parts of the skin that are connected to no other part and are moved by one joint
// (each vertex by at least 0.99 of its weights) or by a uniform blend (no vertex off the mean by more than
// 0.05). Each has at most a quarter of the skin's area: a man made of separate blocks has flesh in the
// large ones. Floors and walls are larger: flat parts moved by one joint. Where they are most of the skin,
// the shares of the other parts are those without them. If all parts of the skin are such, at least two parts
// and of at least two joints, the character is a robot, and all of it is rigid. Inlays, such as teeth, claws
// and eyes modelled into the skin, are found too: patches of one object and material moved by one joint, each
// with at most a hundredth of the skin's area. A skin in one piece and one material has none, however hard
// its weights: low-polygon figures have hard weights everywhere. A joint in skeleton.simulated, and those
// below it, have none.
//
// The user can add, by skeleton.rigid, the skin of joints (at least half of the weights), of objects and of
// materials, and paint the attribute _RIGID with at least 0.5.
//
// Rigid skin that is connected to no soft skin is left out when the rest is filled. Its vertices, and those
// of rigid skin within a soft part, ride on carriers. A carrier is a tetrahedron, one for each set of weights
// among these vertices (beyond 3,000, for similar ones), that is connected to nothing and moves by these
// weights alone. Blended bones are a single affine map of space, so a rider keeps its place to rounding. A
// separate part with an almost uniform blend moves by the mean of its weights: it has one carrier and keeps
// its shape, whatever noise its weights have. So does a part moved by one joint that has more than 1,000 sets
// of weights. Flesh close to rigid skin is held: it follows the skeleton and cannot poke through.
#pragma once

#include <string>
#include <vector>

#include "host/build/body.h"
#include "host/build/weld.h"

namespace fascicle::build {

struct RigidSkin {
  std::vector<char> is_rigid;  // per vertex of the welded skin
  std::vector<char> is_apart;  // per vertex of the welded skin: rigid, and connected to no soft skin
  // Per vertex of the welded skin: on a whole part that would hide bones, because it was requested and is
  // more than a quarter of the skin, or is one of the floors that are most of it. Bones are chosen without
  // it.
  std::vector<char> is_beside;
  SkinWeights weights;  // of the welded skin; a separate part with an almost uniform blend has its mean
  std::vector<RigidReport> report;
};

// Throws scene::SceneError for names in skeleton.rigid that do not exist.
RigidSkin find_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                           const SkinWeights& weights, const scene::Scene& scene);

// A character without the skin that is apart; the remaining vertices and triangles keep their order.
struct SoftSkin {
  rig::Character character;                  // surface, joints, weights, skeleton and clips
  WeldedSurface welded;                      // of_vertex is also without the skin that is apart
  std::vector<std::uint32_t> render_vertex;  // for each remaining vertex, its previous number
};
SoftSkin without_rigid_parts(const rig::Character& character, const WeldedSurface& welded,
                             const RigidSkin& rigid);

// Adds the carriers to a body that was filled from the soft skin, places all of the character's render
// vertices and marks the held flesh.
void add_rigid_parts(const rig::Character& character, const WeldedSurface& welded, const RigidSkin& rigid,
                     const SoftSkin& soft, Body& body);

}  // namespace fascicle::build
