// The kernels of stage contact on the CPU, in their plain form: what the shaders of the same names do, item
// by item. CpuSolver finds the same contacts in less time, see contact_search.h. See stages.h for ranges.
#pragma once

#include <cstdint>

#include "cpu_reference/solver/fields.h"
#include "cpu_reference/solver/stages.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

// Over the leaves, the branches, the points, the points, the vertices; then over the points and the vertices
// alternately. contact_chain must run on one thread.
void contact_bound(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_enclose(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_find(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_chain(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_crowd(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_hold(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_yield(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_settle(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_rest(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_press(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

}  // namespace fascicle::cpu_reference
