// Stage collide on the CPU: what solids let the vertices do. See stages.h for how ranges work.
#pragma once

#include "cpu_reference/solver/stages.h"

namespace fascicle::cpu_reference {

// When a substep's positions are there, and of an implicit one in each iteration. Over the vertices.
void collide(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void obstruct(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

// The kernel for one vertex, however far away the solids are. The stages call it for those that
// collide_reach.h does not reject.
void collide_vertex(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i);
void obstruct_vertex(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t i);

}  // namespace fascicle::cpu_reference
