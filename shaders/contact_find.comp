// Stage contact, third: the first tetrahedron that a point lies in and may meet, its place there and the way out. The
// boxes only save tests: each encloses all of its tetrahedra. One invocation per point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/indexing/contact_find.glsl"

void main() {
  uint p = item_index();
  if (p >= push.substep.contact_count) return;
  ContactPoint point = contact[p];
  Vector x = place_of(point.vertex);
  uint found = no_contact;
  for (uint branch = 0u; branch < branch_count() && found == no_contact; ++branch) {
    if (!box_holds(contact_branch_box[2u * branch], contact_branch_box[2u * branch + 1u], x)) continue;
    if (is_near_at_rest(point, leaf_count() + branch)) continue;
    uint end = (branch + 1u) * contact_branch;
    if (end > leaf_count()) end = leaf_count();
    for (uint leaf = branch * contact_branch; leaf < end && found == no_contact; ++leaf) {
      if (!box_holds(contact_box[2u * leaf], contact_box[2u * leaf + 1u], x)) continue;
      if (is_near_at_rest(point, leaf)) continue;
      uint last = (leaf + 1u) * contact_leaf;
      if (last > push.substep.contact_tetrahedron_count) last = push.substep.contact_tetrahedron_count;
      for (uint t = leaf * contact_leaf; t < last && found == no_contact; ++t)
        if (meets(p, point, x, t)) found = t;
    }
  }
  contact_found[p] = found;
}
