// The kernels are templates in headers: under their own name this second version would be merged with the
// first at link time.
#define FASCICLE_NO_SNAP
#define kernel kernel_without_snap
#define DECAY_FUNCTION decay_without_snap
#include "tests/shaders/decay_under_flush.inc"
