// Which vector instructions the CPU solver uses. No result depends on it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace fascicle::cpu_reference {

// scalar: the readable stages of stages.h. baseline: four lanes with the architecture's baseline (SSE2,
// NEON). sse4: four lanes with SSE4.1. avx2: eight. avx512: sixteen (F, BW, DQ and VL). automatic: the last
// of these that the machine supports.
enum class Simd { automatic, scalar, baseline, sse4, avx2, avx512 };

const char* name_of(Simd level);
// Nothing if the word is not a level.
std::optional<Simd> simd_named(std::string_view name);

// The levels that this machine and this build support, ascending. Scalar and baseline are always included.
std::vector<Simd> available_simd();

}  // namespace fascicle::cpu_reference
