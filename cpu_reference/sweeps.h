// Both stages of a substep in one pass over the body, so that a region's map is used while it is in a cache:
// regions go ahead of the vertices by as much as the vertices' one-rings reach ("wavefront").
//
// A vertex may be moved as soon as every region that reads its position is done. One-rings are symmetric:
// these are the regions of its own one-ring, the very ones whose maps its goal takes. So the pass works in
// place.
//
// For threads the body is cut into sweeps. Regions that share a vertex with another sweep are done for all
// sweeps first, and then each sweep moves its own vertices: what is still to be done elsewhere reads none of
// them.
#pragma once

#include <cstdint>
#include <vector>

#include "cpu_reference/lane_stages.h"
#include "cpu_reference/slices.h"
#include "cpu_reference/stages.h"
#include "host/model/model.h"

namespace fascicle::cpu_reference {

struct Sweep {
  Range slices;
  // Slices of regions in [slices.first, front) and in [back, slices.last) may share a vertex with another
  // sweep; front <= back.
  std::uint32_t front, back;
};

// Bodies of fewer vertices stay in a processor's last cache, and gain nothing (bench/README.md).
inline constexpr std::uint32_t fewest_swept_vertices = 150'000;

// Sweeps for so many threads; none where the body has fewer vertices than `fewest`, or is numbered so widely
// that too little of it lies inside the sweeps.
std::vector<Sweep> make_sweeps(const model::Model& model, const Slices& slices, unsigned threads,
                               std::uint32_t fewest = fewest_swept_vertices);

// The regions of a sweep that others share.
void run_shared_regions(const LaneStages& stages, const LaneInput& in, const Sweep& sweep);
// The other regions, and `move` (update or iterate) of the sweep's vertices.
void run_sweep(const LaneStages& stages, LaneStage move, const LaneInput& in, const Sweep& sweep);

}  // namespace fascicle::cpu_reference
