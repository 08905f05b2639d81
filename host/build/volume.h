// The volume term of each region: its strength, and what the kernel needs of the region's rest shape
// (shaders/kernel/volume.inc).
#pragma once

#include <vector>

#include "host/model/model.h"

namespace fascicle::build {

// The largest stiffness that a step can handle. The explicit step is stable below 4; this leaves room for
// large deformations. The fixed-point iteration of an implicit step converges below 2, as alpha approaches 1.
inline constexpr double explicit_limit = 2.5, implicit_limit = 1.75;

// G of a region whose stiffest vertex has `alpha`, for the layer's `volume` in [0, 1]. The stiffest mode
// grows from alpha to about alpha (1 + G/2), so volume 1 uses all the room that `limit` leaves; at most 32,
// which makes Poisson's ratio G/(2 G + 3) 0.48.
double volume_gain(double volume, double alpha, double limit = explicit_limit);

// Fills volume_gain and region_volume from the model's rest shape, weights and alpha; `volume` holds a number
// for each layer. Fills nothing if no region gets a gain. A region gets none if its moment at rest is flat
// (its least eigenvalue below 1e-3 of the largest) or too small for the solvers to rotate: there rounding
// would look like a change of volume.
void write_volume(const std::vector<double>& volume, model::Model& model);

}  // namespace fascicle::build
