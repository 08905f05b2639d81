// The tetrahedral mesh of a surface or a character, and how it relates to the skin that it was made from. It
// either keeps the welded skin as its boundary, or is a cage around it, with vertices of its own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/base/content_hash.h"
#include "host/build/body.h"
#include "host/build/build.h"
#include "host/build/weld.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// A point of the welded skin: the weighted mean of a triangle's corners.
struct SkinPoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weights{1.0, 0.0, 0.0};  // none negative, they sum to 1
};

struct BodyMesh {
  mesh::TetMesh mesh;  // all tetrahedra of positive volume, every vertex used

  // True: the mesh's first vertices are the welded skin's, in its order, and its boundary is the skin; what
  // follows lies inside, and `anchor` and `home` are empty. False: a cage; no vertex need lie on the skin.
  bool keeps_skin = true;

  // Of a cage. For each vertex of the mesh, the nearest point of the skin on the vertex's own side: where
  // limbs touch or cross, tetrahedra exist once for each, at the same place in space, and a vertex's side is
  // the limb whose tetrahedra it belongs to. What is looked up by place alone (weights, bones) may be the
  // other limb's; looked up through the anchor it is not.
  std::vector<SkinPoint> anchor;
  // Of a cage. For each vertex of the welded skin, the tetrahedron of its own side that holds it or is
  // nearest to it. Its least barycentric coordinate there is negative where the skin sticks out, by how far
  // it does.
  std::vector<std::uint32_t> home;
};

// The skin of a scene's surface or character.
struct Skin {
  const WeldedSurface& welded;
  const SkinWeights& weights;                 // of the welded skin; empty without a skeleton
  const std::vector<rig::Joint>& skeleton;    // empty for a surface
  const std::vector<Bone>& bones;             // that get points along them
  const rig::Character* character = nullptr;  // whose clips tell which places of the skin part
};

// Fills a skin with tetrahedra as the scene's body settings say: keeps it, or wraps it in a cage, cuts limbs
// that touch apart and moves the cage out over all of the skin. What was found and chosen goes to the report.
// Throws scene::SceneError.
BodyMesh make_body_mesh(const Skin& skin, const scene::Scene& scene, Report& report,
                        const BuildOptions& options);

// Adds to the key of the cache every setting of the scene that make_body_mesh reads.
void add_mesh_settings(base::ContentHash& hash, const scene::Scene& scene);

}  // namespace fascicle::build
