// A SPIR-V module as a list of instructions, for the tool that makes shaders exact. Numbers are those of the
// SPIR-V specification, version 1.3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace fascicle::spirv_exact {

using Words = std::vector<std::uint32_t>;
using Module = std::span<const std::uint32_t>;

// The words are not a SPIR-V module; says why.
struct ModuleError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Opcode : std::uint16_t {
  undef = 1,
  extension = 10,
  ext_inst_import = 11,
  ext_inst = 12,
  memory_model = 14,
  entry_point = 15,
  execution_mode = 16,
  capability = 17,
  type_int = 21,
  type_float = 22,
  type_matrix = 24,
  type_struct = 30,
  spec_constant_op = 52,
  load = 61,
  store = 62,
  access_chain = 65,
  in_bounds_access_chain = 66,
  decorate = 71,
  member_decorate = 72,
  f_negate = 127,
  f_add = 129,
  f_sub = 131,
  f_mul = 133,
};

inline constexpr std::uint32_t decoration_relaxed_precision = 0;
inline constexpr std::uint32_t decoration_binding = 33;
inline constexpr std::uint32_t decoration_offset = 35;
inline constexpr std::uint32_t decoration_no_contraction = 42;

inline constexpr std::uint32_t header_words = 5;

// One instruction; words[0] holds the opcode and the length.
struct Instruction {
  Opcode opcode;
  std::span<const std::uint32_t> words;
};

// The instructions of a module in order. Throws ModuleError if the header or an instruction's length is
// wrong.
std::vector<Instruction> instructions_of(Module module);

// Whether the instruction computes a float from floats. Its result id is words[2].
bool is_float_arithmetic(Opcode opcode);

inline std::uint32_t first_word(Opcode opcode, std::uint32_t length) {
  return (length << 16) | static_cast<std::uint32_t>(opcode);
}

}  // namespace fascicle::spirv_exact
