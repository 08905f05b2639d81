// Cuts a cage apart where it joins limbs that only touch.
//
// A cage around two thighs that touch is one solid: tetrahedra between them hold skin of both. Each such
// tetrahedron is made once for each limb, at the same place; copies are joined to copies next to them that
// hold the same skin, or the same vertex of the cage that lies in that limb, and to no others. So no edge
// joins the limbs, each keeps a solid of its own around all its skin, and they may overlap, as crossing limbs
// do. Copies that would hang on their limb by less than a face are left out. (The virtual node algorithm of
// Molino, Bao and Fedkiw, 2004, with the skin's own connectivity in place of a cutting surface.)
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/body_mesh.h"
#include "host/build/limbs.h"

namespace fascicle::build {

struct CutMesh {
  mesh::TetMesh mesh;
  std::vector<SkinPoint> anchor;  // as in BodyMesh
  // For each vertex of the skin, the tetrahedra of its own limb whose skin it belongs to: CSR.
  std::vector<std::uint32_t> holder_offset, holder;
  std::uint32_t cut_tetrahedra = 0;  // tetrahedra that were made more than once
};

CutMesh cut_limbs(const mesh::TetMesh& cage, const mesh::SurfaceMesh& skin, const Limbs& limbs);

}  // namespace fascicle::build
