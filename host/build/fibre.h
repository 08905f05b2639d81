// The fibre direction of each region.
#pragma once

#include <cstdint>
#include <vector>

#include "host/build/fibre_field.h"
#include "host/build/measures.h"

namespace fascicle::build {

// What the field is held to: on kinematic layers the direction of the nearest bone; on the boundary that
// direction laid into the tangent plane, or what is painted there (attribute _FIBER); and along the drawn
// curves theirs, before all others but bone. Bones are turned so that each has dot >= 0 with the one it hangs
// on.
std::vector<FibreConstraint> fibre_constraints(const scene::Scene& scene,
                                               const std::vector<std::uint32_t>& layer_of, double mean_edge,
                                               Measures& measures);

// 3 floats a vertex: the unit direction of the vertex's layer, constant or from the fibre field, or 0 0 0
// where there is none. Throws scene::SceneError where a layer asks for the field and nothing says where it
// leads.
std::vector<float> fibre_directions(const scene::Scene& scene, const std::vector<std::uint32_t>& layer_of,
                                    const OneRings& rings, Measures& measures, Report& report);

}  // namespace fascicle::build
