// Compares what the compiled shaders access with the schedule. Barriers come from the schedule, so an access
// missing there is a race.
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/model/substep_plan.h"
#include "shaders/buffers.h"
#include "shaders/modules.h"
#include "shaders/spirv_exact/module.h"

namespace fascicle::tests {
namespace {

using model::Kernel;

struct Bindings {
  std::set<std::uint32_t> read, written, exchanged;
};

// The bindings accessed by the loads, stores and atomic exchanges of a module.
Bindings bindings_in(spirv_exact::Module module) {
  std::map<std::uint32_t, std::uint32_t> binding_of;  // of variables, and of access chains based on them
  Bindings bindings;
  for (const spirv_exact::Instruction& i : spirv_exact::instructions_of(module)) {
    if (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationBinding)
      binding_of[i.words[1]] = i.words[3];
    if (i.opcode == spv::OpAccessChain || i.opcode == spv::OpInBoundsAccessChain) {
      const auto base = binding_of.find(i.words[3]);
      if (base != binding_of.end()) binding_of[i.words[2]] = base->second;
    }
    if (i.opcode == spv::OpLoad && binding_of.count(i.words[3]) > 0)
      bindings.read.insert(binding_of.at(i.words[3]));
    if (i.opcode == spv::OpStore && binding_of.count(i.words[1]) > 0)
      bindings.written.insert(binding_of.at(i.words[1]));
    if (i.opcode == spv::OpAtomicExchange && binding_of.count(i.words[3]) > 0) {
      bindings.read.insert(binding_of.at(i.words[3]));
      bindings.written.insert(binding_of.at(i.words[3]));
      bindings.exchanged.insert(binding_of.at(i.words[3]));
    }
  }
  return bindings;
}

std::set<std::string> names_of(model::FieldSet set) {
  std::set<std::string> names;
  for (const model::FieldTraits& row : model::field_rows)
    if (set.has(row.field)) names.insert(row.name);
  return names;
}

// The names of the bindings that are fields.
std::set<std::string> names_of(const std::set<std::uint32_t>& bindings) {
  std::set<std::string> names;
  for (const model::FieldTraits& row : model::field_rows)
    if (bindings.count(row.buffer) > 0) names.insert(row.name);
  return names;
}

TEST(SubstepPlanOnTheGpu, ShadersTouchWhatTheScheduleSays) {
  for (std::uint32_t k = 0; k < model::kernel_count; ++k) {
    const model::KernelAccess& access = access_of(static_cast<Kernel>(k));
    SCOPED_TRACE(std::string(access.name));
    const Bindings bindings = bindings_in(shader::module_of(access.name));
    EXPECT_EQ(names_of(access.reads()), names_of(bindings.read));
    EXPECT_EQ(names_of(access.writes), names_of(bindings.written));
    EXPECT_EQ(names_of(access.exchanged), names_of(bindings.exchanged));
  }
}

// Shaders write only fields: the schedule cannot place barriers for other buffers.
TEST(SubstepPlanOnTheGpu, ShadersWriteFieldsOnly) {
  std::set<std::uint32_t> fields;
  for (const model::FieldTraits& row : model::field_rows) fields.insert(row.buffer);
  for (std::uint32_t k = 0; k < model::kernel_count; ++k) {
    const std::string_view name = name_of(static_cast<Kernel>(k));
    const Bindings bindings = bindings_in(shader::module_of(name));
    EXPECT_FALSE(bindings.written.empty()) << name;
    for (const std::uint32_t binding : bindings.written)
      EXPECT_EQ(fields.count(binding), 1u) << name << " writes binding " << binding;
  }
}

}  // namespace
}  // namespace fascicle::tests
