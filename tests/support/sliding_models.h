// Bodies with sliding skin, made without host/build.
#pragma once

#include <functional>

#include <Eigen/Core>

#include "host/model/model.h"

namespace fascicle::tests {

// The point of a triangle nearest to `point`, as barycentric weights; found by trying all features of the
// triangle.
Eigen::Vector3d nearest_weights(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// Moves the vertices whose rest position satisfies is_skin to a layer `skin` (damped like the first) that
// slides on the others. Drops pairs of free vertices across the two layers, makes ties and fills weights.
// Call before make_implicit.
void add_sliding(model::Model& model, const std::function<bool(const Eigen::Vector3d&)>& is_skin);

// A jittered bar of 7 x 4 x 4 vertices; the top vertices and those of one side are skin.
model::Model bar_with_skin(bool held = false);

// Displaces the skin (the last layer) by `offset`, in working units.
void displace_skin(const model::Model& model, const Eigen::Vector3d& offset, std::vector<float>& positions);

}  // namespace fascicle::tests
