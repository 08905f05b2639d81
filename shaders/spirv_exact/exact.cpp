#include "shaders/spirv_exact/exact.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <set>

namespace fascicle::spirv_exact {
namespace {

void append(Words& out, std::span<const std::uint32_t> words) {
  out.insert(out.end(), words.begin(), words.end());
}

bool is_annotation(spv::Op opcode) {
  return opcode == spv::OpDecorate || opcode == spv::OpMemberDecorate;
}

// A literal string in a module: its bytes, a zero, and zeros up to a whole word.
Words words_of(const std::string& text) {
  Words words(text.size() / 4 + 1, 0);
  std::memcpy(words.data(), text.data(), text.size());
  return words;
}

}  // namespace

Words add_no_contraction(Module module) {
  const std::vector<Instruction> instructions = instructions_of(module);
  std::set<std::uint32_t> decorated;
  for (const Instruction& i : instructions)
    if (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationNoContraction)
      decorated.insert(i.words[1]);

  Words decorations;
  for (const Instruction& i : instructions)
    if (is_float_arithmetic(i.opcode) && !decorated.contains(i.words[2]))
      append(decorations, Words{first_word(spv::OpDecorate, 3), i.words[2], spv::DecorationNoContraction});

  Words out(module.begin(), module.begin() + header_words);
  bool placed = false;
  for (const Instruction& i : instructions) {
    if (!placed && is_annotation(i.opcode)) {
      append(out, decorations);
      placed = true;
    }
    append(out, i.words);
  }
  if (!placed && !decorations.empty())
    throw ModuleError("SPIR-V module has no annotations to place NoContraction among");
  return out;
}

Words add_float_controls(Module module, FloatControls controls) {
  std::vector<std::uint32_t> capabilities, modes;
  if (controls.rounding_rte) {
    capabilities.push_back(spv::CapabilityRoundingModeRTE);
    modes.push_back(spv::ExecutionModeRoundingModeRTE);
  }
  if (controls.signed_zero_inf_nan_preserve) {
    capabilities.push_back(spv::CapabilitySignedZeroInfNanPreserve);
    modes.push_back(spv::ExecutionModeSignedZeroInfNanPreserve);
  }
  if (modes.empty()) return Words(module.begin(), module.end());

  // The order of a module: capabilities, extensions, imports, memory model, entry points, execution modes.
  const std::vector<Instruction> instructions = instructions_of(module);
  Words out(module.begin(), module.begin() + header_words);
  std::uint32_t entry_point = 0;
  bool extension_placed = false, modes_placed = false;
  for (const Instruction& i : instructions) {
    if (!extension_placed && i.opcode != spv::OpCapability) {
      for (const std::uint32_t c : capabilities)
        append(out, std::vector{first_word(spv::OpCapability, 2), c});
      const Words name = words_of("SPV_KHR_float_controls");
      out.push_back(first_word(spv::OpExtension, static_cast<std::uint32_t>(name.size() + 1)));
      append(out, name);
      extension_placed = true;
    }
    if (i.opcode == spv::OpEntryPoint) entry_point = i.words[2];
    if (!modes_placed && i.opcode == spv::OpExecutionMode) {
      for (const std::uint32_t m : modes)
        append(out, std::vector{first_word(spv::OpExecutionMode, 4), entry_point, m, 32u});
      modes_placed = true;
    }
    append(out, i.words);
  }
  if (!modes_placed)
    throw ModuleError("SPIR-V module has no execution mode; a compute shader has its local size");
  return out;
}

std::vector<std::uint32_t> used_bindings(Module module) {
  std::map<std::uint32_t, std::uint32_t> binding_of;  // variable to binding
  std::set<std::uint32_t> used;
  for (const Instruction& i : instructions_of(module)) {
    if (i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationBinding)
      binding_of[i.words[1]] = i.words[3];
    if (i.opcode == spv::OpAccessChain || i.opcode == spv::OpInBoundsAccessChain)
      if (const auto found = binding_of.find(i.words[3]); found != binding_of.end())
        used.insert(found->second);
  }
  return {used.begin(), used.end()};
}

}  // namespace fascicle::spirv_exact
