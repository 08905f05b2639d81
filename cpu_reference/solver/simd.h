// Which vector instructions the CPU solver uses. No result depends on it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace fascicle::cpu_reference {

// scalar: the readable stages of stages.h. baseline: four lanes with what every processor of its kind has
// (SSE2, NEON). sse4: four lanes with SSE4.1. avx2: eight. avx512: sixteen (F, BW, DQ and VL).
// automatic: the last of these that the machine has.
enum class Simd { automatic, scalar, baseline, sse4, avx2, avx512 };

const char* name_of(Simd level);
// Nothing for a word that is not a level.
std::optional<Simd> simd_named(std::string_view name);

// The levels of this machine and this build, ascending. Scalar and baseline are always there.
std::vector<Simd> available_simd();

}  // namespace fascicle::cpu_reference
