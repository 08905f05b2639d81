#define DECAY_FUNCTION decay_with_snap
#include "tests/shaders/decay_under_flush.inc"
