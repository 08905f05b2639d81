// The kernels of stage contact on the CPU, in their plain form: what the shaders of the same names do, item
// by item. CpuSolver finds the same contacts by a shorter way, contact_search.h. See stages.h for how ranges
// work.
#pragma once

#include <cstdint>

#include "cpu_reference/fields.h"
#include "cpu_reference/stages.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

// Over the leaves, the branches, the points, the blocks of points, the leaves, the vertices, the points, the
// vertices.
void contact_bound(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_enclose(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_find(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_survey(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_locate(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_crowd(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact_press(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);
void contact(const model::Model& model, const SubstepInput& in, Fields& fields, Range range);

// Where stage contact looks for vertex i: three floats.
struct ContactSight {
  float x, y, z;
};
ContactSight contact_sight(const model::Model& model, const SubstepInput& in, const Fields& fields,
                           std::uint32_t i);

// Whether point p, seen at `x`, lies in tetrahedron t and may meet it. If so its contact_place is written.
bool contact_meets(const model::Model& model, const SubstepInput& in, Fields& fields, std::uint32_t p,
                   const ContactSight& x, std::uint32_t t);

// Whether all of a box at rest (Model::contact_rest_box) lies too near to point p to be met.
bool contact_is_near_at_rest(const model::Model& model, std::uint32_t p, std::uint32_t box);

}  // namespace fascicle::cpu_reference
