// The lane stages of without_snap.cpp.
#define FASCICLE_NO_SNAP
#define kernel kernel_without_snap
#define cpu_reference cpu_reference_without_snap
#include "cpu_reference/solver/lane_stages_baseline.cpp"
