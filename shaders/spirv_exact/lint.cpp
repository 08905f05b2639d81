#include <algorithm>
#include <array>
#include <set>

#include "shaders/spirv_exact/exact.h"

namespace fascicle::spirv_exact {
namespace {

struct Range {
  spv::Op first, last;
};

// Opcodes that compute no float, or are checked further below. All others are rejected: float division,
// extended instructions, conversions, dot and matrix products, derivatives, atomics except exchange, subgroup
// operations and whatever a later compiler may emit. The schedule (host/model/stages.h) lists the fields that
// are exchanged; tests compare it with the shaders.
constexpr std::array<Range, 30> harmless{{
    {spv::OpNop, spv::OpUndef},
    {spv::OpSource, spv::OpLine},
    {spv::OpExtension, spv::OpExtInstImport},
    {spv::OpMemoryModel, spv::OpCapability},
    {spv::OpTypeVoid, spv::OpTypeVector},
    {spv::OpTypeArray, spv::OpTypeStruct},
    {spv::OpTypePointer, spv::OpTypeFunction},
    {spv::OpConstantTrue, spv::OpConstantComposite},
    {spv::OpConstantNull, spv::OpConstantNull},
    {spv::OpSpecConstantTrue, spv::OpSpecConstantOp},
    {spv::OpFunction, spv::OpFunctionCall},
    {spv::OpVariable, spv::OpVariable},
    {spv::OpLoad, spv::OpCopyMemory},
    {spv::OpAccessChain, spv::OpInBoundsAccessChain},
    {spv::OpArrayLength, spv::OpArrayLength},
    {spv::OpDecorate, spv::OpMemberDecorate},
    {spv::OpVectorShuffle, spv::OpCopyObject},
    {spv::OpBitcast, spv::OpBitcast},
    {spv::OpSNegate, spv::OpSDiv},  // + - * of integers and floats, and the division of integers
    {spv::OpUMod, spv::OpSMod},
    {spv::OpLogicalEqual, spv::OpFUnordGreaterThanEqual},  // comparisons and select
    {spv::OpShiftRightLogical, spv::OpNot},
    {spv::OpAtomicExchange, spv::OpAtomicExchange},
    {spv::OpPhi, spv::OpSwitch},
    {spv::OpReturn, spv::OpUnreachable},
    {spv::OpNoLine, spv::OpNoLine},
    {spv::OpModuleProcessed, spv::OpModuleProcessed},
    {spv::OpCopyLogical, spv::OpCopyLogical},
    {spv::OpDecorateString, spv::OpDecorateString},
    {spv::OpMemberDecorateString, spv::OpMemberDecorateString},
}};

bool is_harmless(spv::Op opcode) {
  return std::any_of(harmless.begin(), harmless.end(),
                     [&](const Range& r) { return r.first <= opcode && opcode <= r.last; });
}

// Shader, and the two that add_float_controls adds.
bool is_harmless_capability(std::uint32_t capability) {
  return capability == spv::CapabilityShader || capability == spv::CapabilitySignedZeroInfNanPreserve ||
         capability == spv::CapabilityRoundingModeRTE;
}

}  // namespace

std::vector<std::string> lint(Module module) {
  const std::vector<Instruction> instructions = instructions_of(module);
  std::set<std::uint32_t> decorated, scalar_floats;
  std::vector<std::string> faults;
  const auto fault = [&](const Instruction& i, const std::string& what) {
    const auto at = i.words.data() - module.data();
    faults.push_back("word " + std::to_string(at) + ", opcode " + std::to_string(i.opcode) + ": " + what);
  };
  for (const Instruction& i : instructions) {
    if (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationNoContraction)
      decorated.insert(i.words[1]);
    if (i.opcode == spv::OpTypeFloat && i.words[2] == 32) scalar_floats.insert(i.words[1]);
  }
  for (const Instruction& i : instructions) {
    if (is_float_arithmetic(i.opcode) && !decorated.contains(i.words[2]))
      fault(i, "float operation without NoContraction, result %" + std::to_string(i.words[2]));
    if (!is_harmless(i.opcode)) {
      fault(i, i.opcode == spv::OpExtInst ? "extended instruction number " + std::to_string(i.words[4])
                                          : std::string("operation not on the list of harmless ones"));
      continue;
    }
    // An undefined value is up to the driver, and need not be the same at each use.
    if (i.opcode == spv::OpUndef) fault(i, "undefined value");
    if (is_float_arithmetic(i.opcode) && !scalar_floats.contains(i.words[1]))
      fault(i, "float arithmetic on something other than a 32-bit scalar");
    if ((i.opcode == spv::OpTypeFloat || i.opcode == spv::OpTypeInt) && i.words[2] != 32)
      fault(i, "number of " + std::to_string(i.words[2]) + " bits");
    if (i.opcode == spv::OpAtomicExchange && scalar_floats.contains(i.words[1]))
      fault(i, "atomic exchange of a float");
    if (i.opcode == spv::OpSpecConstantOp && is_float_arithmetic(static_cast<spv::Op>(i.words[3])))
      fault(i, "float arithmetic on specialisation constants");
    if (i.opcode == spv::OpCapability && !is_harmless_capability(i.words[1]))
      fault(i, "capability " + std::to_string(i.words[1]));
    const bool relaxed = (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationRelaxedPrecision) ||
                         (i.opcode == spv::OpMemberDecorate && i.words[3] == spv::DecorationRelaxedPrecision);
    if (relaxed) fault(i, "relaxed precision");
  }
  return faults;
}

}  // namespace fascicle::spirv_exact
