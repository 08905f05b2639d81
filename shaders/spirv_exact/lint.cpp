#include <algorithm>
#include <array>
#include <set>

#include "shaders/spirv_exact/exact.h"

namespace fascicle::spirv_exact {
namespace {

struct Range {
  std::uint16_t first, last;
};

// Opcodes that compute no float, or are checked further below. What is not here is refused: division (136),
// extended instructions (12), conversions (109 to 118), dot and matrix products (142 to 148), derivatives
// (207 to 215), atomics (227 to 242), subgroup operations (333 to 366) and all that a later compiler may come
// to emit.
constexpr std::array<Range, 38> harmless{{
    {0, 1},        // nop, undef
    {3, 8},        // source, names, lines
    {10, 11},      // extension, import of an instruction set
    {14, 17},      // memory model, entry point, execution mode, capability
    {19, 23},      // void, bool, int, float, vector
    {28, 30},      // array, runtime array, struct
    {32, 33},      // pointer, function
    {41, 44},      // constants
    {46, 46},      // null
    {48, 52},      // specialisation constants
    {54, 57},      // functions and calls
    {59, 59},      // variable
    {61, 63},      // load, store, copy
    {65, 66},      // access chains
    {68, 68},      // array length
    {71, 72},      // decorations
    {79, 83},      // vectors and composites, copied
    {124, 124},    // bitcast
    {126, 126},    // integer negate
    {127, 127},    // float negate
    {128, 128},    // integer add
    {129, 129},    // float add
    {130, 130},    // integer subtract
    {131, 131},    // float subtract
    {132, 132},    // integer multiply
    {133, 133},    // float multiply
    {134, 135},    // integer divide
    {137, 139},    // integer remainders
    {164, 179},    // logical and integer comparisons, select
    {180, 191},    // float comparisons
    {194, 200},    // shifts and bits
    {245, 251},    // phi, merges, label, branches, switch
    {253, 255},    // returns, unreachable
    {317, 317},    // no line
    {330, 330},    // module processed
    {400, 400},    // copy logical
    {5632, 5632},  // decorate id
    {5633, 5633},  // decorate string
}};

bool is_harmless(Opcode opcode) {
  const auto number = static_cast<std::uint16_t>(opcode);
  return std::any_of(harmless.begin(), harmless.end(),
                     [&](const Range& r) { return r.first <= number && number <= r.last; });
}

// Shader, and the two that add_float_controls brings.
bool is_harmless_capability(std::uint32_t capability) {
  return capability == 1 || capability == 4466 || capability == 4467;
}

}  // namespace

std::vector<std::string> lint(Module module) {
  const std::vector<Instruction> instructions = instructions_of(module);
  std::set<std::uint32_t> decorated, scalar_floats;
  std::vector<std::string> faults;
  const auto fault = [&](const Instruction& i, const std::string& what) {
    const auto at = i.words.data() - module.data();
    faults.push_back("word " + std::to_string(at) + ", opcode " +
                     std::to_string(static_cast<std::uint16_t>(i.opcode)) + ": " + what);
  };
  for (const Instruction& i : instructions) {
    if (i.opcode == Opcode::decorate && i.words[2] == decoration_no_contraction) decorated.insert(i.words[1]);
    if (i.opcode == Opcode::type_float && i.words[2] == 32) scalar_floats.insert(i.words[1]);
  }
  for (const Instruction& i : instructions) {
    if (is_float_arithmetic(i.opcode) && !decorated.contains(i.words[2]))
      fault(i, "float operation without NoContraction, result %" + std::to_string(i.words[2]));
    if (!is_harmless(i.opcode)) {
      fault(i, i.opcode == Opcode::ext_inst ? "extended instruction number " + std::to_string(i.words[4])
                                            : std::string("operation not on the list of harmless ones"));
      continue;
    }
    // An undefined value is whatever a driver likes, and need not be the same at each use.
    if (i.opcode == Opcode::undef) fault(i, "undefined value");
    if (is_float_arithmetic(i.opcode) && !scalar_floats.contains(i.words[1]))
      fault(i, "float arithmetic on something other than a 32-bit scalar");
    if ((i.opcode == Opcode::type_float || i.opcode == Opcode::type_int) && i.words[2] != 32)
      fault(i, "number of " + std::to_string(i.words[2]) + " bits");
    if (i.opcode == Opcode::spec_constant_op && is_float_arithmetic(static_cast<Opcode>(i.words[3])))
      fault(i, "float arithmetic on specialisation constants");
    if (i.opcode == Opcode::capability && !is_harmless_capability(i.words[1]))
      fault(i, "capability " + std::to_string(i.words[1]));
    const bool relaxed = (i.opcode == Opcode::decorate && i.words[2] == decoration_relaxed_precision) ||
                         (i.opcode == Opcode::member_decorate && i.words[3] == decoration_relaxed_precision);
    if (relaxed) fault(i, "relaxed precision");
  }
  return faults;
}

}  // namespace fascicle::spirv_exact
