#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "shaders/buffers.h"
#include "shaders/modules.h"
#include "shaders/spirv_exact/exact.h"
#include "tests/shaders/read_module.h"

namespace fascicle::tests {
namespace {

using spirv_exact::Instruction;
using spirv_exact::Module;
using spirv_exact::Words;

// All shaders except `copy`, which computes nothing.
std::vector<std::string> our_shaders() {
  std::vector<std::string> names;
  for (const std::string_view name : shader::module_names())
    if (name != "copy") names.emplace_back(name);
  return names;
}

std::size_t count_of(Module module, spv::Op opcode) {
  const auto instructions = spirv_exact::instructions_of(module);
  return static_cast<std::size_t>(std::count_if(instructions.begin(), instructions.end(),
                                                [&](const Instruction& i) { return i.opcode == opcode; }));
}

std::string all_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Shaders without float arithmetic: the pass has nothing to decorate.
bool only_compares(const std::string& shader) {
  return shader == "contact_bound" || shader == "contact_enclose" || shader == "contact_chain";
}

class OurShader : public testing::TestWithParam<std::string> {};

TEST_P(OurShader, PassesTheLint) {
  EXPECT_EQ(all_of(spirv_exact::lint(shader::module_of(GetParam()))), "");
}

// The control: straight from the compiler, every shader that computes is refused.
TEST_P(OurShader, WithoutThePassIsRefused) {
  EXPECT_EQ(spirv_exact::lint(read_raw_module(GetParam())).empty(), only_compares(GetParam()));
}

// Every decoration is needed: leaving one out is detected.
TEST_P(OurShader, OneUndecoratedOperationIsRefused) {
  if (only_compares(GetParam())) return;
  const Module exact = shader::module_of(GetParam());
  Words missing_one(exact.begin(), exact.begin() + spirv_exact::header_words);
  std::uint32_t left_out = 0;
  for (const Instruction& i : spirv_exact::instructions_of(exact)) {
    if (left_out == 0 && i.opcode == spv::OpDecorate && i.words[2] == spv::DecorationNoContraction)
      left_out = i.words[1];
    else
      missing_one.insert(missing_one.end(), i.words.begin(), i.words.end());
  }
  ASSERT_NE(left_out, 0u);
  const std::vector<std::string> faults = spirv_exact::lint(missing_one);
  ASSERT_EQ(faults.size(), 1u) << all_of(faults);
  EXPECT_NE(faults[0].find("without NoContraction, result %" + std::to_string(left_out)), std::string::npos)
      << faults[0];
}

TEST_P(OurShader, PassDoneTwiceChangesNothing) {
  const Module exact = shader::module_of(GetParam());
  EXPECT_EQ(spirv_exact::add_no_contraction(exact), Words(exact.begin(), exact.end()));
}

TEST_P(OurShader, TakesTheFloatControlsAndStaysValid) {
  const Module exact = shader::module_of(GetParam());
  EXPECT_EQ(spirv_exact::add_float_controls(exact, {}), Words(exact.begin(), exact.end()));
  const Words both = spirv_exact::add_float_controls(exact, {true, true});
  EXPECT_EQ(count_of(both, spv::OpExecutionMode), count_of(exact, spv::OpExecutionMode) + 2);
  EXPECT_EQ(count_of(both, spv::OpCapability), count_of(exact, spv::OpCapability) + 2);
  EXPECT_EQ(all_of(spirv_exact::lint(both)), "");
  const std::string path = testing::TempDir() + "fascicle_float_controls_" + GetParam() + ".spv";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(both.data()), static_cast<std::streamsize>(4 * both.size()));
  EXPECT_EQ(std::system((std::string(SPIRV_VAL) + " --target-env vulkan1.1 " + path).c_str()), 0);
  std::remove(path.c_str());
}

INSTANTIATE_TEST_SUITE_P(Shaders, OurShader, testing::ValuesIn(our_shaders()),
                         [](const auto& of) { return of.param; });

// Shaders with one forbidden operation each. The pass decorates what it can; the lint must still refuse them.
class Planted : public testing::TestWithParam<const char*> {};

TEST_P(Planted, IsRefusedByLintAndTool) {
  const std::string raw = std::string(PLANTED_DIR) + "/" + GetParam() + ".spv";
  EXPECT_FALSE(spirv_exact::lint(spirv_exact::add_no_contraction(read_module(raw))).empty());
  const std::string out = testing::TempDir() + "fascicle_planted_" + GetParam() + ".spv";
  std::remove(out.c_str());
  EXPECT_NE(std::system((std::string(SPIRV_EXACT) + " " + raw + " " + out + " 2>/dev/null").c_str()), 0);
  EXPECT_FALSE(std::ifstream(out).good()) << "the tool left a file though it refused the shader";
}

INSTANTIATE_TEST_SUITE_P(Shaders, Planted,
                         testing::Values("square_root", "division", "fused", "dot_product", "vector_sum",
                                         "double_precision", "subgroup_sum", "conversion", "atomic_sum"),
                         [](const auto& of) { return std::string(of.param); });

TEST(Lint, AnUndefinedValueIsRefused) {
  const Module exact = shader::module_of("goal");
  const auto instructions = spirv_exact::instructions_of(exact);
  const auto type_float = std::find_if(instructions.begin(), instructions.end(),
                                       [](const Instruction& i) { return i.opcode == spv::OpTypeFloat; });
  ASSERT_NE(type_float, instructions.end());
  Words with_undefined(exact.begin(), exact.end());
  const std::uint32_t new_id = with_undefined[3]++;  // the bound on ids, in the header
  const auto after = type_float->words.data() + type_float->words.size() - exact.data();
  const Words undefined{spirv_exact::first_word(spv::OpUndef, 3), type_float->words[1], new_id};
  with_undefined.insert(with_undefined.begin() + after, undefined.begin(), undefined.end());
  const std::vector<std::string> faults = spirv_exact::lint(with_undefined);
  ASSERT_EQ(faults.size(), 1u) << all_of(faults);
  EXPECT_NE(faults[0].find("undefined value"), std::string::npos) << faults[0];
}

TEST(Module, BrokenWordsAreRefused) {
  const Module whole = shader::module_of("goal");
  EXPECT_THROW(spirv_exact::instructions_of({}), spirv_exact::ModuleError);
  EXPECT_THROW(spirv_exact::instructions_of(whole.first(spirv_exact::header_words + 1)),
               spirv_exact::ModuleError);
  Words zero_length(whole.begin(), whole.end());
  zero_length[spirv_exact::header_words] &= 0xffff;
  EXPECT_THROW(spirv_exact::instructions_of(zero_length), spirv_exact::ModuleError);
  zero_length[0] = 0;
  EXPECT_THROW(spirv_exact::instructions_of(zero_length), spirv_exact::ModuleError);
}

TEST(Module, UsedBindingsAreThoseTheCodeTouches) {
  EXPECT_EQ(spirv_exact::used_bindings(shader::module_of("embed")),
            (std::vector<std::uint32_t>{shader::buffer_position, shader::buffer_surface,
                                        shader::buffer_surface_vertex, shader::buffer_surface_weight}));
  EXPECT_EQ(spirv_exact::used_bindings(shader::module_of("rebase")),
            (std::vector<std::uint32_t>{shader::buffer_position, shader::buffer_skinned,
                                        shader::buffer_position_before}));
}

}  // namespace
}  // namespace fascicle::tests
