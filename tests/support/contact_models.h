// Small bodies with self-contact, made without host/build.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/model/model.h"

namespace fascicle::tests {

// Makes every boundary vertex a contact point with this margin (working units) and friction. All tetrahedra
// of the model, in their order, can be touched. Call after make_kinematic and before masses change.
void add_contact(model::Model& model, double margin,
                 const std::function<double(std::uint32_t)>& depth_of_vertex, double friction = 0.5);

// For each vertex, the distance at rest to the nearest boundary vertex; 0 on the boundary.
std::function<double(std::uint32_t)> depth_below_boundary(const model::Model& model);

// Lets point p touch, beyond `allowance`, tetrahedra whose corners are all among these vertices (ascending).
// Call after add_contact.
void add_gap(model::Model& model, std::uint32_t p, const std::vector<std::uint32_t>& vertices,
             float allowance);

// Sorts points and tetrahedra into three groups, some into several and some into none, and makes points
// ignore some of the groups. Call after add_contact.
void ignore_some_contact(model::Model& model, unsigned seed);

// Depths for the groups of contact_group; they differ from vertex to vertex.
void add_group_depths(model::Model& model);

// Fills in what follows from contact, contact_near, contact_depth and contact_tetrahedron: numbers, entries,
// rest boxes and mobility.
void finish_contact(model::Model& model);

// Drops all contact arrays, and mobility unless limits need it.
model::Model without_contact(model::Model model);

}  // namespace fascicle::tests
