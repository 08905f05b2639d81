// The kernels are templates in headers. Without another name, the linker would merge this version with the
// first.
#define FASCICLE_NO_SNAP
#define kernel kernel_without_snap
#define DECAY_FUNCTION decay_without_snap
#include "tests/shaders/decay_under_flush.inc"
