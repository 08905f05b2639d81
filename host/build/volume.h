// The volume term of each region: how strong it is, and what the kernel needs of the region's rest shape
// (shaders/kernel/volume.inc).
#pragma once

#include <vector>

#include "host/model/model.h"

namespace fascicle::build {

// Largest stiffness that a step may meet. The explicit step is stable below 4; this leaves room for large
// deformations. The fixed point of an implicit step converges below 2, where alpha comes near 1.
inline constexpr double explicit_limit = 2.5, implicit_limit = 1.75;

// G of a region whose stiffest vertex has `alpha`, for the layer's `volume` in [0, 1]. The stiffest mode
// grows from alpha to about alpha (1 + G/2), so that volume 1 is what `limit` leaves room for; at most 32,
// Poisson's ratio G/(2 G + 3) being 0.48 there.
double volume_gain(double volume, double alpha, double limit = explicit_limit);

// Fills volume_gain and region_volume from the model's rest shape, weights and alpha; `volume` holds a number
// for each layer. Nothing is filled where no region gets a gain. A region whose moment at rest is flat (its
// least eigenvalue below 1e-3 of the largest), or smaller than what the solvers turn, gets none: there
// rounding would pass for a change of volume.
void write_volume(const std::vector<double>& volume, model::Model& model);

}  // namespace fascicle::build
