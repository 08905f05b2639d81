// The wording of errors and warnings.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/build/build.h"

namespace fascicle::build {

// "3, 7, 12 and 40 more"
std::string list_of(std::span<const std::uint32_t> ids);

// "1 vertex", "2 vertices"
std::string counted(std::size_t count, const std::string& one, const std::string& many);

// Throws scene::SceneError "SOURCE: WHAT".
[[noreturn]] void fail(const std::string& source, const std::string& what);

// Adds a warning that lists the first few of `vertices`.
void warn(Report& report, const std::string& text, std::span<const std::uint32_t> vertices = {});
// The same, for warnings about soft flesh only: a robot, which has none, does not get them.
void warn_of_flesh(Report& report, const std::string& text, std::span<const std::uint32_t> vertices = {});

}  // namespace fascicle::build
