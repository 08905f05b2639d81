// Makes a compiled shader exact: every device must compute the same bits, so no compiler may fuse,
// reassociate or flush the kernels' operations. GLSL's `precise` does not reach into called functions, so
// this works on SPIR-V.
#pragma once

#include <string>
#include <vector>

#include "shaders/spirv_exact/module.h"

namespace fascicle::spirv_exact {

// The module with NoContraction on the result of every float operation.
Words add_no_contraction(Module module);

// Modes of SPV_KHR_float_controls for 32-bit floats, if the device supports them.
struct FloatControls {
  bool rounding_rte = false;
  bool signed_zero_inf_nan_preserve = false;
};
// The module with these execution modes, their capabilities and the extension; unchanged if none is set.
Words add_float_controls(Module module, FloatControls controls);

// Lists whatever in the module could make bits differ between devices, one line each; empty if nothing. The
// module may use only operations on a list of harmless ones; of float arithmetic, only scalar 32-bit + - *
// and negation, each with NoContraction. This rejects division, extended instructions (square root, fma, min
// ...), conversions, vector and matrix arithmetic, other float widths, atomics and subgroup operations.
std::vector<std::string> lint(Module module);

// Binding numbers of the buffers that the module's code reads or writes, ascending.
std::vector<std::uint32_t> used_bindings(Module module);

}  // namespace fascicle::spirv_exact
