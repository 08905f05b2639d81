#include "shaders/spirv_exact/module.h"

#include <string>

namespace fascicle::spirv_exact {

std::vector<Instruction> instructions_of(Module module) {
  if (module.size() < header_words || module[0] != spv::MagicNumber) throw ModuleError("not a SPIR-V module");
  std::vector<Instruction> instructions;
  std::size_t at = header_words;
  while (at < module.size()) {
    const std::size_t length = module[at] >> spv::WordCountShift;
    if (length == 0 || length > module.size() - at)
      throw ModuleError("SPIR-V instruction at word " + std::to_string(at) + " has a wrong length");
    instructions.push_back({static_cast<spv::Op>(module[at] & spv::OpCodeMask), module.subspan(at, length)});
    at += length;
  }
  return instructions;
}

bool is_float_arithmetic(spv::Op opcode) {
  switch (opcode) {
    case spv::OpFNegate:
    case spv::OpFAdd:
    case spv::OpFSub:
    case spv::OpFMul:
    case spv::OpFDiv:
    case spv::OpFRem:
    case spv::OpFMod:
    case spv::OpVectorTimesScalar:
    case spv::OpMatrixTimesScalar:
    case spv::OpVectorTimesMatrix:
    case spv::OpMatrixTimesVector:
    case spv::OpMatrixTimesMatrix:
    case spv::OpOuterProduct:
    case spv::OpDot:
      return true;
    default:
      return false;
  }
}

}  // namespace fascicle::spirv_exact
