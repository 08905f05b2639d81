// A body of flesh and, in its render mesh, boxes that only the skeleton moves: floors, walls, props.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/model/model.h"

namespace fascicle::tests {

struct Box {
  Eigen::Vector3f low, high;  // m
};

// A bar of 1 x 0.5 x 0.5 m from the origin. Render vertices 0 to 7 are its corners; each box follows with
// eight of its own, which are at kinematic vertices of the model.
model::Model bar_and_boxes(const std::vector<Box>& boxes);

}  // namespace fascicle::tests
