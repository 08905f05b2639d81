// Small bodies with volume limits, made without host/build.
#pragma once

#include "host/model/model.h"

namespace fascicle::tests {

// Adds limits to all tetrahedra with a free corner and a positive volume: each keeps this share of its volume
// at rest. The model must be implicit. Call after make_kinematic, and again after masses change.
void add_limits(model::Model& model, double share);

}  // namespace fascicle::tests
