// Cuts a cage apart where it joins limbs that merely touch.
//
// A cage around two touching thighs is one solid: tetrahedra between them contain skin of both. Each such
// tetrahedron is duplicated for each limb, at the same place. Copies are joined only to neighbouring copies
// that contain the same skin, or that share a cage vertex lying in that limb. So no edge joins the limbs.
// Each keeps its own solid around all its skin, and the solids may overlap, as crossing limbs do. Copies that
// would hang on their limb by less than a face are dropped. (The virtual node algorithm of Molino, Bao and
// Fedkiw, 2004, with the skin's own connectivity in place of a cutting surface.)
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/body_mesh.h"
#include "host/build/limbs.h"

namespace fascicle::build {

struct CutMesh {
  mesh::TetMesh mesh;
  std::vector<SkinPoint> anchor;  // as in BodyMesh
  // For each vertex of the skin, the tetrahedra of its limb that contain skin it belongs to: CSR.
  std::vector<std::uint32_t> holder_offset, holder;
  std::uint32_t cut_tetrahedra = 0;  // tetrahedra that were duplicated
};

CutMesh cut_limbs(const mesh::TetMesh& cage, const mesh::SurfaceMesh& skin, const Limbs& limbs);

}  // namespace fascicle::build
