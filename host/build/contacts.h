// What lets flesh meet flesh: shaders/kernel/contact.inc.
#pragma once

#include <string>

#include "host/build/contact_groups.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills the model's contact arrays, and mobility, from its rest shape, masses, tags and tetrahedra. Nothing
// is filled where neither the settings say self-contact nor the groups that there are others to meet, or
// where no vertex can move.
//
// Every vertex of the surface is a point. Flesh does not meet what lies nearer to it at rest than the margin:
// settings.distance, or where absent twice the mean edge of the surface. It is refused above a tenth of the
// body's diagonal and four such edges. But limbs that are near each other
// at rest and far apart along the flesh (three times as far as they are near) do meet, from the depth on in
// which they rest.
//
// Points of flesh that meets nothing, and tetrahedra at least two of whose corners are of such flesh, are
// left out, and what is left has depth 0 where it borders on them. With self-contact it is refused where
// nothing is left; without, there is no contact then, nor where no point can meet any tetrahedron. A
// tetrahedron is of a group where at least two of its corners are.
void write_contact(const scene::ContactSettings& settings, const std::string& source, model::Model& model,
                   const ContactGroups& groups = {});

}  // namespace fascicle::build
