// Limits that keep tetrahedra from being crushed: shaders/kernel/limit.inc.
#pragma once

#include <vector>

#include "host/model/model.h"

namespace fascicle::build {

// Fills limit, limit_offset, limit_entry and mobility from the model's rest shape, masses and tags.
// `least_volume` holds a number for each layer: the share of its rest volume, in [0, 1], below which none of
// its tetrahedra may be crushed; 0 sets no limit. A tetrahedron of several layers takes the largest share of
// its free corners; one without free corners takes none. Fills nothing if no tetrahedron gets a limit.
void write_limits(const std::vector<double>& least_volume, model::Model& model);

// Fills mobility: the mean mass of the free vertices over each vertex's own mass, 0 for kinematic ones. The
// model must have a free vertex.
void write_mobility(model::Model& model);

}  // namespace fascicle::build
