// Contact between flesh and flesh: shaders/kernel/contact.inc.
#pragma once

#include <string>

#include "host/build/contact_groups.h"
#include "host/model/model.h"
#include "host/scene/scene.h"

namespace fascicle::build {

// Fills the model's contact arrays, and mobility, from its rest shape, masses, tags and tetrahedra. Fills
// nothing if self-contact is off and the groups do not ask for contact with others, or if no vertex can move.
//
// Every vertex of the surface is a point. Flesh does not meet flesh that is nearer to it at rest than the
// margin: settings.distance, by default twice the mean edge of the surface. A distance above both a tenth of
// the body's diagonal and four such edges is an error. Limbs that are close at rest but far apart along the
// flesh (three times the search radius) do meet, but only beyond the depth by which they overlap at rest.
//
// Excludes points of flesh that meets nothing, and tetrahedra with at least two such corners; what remains
// has depth 0 at the border with them. If nothing remains, that is an error with self-contact; without
// self-contact the model gets no contact, nor does it if no point can meet any tetrahedron. A tetrahedron
// belongs to a group if at least two of its corners do.
void write_contact(const scene::ContactSettings& settings, const std::string& source, model::Model& model,
                   const ContactGroups& groups = {});

}  // namespace fascicle::build
