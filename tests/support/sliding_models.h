// Bodies with skin that slides, made without host/build.
#pragma once

#include <functional>

#include <Eigen/Core>

#include "host/model/model.h"

namespace fascicle::tests {

// The place of a triangle nearest to a point, as weights of its corners; by trying all of its features.
Eigen::Vector3d nearest_weights(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b, const Eigen::Vector3d& c);

// Moves the vertices where is_skin(rest position) holds to a layer `skin` (damped as the first) that slides
// on the others: pairs of free vertices of the two are dropped, ties made, weights filled. Before
// make_implicit.
void add_sliding(model::Model& model, const std::function<bool(const Eigen::Vector3d&)>& is_skin);

// A bar of 7 x 4 x 4 vertices, jittered, whose uppermost vertices and those of one side are skin.
model::Model bar_with_skin(bool held = false);

// Puts the skin (the last layer) elsewhere by `offset`, working units.
void displace_skin(const model::Model& model, const Eigen::Vector3d& offset, std::vector<float>& positions);

}  // namespace fascicle::tests
