// The tetrahedral mesh of a surface or a character, and its relation to the skin it was made from. The mesh
// either keeps the welded skin as its boundary, or is a cage around it, with its own vertices.
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
  std::array<double, 3> weights{1.0, 0.0, 0.0};  // not negative, they sum to 1
};

struct BodyMesh {
  mesh::TetMesh mesh;  // all tetrahedra of positive volume, every vertex used

  // True: the mesh's first vertices are those of the welded skin, in its order, and its boundary is the skin.
  // The remaining vertices lie inside, and `anchor` and `home` are empty. False: a cage; no vertex need lie
  // on the skin.
  bool keeps_skin = true;

  // Cage only. For each vertex of the mesh, the nearest point of the skin on the vertex's own side. Where
  // limbs touch or cross, each limb has its own tetrahedra at the same place in space, and a vertex's side is
  // the limb that its tetrahedra belong to. A lookup by position alone (weights, bones) may find the other
  // limb; a lookup through the anchor does not.
  std::vector<SkinPoint> anchor;
  // Cage only. For each vertex of the welded skin, the tetrahedron on its own side that contains it or is
  // nearest to it. A negative least barycentric coordinate there tells how far the skin sticks out.
  std::vector<std::uint32_t> home;
};

// The skin of a scene's surface or character.
struct Skin {
  const WeldedSurface& welded;
  const SkinWeights& weights;                 // of the welded skin; empty without a skeleton
  const std::vector<rig::Joint>& skeleton;    // empty for a surface
  const std::vector<Bone>& bones;             // bones that get mesh points along them
  const rig::Character* character = nullptr;  // its clips tell where the skin parts
};

// Fills a skin with tetrahedra as the scene's body settings say: keeps it, or wraps it in a cage, cuts
// touching limbs apart and moves the cage outward until it holds all of the skin. Findings and choices go to
// the report. Throws scene::SceneError.
BodyMesh make_body_mesh(const Skin& skin, const scene::Scene& scene, Report& report,
                        const BuildOptions& options);

// Adds every scene setting that make_body_mesh reads to the cache key.
void add_mesh_settings(base::ContentHash& hash, const scene::Scene& scene);

}  // namespace fascicle::build
