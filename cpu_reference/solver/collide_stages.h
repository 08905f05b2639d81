// Stage collide on the CPU: how solids stop vertices. See stages.h for ranges.
#pragma once

#include "cpu_reference/solver/stages.h"

namespace fascicle::cpu_reference {

// Once a substep's positions are known; and in each iteration of an implicit one. Over the vertices.
void collide(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void obstruct(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

// The kernel for one vertex, however far away the solids are. The stages call it for vertices that
// collide_reach.h does not reject.
void collide_vertex(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i);
void obstruct_vertex(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i);

}  // namespace fascicle::cpu_reference
