// A SPIR-V module as a list of instructions, for the tool that makes shaders exact. Numbers use the names in
// Khronos' header: spv::OpLoad, spv::DecorationBinding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

#include <spirv/unified1/spirv.hpp>

namespace fascicle::spirv_exact {

using Words = std::vector<std::uint32_t>;
using Module = std::span<const std::uint32_t>;

// The words are not a SPIR-V module; the message says why.
struct ModuleError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr std::uint32_t header_words = 5;

// One instruction; words[0] holds the opcode and the length.
struct Instruction {
  spv::Op opcode;
  std::span<const std::uint32_t> words;
};

// The instructions of a module in order. Throws ModuleError if the header or an instruction's length is
// invalid.
std::vector<Instruction> instructions_of(Module module);

// Whether the instruction computes a float from floats. Its result id is words[2].
bool is_float_arithmetic(spv::Op opcode);

inline std::uint32_t first_word(spv::Op opcode, std::uint32_t length) {
  return (length << spv::WordCountShift) | static_cast<std::uint32_t>(opcode);
}

}  // namespace fascicle::spirv_exact
