// CpuSolver compiled again with FASCICLE_NO_SNAP. Kernels are templates in headers and stages have fixed
// names: without renaming, the linker would merge this version with the first.
#define FASCICLE_NO_SNAP
#define kernel kernel_without_snap
#define cpu_reference cpu_reference_without_snap
#include "cpu_reference/solver/collide_reach.cpp"
#include "cpu_reference/solver/collide_stages.cpp"
#include "cpu_reference/solver/contact_rest.cpp"
#include "cpu_reference/solver/contact_search.cpp"
#include "cpu_reference/solver/contact_stages.cpp"
#include "cpu_reference/solver/cpu_solver.cpp"
#include "cpu_reference/solver/fields.cpp"
#include "cpu_reference/solver/huge_pages.cpp"
#include "cpu_reference/solver/lane_stages.cpp"
#include "cpu_reference/solver/slices.cpp"
#include "cpu_reference/solver/stages.cpp"
#include "cpu_reference/solver/sweeps.cpp"
#include "cpu_reference/solver/thread_pool.cpp"

// Only the lanes that need no compiler options; the others are in without_snap_lanes.cpp.
namespace fascicle::cpu_reference {
const LaneStages* sse4_lane_stages() {
  return nullptr;
}
const LaneStages* avx2_lane_stages() {
  return nullptr;
}
const LaneStages* avx512_lane_stages() {
  return nullptr;
}
}  // namespace fascicle::cpu_reference
