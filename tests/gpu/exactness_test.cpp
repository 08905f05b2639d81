// Controls of the exactness rules, on whole stages.
#include <string>

#include <gtest/gtest.h>

#include "cpu_reference/solver/cpu_solver.h"
#include "gpu/experiments.h"
#include "host/model/validate.h"
#include "tests/gpu/vulkan_device.h"
#include "tests/shaders/read_module.h"
#include "tests/support/bar_model.h"

namespace fascicle::tests {
namespace {

class Exactness : public VulkanTest {};

std::optional<model::Difference> difference_with(std::uint32_t index, gpu::StageKernel altered,
                                                 const gpu::AlterModule& alter) {
  const model::Model m = make_bar({.skeleton = true, .muscle = true});
  gpu::Device device(index);
  const gpu::Experiments experiments{
      .leave_out_float_controls = true,
      .alter_module = [&](gpu::StageKernel kernel, spirv_exact::Module module) {
        return kernel == altered ? alter(kernel, module) : spirv_exact::Words(module.begin(), module.end());
      }};
  const auto vulkan = gpu::make_experimental_solver(device, m, {}, experiments);
  const auto cpu = cpu_reference::make_cpu_solver(m, {}, 1);
  BarMotion motion(m, 2);
  return first_difference(
      *cpu, *vulkan, [&](std::uint64_t k) { return motion.drive(k); }, 5);
}

spirv_exact::Words without_the_pass(gpu::StageKernel kernel, spirv_exact::Module) {
  return read_raw_module(std::string(name_of(kernel)));
}

// Needs a compiler that reassociates; Mesa's is known to.
TEST_F(Exactness, RegionWithoutNoContractionDiffers) {
  const bool is_software = gpu::Device(*index).info().software;
  ASSERT_TRUE(is_software || !vulkan_is_required()) << "this control needs a software device";
  if (!is_software) GTEST_SKIP() << "SKIPPED, CONTROL NOT RUN: this driver may not reorder anything";
  const auto difference = difference_with(*index, gpu::StageKernel::region, without_the_pass);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->where.stage, model::Stage::region);
}

// The same setup without the alteration finds no difference, so the one above is due to the missing
// decoration.
TEST_F(Exactness, RegionWithThePassDoesNot) {
  const auto difference =
      difference_with(*index, gpu::StageKernel::region, [](gpu::StageKernel kernel, spirv_exact::Module) {
        return spirv_exact::add_no_contraction(read_raw_module(std::string(name_of(kernel))));
      });
  EXPECT_FALSE(difference);
}

}  // namespace
}  // namespace fascicle::tests
