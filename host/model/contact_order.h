// An order of the points of contact in which those that follow each other lie near each other at rest.
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/model.h"

namespace fascicle::model {

// The points of Model::contact along Morton's curve through the rest shape.
std::vector<std::uint32_t> contact_points_along_curve(const Model& model);

}  // namespace fascicle::model
