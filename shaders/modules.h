// The compiled, exact compute shaders. Generated at build time from the .comp files of this folder.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace fascicle::shader {

// The SPIR-V of NAME.comp. Throws std::invalid_argument if there is no such file.
std::span<const std::uint32_t> module_of(std::string_view name);

// All names, in alphabetical order.
std::span<const std::string_view> module_names();

}  // namespace fascicle::shader
