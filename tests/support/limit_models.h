// Small bodies whose tetrahedra are not crushed, made without host/build.
#pragma once

#include "host/model/model.h"

namespace fascicle::tests {

// Limits of all tetrahedra with a free corner and a positive volume: this share of their volume at rest. Of
// an implicit model, after make_kinematic; call it again after changing masses.
void add_limits(model::Model& model, double share);

}  // namespace fascicle::tests
