// An order of the points of contact that keeps points close to each other at rest close in sequence.
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

// The points of Model::contact in Morton order over the rest shape.
std::vector<std::uint32_t> contact_points_along_curve(const Model& model);

}  // namespace fascicle::model
