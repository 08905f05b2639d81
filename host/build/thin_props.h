// Props that are too thin for their tetrahedra.
#pragma once

#include "host/build/body.h"

namespace fascicle::build {

// Warns of a prop that has most of its volume in tetrahedra with all corners on its surface: depth is 0 at
// all of them, so nothing tells the way out (shaders/kernel/contact.inc). `found` is the report on this body
// alone.
void warn_of_thin_prop(const Body& body, const std::string& source, Report& found);

}  // namespace fascicle::build
