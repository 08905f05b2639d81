// Small bodies whose flesh meets itself, made without host/build.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/model/model.h"

namespace fascicle::tests {

// Every vertex of the boundary is a point, with this margin (working units) and friction; all tetrahedra of
// the model may be met, in their order. After make_kinematic; before it changes masses.
void add_contact(model::Model& model, double margin,
                 const std::function<double(std::uint32_t)>& depth_of_vertex, double friction = 0.5);

// Of each vertex its distance to the nearest vertex of the boundary, at rest: 0 on it.
std::function<double(std::uint32_t)> depth_below_boundary(const model::Model& model);

// Lets point p meet, from `allowance` on, what has these corners alone; they must be ascending. After
// add_contact.
void add_gap(model::Model& model, std::uint32_t p, const std::vector<std::uint32_t>& vertices,
             float allowance);

// Sorts points and tetrahedra into three groups, some into several and some into none, and lets points ignore
// some of them. After add_contact.
void ignore_some_contact(model::Model& model, unsigned seed);

// Depths of the groups of contact_group, of a kind: each vertex has others.
void add_group_depths(model::Model& model);

// What follows from contact, contact_near, contact_depth and contact_tetrahedron: numbers, entries, rest
// boxes and mobility.
void finish_contact(model::Model& model);

// Drops all contact arrays, and mobility where no limits need it.
model::Model without_contact(model::Model model);

}  // namespace fascicle::tests
