// The fibre direction of each region.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/fibre_field.h"
#include "host/build/measures.h"

namespace fascicle::build {

// The constraints of the field: on kinematic layers, the direction of the nearest bone; on the boundary, that
// direction projected into the tangent plane, or the painted one (attribute _FIBER); along drawn curves,
// their direction, which overrides all others except bone. Bones are oriented so that each has dot >= 0 with
// its parent bone.
std::vector<FibreConstraint> fibre_constraints(const scene::Scene& scene,
                                               const std::vector<std::uint32_t>& layer_of, double mean_edge,
                                               Measures& measures);

// 3 floats per vertex: the unit direction of the vertex's layer, constant or from the fibre field, or 0 0 0
// if there is none. Throws scene::SceneError if a layer uses the field and there are no constraints.
std::vector<float> fibre_directions(const scene::Scene& scene, const std::vector<std::uint32_t>& layer_of,
                                    const OneRings& rings, Measures& measures, Report& report);

}  // namespace fascicle::build
