// The compiled, exact compute shaders, one function for each .comp file. Generated at build time.
#pragma once

#include <cstdint>
#include <span>

namespace fascicle::shader {

std::span<const std::uint32_t> rebase_module();
std::span<const std::uint32_t> skin_module();
std::span<const std::uint32_t> tie_module();
std::span<const std::uint32_t> predict_module();
std::span<const std::uint32_t> region_module();
std::span<const std::uint32_t> goal_module();
std::span<const std::uint32_t> relax_module();
std::span<const std::uint32_t> lack_module();
std::span<const std::uint32_t> crowd_module();
std::span<const std::uint32_t> limit_module();
std::span<const std::uint32_t> integrate_module();
std::span<const std::uint32_t> update_module();
std::span<const std::uint32_t> iterate_module();
std::span<const std::uint32_t> embed_module();
std::span<const std::uint32_t> self_test_module();
std::span<const std::uint32_t> copy_module();

}  // namespace fascicle::shader
