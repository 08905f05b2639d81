// Stage collide on the CPU: what solids let the vertices do. See stages.h for how ranges work.
#pragma once

#include "cpu_reference/solver/stages.h"

namespace fascicle::cpu_reference {

// When a substep's positions are there, and of an implicit one in each iteration. Over the vertices.
void collide(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void obstruct(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

}  // namespace fascicle::cpu_reference
