#include "shaders/spirv_exact/module.h"

#include <string>

namespace fascicle::spirv_exact {

std::vector<Instruction> instructions_of(Module module) {
  constexpr std::uint32_t magic = 0x07230203;
  if (module.size() < header_words || module[0] != magic) throw ModuleError("not a SPIR-V module");
  std::vector<Instruction> instructions;
  std::size_t at = header_words;
  while (at < module.size()) {
    const std::size_t length = module[at] >> 16;
    if (length == 0 || length > module.size() - at)
      throw ModuleError("SPIR-V instruction at word " + std::to_string(at) + " has a wrong length");
    instructions.push_back({static_cast<Opcode>(module[at] & 0xffff), module.subspan(at, length)});
    at += length;
  }
  return instructions;
}

bool is_float_arithmetic(Opcode opcode) {
  switch (static_cast<std::uint16_t>(opcode)) {
    case 127:  // OpFNegate
    case 129:  // OpFAdd
    case 131:  // OpFSub
    case 133:  // OpFMul
    case 136:  // OpFDiv
    case 140:  // OpFRem
    case 141:  // OpFMod
    case 142:  // OpVectorTimesScalar
    case 143:  // OpMatrixTimesScalar
    case 144:  // OpVectorTimesMatrix
    case 145:  // OpMatrixTimesVector
    case 146:  // OpMatrixTimesMatrix
    case 147:  // OpOuterProduct
    case 148:  // OpDot
      return true;
    default:
      return false;
  }
}

}  // namespace fascicle::spirv_exact
