// An implicit substep's input and the plain search for contacts, for tests that call the stages directly.
#pragma once

#include <cstdint>
#include <span>

#include "cpu_reference/solver/contact_stages.h"
#include "host/model/implicit.h"
#include "host/model/model.h"
#include "shaders/shared.h"
#include "tests/cpu_reference/two_blocks.h"

namespace fascicle::tests {

// A substep, with history if the model is implicit, and the tables it points to.
struct SubstepWithTables {
  SubstepWithTables(const model::Model& m, double step_length) {
    TestDrive quiet = quiet_drive(m, step_length);
    in.step = model::first_substep(m, quiet.get());
    if (!m.is_implicit()) return;
    tables = model::implicit_tables(m, contact_options(m), step_length);
    in.implicit = model::implicit_step(m, tables, true);
    in.responses = std::span<const shader::Response>(tables.responses)
                       .subspan(in.implicit.first_response, m.vertex_count);
  }
  SubstepWithTables(const SubstepWithTables&) = delete;

  model::ImplicitTables tables;
  cpu_reference::SubstepInput in;
};

inline void find_plainly(const model::Model& m, const cpu_reference::SubstepInput& in,
                         cpu_reference::Fields& fields) {
  const auto points = static_cast<std::uint32_t>(m.contact.size());
  contact_bound(m, in, fields, {0, m.contact_leaf_count()});
  contact_enclose(m, in, fields, {0, m.contact_branch_count()});
  contact_find(m, in, fields, {0, points});
  contact_chain(m, in, fields, {0, points});
  contact_crowd(m, in, fields, {0, m.vertex_count});
}

}  // namespace fascicle::tests
